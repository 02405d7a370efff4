"""Options of the collision world, each with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass

from eyehand.errors import InputError


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
    m. A larger one accepts coarser shapes, and misses more self-collisions."""

    def __post_init__(self) -> None:
        if not 0.0 < self.cut_off < float("inf"):
            raise InputError(f"cut_off must be finite and > 0, got {self.cut_off}")
        if not 0.0 <= self.self_margin < float("inf"):
            raise InputError(f"self_margin must be finite and >= 0, got {self.self_margin}")
