"""The included robot arms and hand, as MJCF files made of primitives, without meshes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

_ASSETS = Path(__file__).parent / "assets"

LBR_ARM = _ASSETS / "lbr_arm.xml"
"""A 7-joint arm with the link lengths, joint limits and joint speeds of a KUKA LBR iiwa 7 R800."""
PLANAR_ARM = _ASSETS / "planar_arm.xml"
"""A planar arm: four joints about z, links of 0.25 m. A goal point leaves two joints free."""

HAND = Path(__file__).parent / "cell" / "assets" / "hand.xml"
"""The included underactuated hand: three fingers of three phalanges against a thumb of two."""
PALM_BEFORE_FLANGE_M = 0.06
"""Distance from the arm's flange to the palm's face: the depth of the palm's shell."""

TOOL_SITE = "tool"
"""Site at the tip of both arms; its z-axis points out of the LBR's flange."""
HOME_KEY = "home"
"""Keyframe with a start posture: the LBR's tool points down, half a metre in front of the base."""
JOINT_SPEED = "joint_speed"
"""Custom number field with the joint speed limits, rad/s, in the order of the joints."""


@dataclass(frozen=True)
class ReachingArm:
    """The arm of reaching scenes: its file, the frame that reaches, and published joint limits."""

    file: Path = LBR_ARM
    """MJCF or URDF file."""
    frame: str = TOOL_SITE
    """Site or body that has to reach the goals."""
    joints: tuple[str, ...] = ()
    """Names of the joints that reach, from the base on. Empty: all joints of the file."""
    speed: tuple[float, ...] = ()
    """Speed limit of each joint, rad/s. Empty: that of the file, or the default."""
    acceleration: tuple[float, ...] = ()
    """Acceleration limit of each joint, rad/s². Empty: that of the file, or the default."""
