"""The robot arms that come with eyehand, as MJCF files: primitives only, no meshes."""

from __future__ import annotations

from pathlib import Path

_ASSETS = Path(__file__).parent / "assets"

LBR_ARM = _ASSETS / "lbr_arm.xml"
"""A 7-joint arm with the link lengths, joint limits and joint speeds of a KUKA LBR iiwa 7 R800."""
PLANAR_ARM = _ASSETS / "planar_arm.xml"
"""Four joints about z with links of 0.25 m: a point in the plane leaves two joints free."""

TOOL_SITE = "tool"
"""Site at either arm's tip; the LBR's z-axis points out of the flange."""
HOME_KEY = "home"
"""Keyframe with a posture to start from; the LBR's tool points down, half a metre in front."""
JOINT_SPEED = "joint_speed"
"""Custom number field with the joint speed limits, rad/s, in the order of the joints."""
