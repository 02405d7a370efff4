"""Strip an MJCF file of the array sizes and notes that make it quarrel with what it joins."""

from __future__ import annotations

from typing import Any

_COUNTED = (
    "njmax",
    "nconmax",
    "nuser_body",
    "nuser_jnt",
    "nuser_geom",
    "nuser_site",
    "nuser_cam",
    "nuser_tendon",
    "nuser_actuator",
    "nuser_sensor",
)
"""Sizes that MuJoCo counts by itself where they are -1."""
_NOTED = ("bodies", "joints", "geoms", "sites", "cameras", "tendons", "actuators", "sensors")
"""What can carry numbers of its author's own, which nothing here reads."""


def plain_sizes(spec: Any) -> None:
    """Leave a spec (`MjSpec`) no sizes but those that MuJoCo counts, and no keyframes.

    Else MuJoCo warns of each that differs from those of the world that the spec is attached to.
    """
    for key in list(spec.keys):
        spec.delete(key)
    spec.nkey = 0
    for name in _COUNTED:
        setattr(spec, name, -1)
    for kind in _NOTED:
        for item in getattr(spec, kind):
            item.userdata = []
