"""Rubber-like friction for the pads of a hand that has a description."""

from __future__ import annotations

from typing import Any

from .hand_description import HandDescription

SLIDING_FRICTION = 1.0
"""Default sliding friction, as of rubber."""
SPIN_FRICTION_M = 0.02
"""Torsional friction of a pad, m, as in the included hand. Most files have only that of a point
contact, with which an object between two fingertips would rotate."""


def grip_pads(
    spec: Any, description: HandDescription, friction: float | None = None, *, prefix: str = ""
) -> None:
    """Set friction and priority of a hand's pads in its `MjSpec`.

    Parameters
    ----------
    spec
        Spec of the hand, or of a robot with the hand.
    description
        Description of the hand, with its pads.
    friction
        Sliding friction of the pads; `SLIDING_FRICTION` if None.
    prefix
        Prefix of the description's names in the spec.
    """
    names = {name for finger in description.fingers for name in finger.pads} | set(description.palm)
    sliding = SLIDING_FRICTION if friction is None else friction
    for geom in spec.geoms:
        if geom.name.startswith(prefix) and geom.name.removeprefix(prefix) in names:
            geom.priority, geom.condim = 1, 4
            geom.friction = [sliding, SPIN_FRICTION_M, geom.friction[2]]
