"""Visual meshes against collision shapes."""

from pathlib import Path

import numpy as np
import pytest

from eyehand.control import RobotModel, visual_gaps
from eyehand.control.visual_check import FAR

CORNERS = " ".join(
    f"{x} {y} {z}" for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)
)
ARM = """<mujoco><asset><mesh name="cube" vertex="{corners}"/></asset><worldbody>
<body name="one"><joint name="a" axis="0 0 1" range="-60 60"/><geom type="box" size=".04 .05 .05"/>
<geom type="mesh" mesh="cube" contype="0" conaffinity="0"/>
<body name="two" pos="0 0 .5"><joint name="b" axis="0 1 0" range="-60 60"/>
<geom type="box" size=".06 .06 .06"/>
<geom type="mesh" mesh="cube" contype="0" conaffinity="0"/><site name="tip"/></body></body>
</worldbody></mujoco>"""
ROBOTS = Path(__file__).resolve().parents[3] / "shared" / "robots"


def test_gap_of_a_cube_around_a_thinner_box_is_exact():
    robot = RobotModel.load(ARM.format(corners=CORNERS), "tip", home=[0.3, 0.2])
    (found,) = visual_gaps(robot)
    assert found.link == "one"
    assert found.gap == pytest.approx(0.01, abs=1e-6)
    assert abs(found.point[0]) == pytest.approx(0.05)


def test_robot_without_collision_shapes_has_no_gap_and_a_bare_link_the_largest():
    bare = ARM.format(corners=CORNERS)
    for size in (".04 .05 .05", ".06 .06 .06"):
        bare = bare.replace(f'<geom type="box" size="{size}"/>', "")
    assert visual_gaps(RobotModel.load(bare, "tip")) == ()
    far = bare.replace(
        "<worldbody>", '<worldbody><body pos="9 0 0"><geom type="sphere" size=".1"/></body>'
    )
    assert all(
        one.gap == pytest.approx(FAR, rel=1e-3) for one in visual_gaps(RobotModel.load(far, "tip"))
    )


def test_gaps_of_a_ur5e_are_those_of_its_capsules():
    file = ROBOTS / "universal_robots_ur5e" / "ur5e.xml"
    if not file.is_file():
        pytest.skip(f"no robot files at {ROBOTS}")
    gaps = visual_gaps(RobotModel.load(file, "attachment_site"))
    # The base does not move, so it is left out.
    assert "base" not in [one.link for one in gaps]
    assert gaps[0].link == "upper_arm_link"
    # Capsules around the elbow: of the upper arm (radius 0.05 m, on z from 0 to 0.4 m), and of the
    # forearm (0.055 m, on y up to 0.009 m at z = 0.425 m).
    x, y, z = gaps[0].point
    own = np.hypot(np.hypot(x, y), max(z - 0.4, 0.0)) - 0.05
    child = np.hypot(np.hypot(x, max(y - 0.009, 0.0)), z - 0.425) - 0.055
    assert gaps[0].gap == pytest.approx(min(own, child), abs=1e-6)
    assert gaps[0].gap == pytest.approx(0.0265, abs=2e-4)


def test_gaps_of_a_panda_are_millimetres():
    file = ROBOTS / "franka_emika_panda" / "panda.xml"
    if not file.is_file():
        pytest.skip(f"no robot files at {ROBOTS}")
    gaps = visual_gaps(RobotModel.load(file, "hand"))
    assert gaps[0].link == "link5"
    assert gaps[0].gap == pytest.approx(0.0056, abs=1e-4)
    assert all(np.isfinite(one.point).all() for one in gaps)
