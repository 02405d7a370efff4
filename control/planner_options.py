"""Options of the planner, each with its unit and what it trades."""

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
    "reach_beyond": (0.0, 10.0),
    "seed": (0, 2**63),
}
