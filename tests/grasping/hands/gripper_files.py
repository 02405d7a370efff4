"""Files of made-up grippers with known measures, as MJCF and URDF texts."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

LINK = """<link name="{name}"><collision><origin xyz="{at}"/><geometry>
{shape}</geometry></collision></link>"""


def box(size: str) -> str:
    return f'<box size="{size}"/>'


def urdf_joint(name: str, kind: str, child: str, at: str, axis: str, more: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="base"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def rack_and_pinion(shape: str = box("0.012 0.02 0.06"), base: str = box("0.14 0.06 0.08")) -> str:
    """URDF: one motor, two slides by a mimic joint; 0 to 90 mm, fingers of 60 mm, tip at 140 mm."""
    limit = '<limit lower="0" upper="0.045" effort="30" velocity="1"/>'
    return (
        '<robot name="rack">'
        + LINK.format(name="base", at="0 0 0.04", shape=base)
        + LINK.format(name="left", at="0.006 0 0.03", shape=shape)
        + LINK.format(name="right", at="-0.006 0 0.03", shape=shape)
        + urdf_joint("rack_joint", "prismatic", "left", "0 0 0.08", "1 0 0", limit)
        + urdf_joint(
            "follow_joint",
            "prismatic",
            "right",
            "0 0 0.08",
            "-1 0 0",
            limit + '<mimic joint="rack_joint" multiplier="1"/>',
        )
        + "</robot>"
    )


INDEPENDENT = """<mujoco><worldbody><body name="wrist">
<geom type="box" size=".06 .03 .03" pos="0 0 .03"/>
<geom name="camera_mount" type="box" size=".01 .01 .02" pos="0 .05 .05"/>
<body name="a" pos="0 0 .06"><joint name="ja" type="slide" axis="1 0 0" range="0 .03"/>
  <geom type="box" size=".005 .01 .02" pos=".005 0 .02"/>
  <geom type="box" size=".002 .008 .006" pos="-.002 0 .034"/></body>
<body name="b" pos="0 0 .06"><joint name="jb" type="slide" axis="1 0 0" range="-.03 0"/>
  <geom type="box" size=".005 .01 .02" pos="-.005 0 .02"/>
  <geom type="box" size=".002 .008 .006" pos=".002 0 .034"/></body>
</body></worldbody><actuator>
<position joint="ja" kp="100" forcerange="-25 25"/>
<position joint="jb" kp="100" forcerange="-25 25"/>
</actuator></mujoco>"""
"""MJCF: two motors. Small pads of 12 x 16 mm stand 4 mm out of the fingers; 0 to 52 mm, as the pads
touch 4 mm before the ends of the slides."""

PARALLELOGRAM = """<mujoco><compiler angle="radian"/><worldbody><body name="base">
<geom type="box" size=".03 .02 .03" pos="0 0 .03"/>
{left}{right}
</body></worldbody><equality>
<connect body1="left_tip" body2="left_inner" anchor="-.02 0 0"/>
<connect body1="right_tip" body2="right_inner" anchor="-.02 0 0"/>
<joint joint1="left_outer" joint2="right_outer"/></equality>
<actuator><motor joint="right_outer" ctrlrange="-2 2" ctrllimited="true"/></actuator></mujoco>"""
SIDE = """<body name="{s}_outer_link" pos="{x} 0 .06" euler="0 0 {turn}">
<joint name="{s}_outer" axis="0 1 0" range="-.6 .6"/>
<geom type="box" size=".003 .005 .03" pos="0 0 .03"/>
<body name="{s}_tip" pos="0 0 .06"><joint name="{s}_tip_joint" axis="0 1 0" range="-1 1"/>
<geom type="box" size=".017 .008 .003" pos="-.015 0 0"/>
<geom type="box" size=".003 .01 .025" pos="-.03 0 .025"/></body></body>
<body name="{s}_inner" pos="{y} 0 .06" euler="0 0 {turn}">
<joint name="{s}_inner_joint" axis="0 1 0" range="-1 1"/>
<geom type="box" size=".003 .005 .03" pos="0 0 .03"/></body>"""


def parallelogram() -> str:
    """MJCF: two parallelograms of rods of 60 mm, closed by <connect>, one motor.

    The pad's face is 33 mm inside its outer joint, which stands at 55 mm. So the pads are
    2 (22 + 60 sin q) mm apart, and touch before the joint's limit of -0.6.
    """
    left = SIDE.format(s="left", x=0.055, y=0.035, turn=0)
    right = SIDE.format(s="right", x=-0.055, y=-0.035, turn=np.pi)
    return PARALLELOGRAM.format(left=left, right=right)


ONE_JAW = """<mujoco><worldbody><body name="arm"><joint name="lift" axis="0 0 1" range="-90 90"/>
<geom type="box" size=".02 .02 .05"/>
<body name="palm" pos="0 0 .06">
<geom type="box" size=".05 .02 .01"/>
<geom type="box" size=".004 .012 .03" pos="-.04 0 .04"/>
<body name="jaw" pos="-.036 0 .01"><joint name="slide" type="slide" axis="1 0 0" range="0 .06"/>
<geom type="box" size=".004 .012 .03" pos=".004 0 .03"/></body>
</body></body></worldbody></mujoco>"""
"""MJCF: one jaw slides against a fixed one on the last link of an arm; 0 to 60 mm."""

SWAPPED = """<mujoco><worldbody><body name="tool" euler="20 30 40">
<geom type="box" size=".04 .05 .02" pos="-.04 0 0"/>
<body name="up"><joint name="ju" type="slide" axis="0 0 1" range="0 .02"/>
  <geom type="capsule" size=".006" fromto="0 0 .006 .044 0 .006"/></body>
<body name="down"><joint name="jd" type="slide" axis="0 0 -1" range="0 .02"/>
  <geom type="capsule" size=".006" fromto="0 0 -.006 .044 0 -.006"/></body>
</body></worldbody><tendon><fixed name="both">
<joint joint="ju" coef="1"/><joint joint="jd" coef="1"/></fixed></tendon>
<actuator><motor tendon="both" ctrllimited="true" ctrlrange="-8 8"/></actuator>
</mujoco>"""
"""MJCF: round fingers along x that close along z, driven by one tendon; 0 to 40 mm, 8 N, 50 mm."""

BOTH_WAYS = """<mujoco><worldbody><body name="bar">
<geom type="box" size=".03 .01 .01"/>{site}
<body name="one"><joint name="j1" type="slide" axis="1 0 0" range="0 .02"/>
  <geom type="box" size=".004 .01 .05" pos=".004 0 0"/></body>
<body name="two"><joint name="j2" type="slide" axis="-1 0 0" range="0 .02"/>
  <geom type="box" size=".004 .01 .05" pos="-.004 0 0"/></body>
</body></worldbody><equality><joint joint1="j1" joint2="j2"/></equality></mujoco>"""
"""MJCF: fingers that reach as far up as down. Only a site determines the approach direction."""

SHORT_OF_CLOSING = """<robot name="short">
<link name="base"><collision><origin xyz="0 0 .03"/><geometry><box size=".08 .06 .06"/></geometry>
</collision></link>
{links}
<joint name="drive" type="revolute"><parent link="base"/><child link="left"/>
<origin xyz="0 .02 .06"/><axis xyz="1 0 0"/>
<limit lower="-.7" upper=".1" effort="4" velocity="1"/></joint>
<joint name="left_turn" type="revolute"><parent link="left"/><child link="left_pad"/>
<origin xyz="0 0 .06"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="4" velocity="1"/>
<mimic joint="drive" multiplier="-1"/></joint>
<joint name="right_drive" type="revolute"><parent link="base"/><child link="right"/>
<origin xyz="0 -.02 .06"/><axis xyz="1 0 0"/><limit lower="-.7" upper=".7" effort="4" velocity="1"/>
<mimic joint="drive" multiplier="-1"/></joint>
<joint name="right_turn" type="revolute"><parent link="right"/><child link="right_pad"/>
<origin xyz="0 0 .06"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="4" velocity="1"/>
<mimic joint="drive"/></joint></robot>""".format(
    links="".join(
        LINK.format(name=name, at=f"0 0 {length / 2}", shape=box(f".02 .012 {length}"))
        for side in ("left", "right")
        for name, length in ((side, 0.06), (f"{side}_pad", 0.04))
    )
)
"""URDF: parallel pads of mimic joints. The drive ends 16 mm before they meet, the other joints do
not."""


def cube_stl(size: tuple[float, float, float]) -> bytes:
    """Return a binary STL of a box in mm around the origin."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = 500.0 * corners * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    text = b"\0" * 80 + struct.pack("<I", 12)
    for a, b, c, d in quads:
        for three in ((a, b, c), (a, c, d)):
            text += struct.pack("<12fH", 0, 0, 0, *corners[list(three)].ravel(), 0)
    return text


def mesh_package(folder: Path) -> Path:
    """Write a ROS package `rack` whose gripper has meshes in mm; return the URDF's path."""
    package = folder / "share" / "rack"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    (package / "meshes" / "finger.stl").write_bytes(cube_stl((0.012, 0.02, 0.06)))
    (package / "meshes" / "base.stl").write_bytes(cube_stl((0.14, 0.06, 0.08)))
    shapes = [
        f'<mesh filename="package://rack/meshes/{name}.stl" scale="0.001 0.001 0.001"/>'
        for name in ("finger", "base")
    ]
    path = package / "urdf" / "rack.urdf"
    path.write_text(rack_and_pinion(*shapes))
    return path


def mimic_linkage() -> str:
    """URDF: knuckles, fingers and a pad on each side that mimic one hinge; 0 to 64 mm.

    The inner knuckles are continuous joints without limits. The effort of 1000 is a placeholder.
    """
    limit = '<limit lower="{}" upper="0.8" effort="1000" velocity="2"/>'
    text = '<robot name="linkage">' + LINK.format(
        name="base", at="0 0 0.03", shape=box(".07 .06 .06")
    )
    for side, sign, turn in (("left", 1, 0.0), ("right", -1, np.pi)):
        shapes = {
            "knuckle": (".0175 0 .02", ".008 .02 .03"),
            "finger": ("-.012 0 .03", ".014 .022 .06"),
            "pad": ("-.02 0 .04", ".006 .022 .035"),
            "inner": ("0 0 .015", ".006 .014 .03"),
        }
        for name, (at, size) in shapes.items():
            text += LINK.format(name=f"{side}_{name}", at=at, shape=box(size))
        follow = '<mimic joint="left_drive" multiplier="{}"/>'
        for name, kind, parent, child, at, more in (
            (
                "drive",
                "revolute",
                "base",
                f"{side}_knuckle",
                f"{0.02 * sign} 0 .06",
                limit.format(0) + (follow.format(1) if sign < 0 else ""),
            ),
            (
                "tip",
                "revolute",
                f"{side}_knuckle",
                f"{side}_finger",
                ".035 0 .065",
                limit.format(-0.8) + follow.format(-1),
            ),
            ("fixed", "fixed", f"{side}_finger", f"{side}_pad", "0 0 0", ""),
            (
                "inner_joint",
                "continuous",
                "base",
                f"{side}_inner",
                f"{0.008 * sign} 0 .06",
                follow.format(1),
            ),
        ):
            yaw = turn if parent == "base" else 0.0
            text += (
                f'<joint name="{side}_{name}" type="{kind}"><parent link="{parent}"/>'
                f'<child link="{child}"/><origin xyz="{at}" rpy="0 0 {yaw}"/>'
                f'<axis xyz="0 -1 0"/>{more}</joint>'
            )
    return text + "</robot>"
