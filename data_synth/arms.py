"""The included robot arms and hand, as MJCF files made of primitives, without meshes."""

from __future__ import annotations

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
