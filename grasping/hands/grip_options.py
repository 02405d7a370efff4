"""Options of closing a hand: speed, touch threshold and tendon tensions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import get_args

import numpy as np

from eyehand.errors import InputError

from ..prototypes import Prototype

TENSION_PER_TIP_FORCE = 15.0
"""Measured ratio of tendon tension to force at the fingertip. A finger of 90 mm turns on a lever of
12 mm; springs and outer joints take the rest."""
MIN_TENSION_SHARE = 0.75
"""Minimum share of the prototype's tension, however light the load. Lower spares thin objects, but
drops objects that are heavier than estimated, such as half-hidden ones."""
GRAVITY = 9.81
"""Gravitational acceleration, m/s²."""


@dataclass(frozen=True)
class GripOptions:
    """Options for closing the hand.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    closing_speed: float = 0.014
    """Speed of a finger's tendon until touch, m/s; 0.014 moves the fingertips at 0.1 m/s. Slower
    pushes light objects less."""
    touch_force: float = 0.3
    """Force on the pads of one side that counts as touch, N. Lower topples fewer objects, but
    reacts to noise."""
    tension: dict[Prototype, float] = field(
        default_factory=lambda: {"pincer": 70.0, "precision": 70.0, "power": 90.0}
    )
    """Tension of each finger's tendon in the grip, N. Higher holds more, but deforms more."""
    max_tension: float = 170.0
    """Maximum tension of each finger's tendon where the measured load needs more than the grip, N.
    Higher holds heavier objects. The drives of the outer joints then hold more than this: 40 N
    times the square of the rise of the tension, 420 N with the default."""
    load: float | None = None
    """Mass to lift, kg. Light objects get less tension. None applies the full tension."""
    lever: float = 0.0
    """Horizontal distance of the load from the closing axis of jaws, m: it turns between the
    pads."""
    friction: float = 0.6
    """Coefficient of friction that is assumed for the load."""
    safety: float = 3.0
    """Ratio of the grip force to the force that the load needs."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            least = 0.0 if name == "lever" else np.finfo(float).tiny
            if isinstance(value, (int, float)) and not least <= value < 1e4:
                raise InputError(f"grip option {name} must lie in (0, 10000), got {value}")
        for prototype, value in self.tension.items():
            if prototype not in get_args(Prototype) or not 0.0 < value < 1e4:
                raise InputError(
                    f"tension of {prototype!r} must lie in (0, 10000) N for one of "
                    f"{', '.join(get_args(Prototype))}, got {value}"
                )

    def finger_tension(self, prototype: Prototype, fingers: int) -> float:
        """Return the tension of each finger in the grip, N, scaled to the load if it is known."""
        full = self.tension[prototype]
        if self.load is None:
            return full
        needed = self.load * GRAVITY * self.safety / (2.0 * self.friction)
        tension = needed / fingers * TENSION_PER_TIP_FORCE
        return float(np.clip(tension, MIN_TENSION_SHARE * full, full))
