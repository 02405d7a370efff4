"""How the pads of a foreign hand touch: as rubber does."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .hand_description import HandDescription

SLIDING_FRICTION = 1.0
"""Of rubber on what it holds, where no other is asked for."""
SPIN_FRICTION_M = 0.02
"""Of a pad against spinning on the spot, m, as that of the hand that comes with eyehand: files give
the little that a point has, and what two fingertips hold would turn between them."""


def grip_pads(
    spec: Any, description: HandDescription, friction: float | None = None, *, prefix: str = ""
) -> None:
    """Let a hand's pads alone decide their contacts, changing its `MjSpec`.

    Parameters
    ----------
    spec
        Of the hand, or of a robot that has it.
    description
        Which geoms are pads.
    friction
        Their sliding friction; `SLIDING_FRICTION` when None.
    prefix
        What stands before the names of the description in the spec.
    """
    names = {name for finger in description.fingers for name in finger.pads} | set(description.palm)
    sliding = SLIDING_FRICTION if friction is None else friction
    for geom in spec.geoms:
        if geom.name.startswith(prefix) and geom.name.removeprefix(prefix) in names:
            geom.priority, geom.condim = 1, 4
            geom.friction = [sliding, SPIN_FRICTION_M, geom.friction[2]]
