"""Every choice of the planner, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass

from eyehand.errors import InputError


@dataclass(frozen=True)
class PlannerOptions:
    """Options of :func:`plan`.

    Raises
    ------
    InputError
        If a value is out of its range; the message names the range.
    """

    rollouts: int = 350
    """Maximum number of roll-outs: more finds paths through narrower gaps. A count, not a time, so
    that a loaded machine finds the same path. One core computes about 170 per second."""
    dt: float = 0.05
    """Period of a roll-out, s: longer is faster to search with, and follows obstacles less well."""
    longest: float = 5.0
    """Longest roll-out, s of motion."""
    patience: float = 0.4
    """A roll-out ends when it has got no nearer for so long, s of motion: shorter wastes less on
    dead ends, and gives up where the way bends."""
    goal_share: float = 0.3
    """Share of roll-outs that head for the goal: more is faster when little stands in the way."""
    reach_beyond: float = 0.4
    """How far around start and goal places are drawn, m: more finds wider detours later."""
    least_step: float = 0.02
    """Roll-outs that end nearer to a known place, m, are forgotten."""
    failure_cost: float = 0.1
    """How much farther from the goal a place counts for each roll-out to the goal that failed
    from it, m."""
    posture_weight: float = 0.1
    """How much a rad between postures counts beside a m between places, when places are told
    apart: elbows matter too."""
    seed: int = 0
    """Seed of the places drawn."""

    def __post_init__(self) -> None:
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(
                    f"planner option {name} must lie in [{low:g}, {high:g}], got {value}"
                )


_RANGES: dict[str, tuple[float, float]] = {
    "rollouts": (0, 10**6),
    "dt": (1e-4, 0.1),
    "longest": (1e-3, 100.0),
    "patience": (1e-3, 100.0),
    "goal_share": (0.0, 1.0),
    "reach_beyond": (0.0, 10.0),
    "least_step": (0.0, 1.0),
    "failure_cost": (0.0, 10.0),
    "posture_weight": (0.0, 10.0),
    "seed": (0, 2**63),
}
