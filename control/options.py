"""Options of control, collision checks and planning, each with its unit and what it trades."""

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
    """Minimum distance between robot and obstacles, and between two parts of the robot, m. Two
    parts that are nearer than 11 mm in the home posture may come nearer in proportion."""
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
        _check_ranges(self, "control", _RANGES)


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


@dataclass(frozen=True)
class CollisionOptions:
    """Options of the collision world.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    cut_off: float = 0.15
    """Pairs farther apart than this are skipped, m. A larger one includes obstacles earlier, and
    costs about a microsecond per pair."""
    self_margin: float = 0.005
    """Two parts of the robot nearer than this in the home posture are never checked for collision,
    m. A larger one accepts coarser shapes, and misses more self-collisions. Parts that are nearer
    than 10 mm in every posture are never checked either."""

    def __post_init__(self) -> None:
        if not 0.0 < self.cut_off < float("inf"):
            raise InputError(f"cut_off must be finite and > 0, got {self.cut_off}")
        if not 0.0 <= self.self_margin < float("inf"):
            raise InputError(f"self_margin must be finite and >= 0, got {self.self_margin}")


@dataclass(frozen=True)
class PlannerOptions:
    """Options of :func:`plan`.

    Raises
    ------
    InputError
        If a value is out of its range; the message names the range.
    """

    rollouts: int = 350
    """Maximum number of roll-outs. More find paths through narrower gaps. It is not a time limit,
    so that a loaded machine finds the same path. One core computes about 170 per second."""
    dt: float = 0.05
    """Control period of a roll-out, s. A longer one makes the search faster and avoidance less
    exact."""
    longest: float = 5.0
    """Time limit of a roll-out, s of motion. With a longer one, one roll-out can follow a longer
    detour."""
    reach_beyond: float = 0.4
    """Random positions are drawn up to this distance beyond start and goal, m. A larger one finds
    wider detours, but later."""
    seed: int = 0
    """Seed of the random positions."""

    def __post_init__(self) -> None:
        _check_ranges(self, "planner", _PLANNER_RANGES)


_PLANNER_RANGES: dict[str, tuple[float, float]] = {
    "rollouts": (0, 10**6),
    "dt": (1e-4, 0.1),
    "longest": (1e-3, 100.0),
    "reach_beyond": (0.0, 10.0),
    "seed": (0, 2**63),
}


def _check_ranges(options: object, kind: str, ranges: dict[str, tuple[float, float]]) -> None:
    """Raise an :class:`InputError` if an option is no number or outside its range."""
    for name, (low, high) in ranges.items():
        value = getattr(options, name)
        if not isinstance(value, Real) or not low <= float(value) <= high:
            raise InputError(f"{kind} option {name} must lie in [{low:g}, {high:g}], got {value!r}")
