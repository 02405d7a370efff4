"""Options of the control basis, each with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import Literal

from eyehand.errors import InputError

Relaxation = Literal["dynamic"] | float
"""Weight β of avoidance in task space (eq. 8); ``"dynamic"`` computes it by eq. 10."""


@dataclass(frozen=True)
class ControlOptions:
    """Options of the stack, the avoidance, the safety level and the approach.

    Raises
    ------
    InputError
        If a value is out of its range; the message names the range or the choices.
    """

    dt: float = 0.005
    """Control period, s. A shorter one reacts faster to obstacles, and needs more computing
    time."""
    beta: Relaxation = "dynamic"
    """Weight of avoidance in task space. With 0 the hand moves in a straight line. With a large
    value it misses the goal."""
    influence: float = 0.08
    """Distance d_B below which obstacles repel (eq. 6), m. A larger one avoids obstacles
    earlier."""
    eta: float = 6.0
    """Gain η of the repulsion (eq. 6), 1/(m² s). A larger one repels more; see
    :func:`stable_eta`."""
    centring: float = 0.1
    """Gain of the free joint motion towards the middle of the joint ranges (eq. 5), 1/s. A larger
    one stays farther from joint limits, and moves the elbow more."""
    safety: bool = True
    """Whether a quadratic program above all tasks limits distances, joint positions and speeds."""
    margin: float = 0.01
    """Minimum distance between robot and obstacles, and between two parts of the robot, m."""
    damper: float = 0.15
    """Fraction of the distance left to the margin that one cycle may use up. A larger one is faster
    near obstacles, and leaves less reserve for the error of the linearisation."""
    limit_margin: float = 0.01
    """Minimum distance from the joint limits, rad or m."""
    tolerance: float = 5e-4
    """Maximum error of a task that counts as reached, m or rad."""
    patience: float = 0.9
    """Time without progress after which the motion counts as stuck, s."""
    retreats: int = 2
    """Maximum number of retreats, in which a stuck motion restarts from a retreat configuration.
    The home posture and its mirror image take turns. With 0 the motion stays stuck."""

    def __post_init__(self) -> None:
        if isinstance(self.beta, str):
            if self.beta != "dynamic":
                raise InputError(f'beta must be "dynamic" or a number >= 0, got {self.beta!r}')
        elif not isinstance(self.beta, Real) or not 0.0 <= float(self.beta) < float("inf"):
            raise InputError(f'beta must be "dynamic" or a number >= 0, got {self.beta!r}')
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if not isinstance(value, Real) or not low <= float(value) <= high:
                raise InputError(
                    f"control option {name} must lie in [{low:g}, {high:g}], got {value!r}"
                )


_RANGES: dict[str, tuple[float, float]] = {
    "dt": (1e-5, 0.1),
    "influence": (1e-4, 1.0),
    "eta": (0.0, 1e6),
    "centring": (0.0, 1e3),
    "margin": (0.0, 0.5),
    "damper": (1e-3, 1.0),
    "limit_margin": (0.0, 0.5),
    "tolerance": (1e-9, 1.0),
    "patience": (1e-3, 1e3),
    "retreats": (0, 100),
}
