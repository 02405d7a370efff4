"""Speeds and tensions with which a hand closes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import get_args

import numpy as np

from eyehand.errors import InputError

from .prototypes import Prototype

TIP_LEVER = 15.0
"""Tension over force at the fingertip, as measured: 90 mm of finger on a knuckle's arm of 12 mm,
less what springs and the outer joints take."""
GRAVITY = 9.81
"""m/s²."""


@dataclass(frozen=True)
class GripOptions:
    """Speeds and tensions of closing.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    closing_speed: float = 0.014
    """Of a finger's tendon until touch, m/s: 0.1 m/s at the tips. Slower pushes light things
    less."""
    touch_force: float = 0.3
    """Force on a side's pads that counts as touch, N: lower topples less, and trips on noise."""
    touch_hold: float = 25.0
    """Largest tension with which a finger that touches first waits for the thumb, N."""
    tension: dict[Prototype, float] = field(
        default_factory=lambda: {"pincer": 45.0, "precision": 70.0, "power": 90.0}
    )
    """Tension of each finger's tendon in the grip, N."""
    wrap_hold: float = 40.0
    """Largest tension with which a pre-bent finger keeps its bend in a precision grasp, N."""
    draw_tension: float = 60.0
    """Tension that bends the outer joints while a power grasp draws the object to the palm, N:
    more draws what is heavier, and bends the tips past what they should lie on."""
    draw_share: float = 0.2
    """Share of the power grip's tension with which the fingers close meanwhile: less lets the
    object slide to the palm, more has it held more surely."""
    draw_seconds: float = 0.5
    """Longest time for that; nothing is drawn that the palm feels already."""
    draw_ramp: float = 300.0
    """How fast that tension rises and falls, N/s."""
    ramp: float = 200.0
    """How fast the fingers' tension rises, N/s: slower lets round things settle."""
    load: float | None = None
    """Mass to lift, kg, if known: light things get less force; None grips with the whole."""
    friction: float = 0.6
    """Friction assumed for that load."""
    safety: float = 3.0
    """Grip force over what that load needs."""
    least_share: float = 0.75
    """Least share of the prototype's tension, however light the load: less spares what is thin, and
    lets go of what is heavier than it looks, as half hidden things are."""
    least_gap: float = 0.003
    """Free width below which the hand is closed on nothing, m."""
    lost_seconds: float = 0.15
    """How long nothing is felt on one side before the hand counts as empty: a light object bounces
    between the pads at first."""
    settled_speed: float = 0.05
    """Joint speed below which the grip is steady, rad/s."""
    settle_seconds: float = 0.06
    """How long it must be so."""
    grip_seconds: float = 2.0
    """Longest rise of the force; a grip still moving then counts as holding."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, float) and not 0.0 < value < 1e4:
                raise InputError(f"grip option {name} must lie in (0, 10000), got {value}")
        for prototype, value in self.tension.items():
            if prototype not in get_args(Prototype) or not 0.0 < value < 1e4:
                raise InputError(f"tension {prototype!r} must be > 0 N, got {value}")

    def grip(self, prototype: Prototype, fingers: int) -> float:
        """Tension of each finger in the grip, N, scaled to the load where that is known."""
        most = self.tension[prototype]
        if self.load is None:
            return most
        needed = self.load * GRAVITY * self.safety / (2.0 * self.friction)
        return float(np.clip(needed / fingers * TIP_LEVER, self.least_share * most, most))
