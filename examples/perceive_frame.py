"""Find the objects in one depth image: python examples/perceive_frame.py [FRAME]."""

import sys

from eyehand.perception import perceive, read_frame


def main(path):
    scene = perceive(read_frame(path))
    for item in scene.objects:
        solid = item.fit.superquadric
        if solid is None:
            print(f"object {item.label}: {item.fit.reason}")
            continue
        size = " x ".join(f"{2000 * axis:.0f}" for axis in solid.semi_axes)
        print(f"object {item.label}: {solid.kind}, {size} mm, at {solid.centre.round(3)} m")
    for warning in scene.warnings:
        print("warning:", warning.message)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "apps/sample/depth.png")
