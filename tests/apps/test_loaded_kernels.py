"""Loading the kernels leaves none for the first frame, so that its times need no second run."""

import subprocess
import sys
from pathlib import Path

SAMPLE = Path(__file__).resolve().parents[2] / "apps" / "sample" / "depth.png"
SCRIPT = """
import sys
from eyehand.apps.grasp_command import WIDE_HAND
from eyehand.apps.perceived_frame import load_kernels, perceive_and_plan, plan_scene
from eyehand.grasping import load_hand, plan_grasps
from eyehand.perception import read_frame

def compiled():
    return {
        (kernel.py_func.__module__, name): len(kernel.signatures)
        for module in list(sys.modules.values()) if module.__name__.startswith("eyehand")
        for name, kernel in vars(module).items() if hasattr(kernel, "nopython_signatures")
    }

scene = load_kernels()
assert any(plan_scene(scene).values())
assert plan_grasps(scene, load_hand(WIDE_HAND))
before = compiled()
found = perceive_and_plan(read_frame(sys.argv[1]))
plan_grasps(found.scene, load_hand("panda"))
print([name for name, count in compiled().items() if count != before.get(name)])
"""


def test_first_frame_loads_no_kernel():
    words = [sys.executable, "-c", SCRIPT, SAMPLE]
    done = subprocess.run(words, capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout.splitlines()[-1] == "[]"
