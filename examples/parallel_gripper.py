"""Rank the grasps of your own parallel gripper: python examples/parallel_gripper.py [FRAME]."""

import sys
from dataclasses import replace

from eyehand.grasping import load_hand, plan_grasps
from eyehand.perception import perceive, read_frame


def main(path):
    # A Panda hand with fingers that open only 60 mm. `eyehand hand describe` reads other grippers.
    hand = replace(load_hand("panda"), name="narrow", stroke=0.06)
    grasps = plan_grasps(perceive(read_frame(path)), hand)
    if not grasps:
        print("no grasp:", grasps.reason)
    for grasp in grasps[:5]:
        verdict = "safe" if grasp.safe else ", ".join(grasp.forbidden_by)
        place = grasp.position.round(3)
        print(f"object {grasp.object_label}: {grasp.success:.0%} at {place} m, {verdict}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "apps/sample/depth.png")
