"""Every choice of the control basis, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import Literal, get_args

from eyehand.errors import InputError

Mode = Literal["strict", "paper"]
"""``strict``: a lower task moves in the null space of all above it; ``paper``: eq. 2-3 as printed,
where N1 N2 is not the null space of both."""
Relaxation = Literal["dynamic"] | float
"""Weight β of avoidance in task space (eq. 8); ``dynamic`` follows eq. 10."""


@dataclass(frozen=True)
class ControlOptions:
    """Options of the stack, the avoidance, the safety level and the approach.

    Raises
    ------
    InputError
        If a value is out of its range; the message names the range or the choices.
    """

    dt: float = 0.005
    """Control period, s: shorter follows obstacles closer, and costs more cycles."""
    mode: Mode = "strict"
    """How priorities are kept."""
    near_singular: float = 0.05
    """Singular values below this are damped, more the smaller they are: larger keeps joints slower
    near singular postures, and the task less exact there."""
    damping: float = 0.05
    """Damping of a direction whose singular value is zero."""
    beta: Relaxation = "dynamic"
    """Weight of avoidance in task space: 0 keeps the straight line, large ones miss the goal."""
    epsilon: float = 0.05
    """By how much the way to the goal outruns avoidance with a dynamic β (eq. 10), m/s or rad/s."""
    influence: float = 0.08
    """Distance d_B below which obstacles repel (eq. 6), m: larger swerves earlier."""
    eta: float = 6.0
    """Gain η of that repulsion (eq. 6), 1/(m² s): larger pushes harder; see :func:`stable_eta`."""
    centring: float = 0.1
    """Gain of keeping joints near the middle of their ranges (eq. 5) in what the tasks leave free,
    1/s."""
    centring_power: int = 4
    """Power p of that cost, even: higher leaves the middle free and pushes harder near limits."""
    safety: bool = True
    """Whether a quadratic program above all tasks keeps distances, joint ranges and speeds."""
    margin: float = 0.01
    """Distance that robot and obstacles, or two parts of the robot, keep at least, m."""
    damper: float = 0.15
    """Share of the distance left to the margin that one cycle may use up: larger goes faster near
    obstacles and leaves less for what the linearisation misses."""
    recovery_speed: float = 0.1
    """Speed at which a robot inside the margin leaves it, m/s."""
    limit_margin: float = 0.01
    """Angle (or m, of a sliding joint) kept from the joint limits."""
    task_weight: float = 20.0
    """How much dearer it is for the safety level to give up task motion than free motion:
    0 bends all joints alike."""
    tolerance: float = 5e-4
    """Largest error of a task that counts as reached, m or rad."""
    patience: float = 0.9
    """How long the errors may stay without progress before the motion counts as stuck, s."""
    retreats: int = 2
    """How often a stuck motion goes back to a posture of refuge and tries again from there; the
    home posture and its mirror image take turns. 0 stays stuck."""
    retreat_speed: float = 1.5
    """Largest norm of the joint velocities on the way back, rad/s."""
    retreat_hand_speed: float = 0.25
    """Largest speed of the controlled frame on the way back, m/s: what a task has by default, the
    reduced speed of ISO 10218-1 beside people."""
    retreat_seconds: float = 20.0
    """Longest way back, s; where it ends, the motion tries again."""
    compiled: bool = True
    """Whether to use the compiled cycle where all tasks are built in; same figures, some ten times
    faster."""
    progress: float = 0.01
    """Decrease of the summed errors that counts as progress, m or rad (near the goal a tenth of
    what is left does): larger gives up creeping sooner."""

    def __post_init__(self) -> None:
        if self.mode not in get_args(Mode):
            raise InputError(f"mode must be one of {', '.join(get_args(Mode))}, got {self.mode!r}")
        if isinstance(self.beta, str):
            if self.beta != "dynamic":
                raise InputError(f'beta must be "dynamic" or a number >= 0, got {self.beta!r}')
        elif not isinstance(self.beta, Real) or not 0.0 <= float(self.beta) < float("inf"):
            raise InputError(f'beta must be "dynamic" or a number >= 0, got {self.beta!r}')
        power = self.centring_power
        if not isinstance(power, Real) or power < 2 or power % 2:
            raise InputError(
                "centring_power must be an even whole number >= 2 (eq. 5 has no minimum with an "
                f"odd one), got {self.centring_power}"
            )
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if not isinstance(value, Real) or not low <= float(value) <= high:
                raise InputError(
                    f"control option {name} must lie in [{low:g}, {high:g}], got {value!r}"
                )


_RANGES: dict[str, tuple[float, float]] = {
    "dt": (1e-5, 0.1),
    "near_singular": (1e-6, 1.0),
    "damping": (0.0, 1.0),
    "epsilon": (0.0, 1.0),
    "influence": (1e-4, 1.0),
    "eta": (0.0, 1e6),
    "centring": (0.0, 1e3),
    # Higher ones overflow some radians off the middle.
    "centring_power": (2, 50),
    "margin": (0.0, 0.5),
    "damper": (1e-3, 1.0),
    "recovery_speed": (0.0, 1.0),
    "limit_margin": (0.0, 0.5),
    "task_weight": (0.0, 1e6),
    "tolerance": (1e-9, 1.0),
    "patience": (1e-3, 1e3),
    "progress": (0.0, 1.0),
    "retreats": (0, 100),
    "retreat_speed": (1e-3, 100.0),
    "retreat_hand_speed": (1e-3, 100.0),
    "retreat_seconds": (1e-3, 1e3),
}
