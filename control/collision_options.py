"""Every choice of the collision world, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass

from eyehand.errors import InputError


@dataclass(frozen=True)
class CoverOptions:
    """How parts are covered with balls for the soft minimum.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    overhang: float = 0.004
    """How far balls may stand out of a part, m: smaller costs more balls (with the cube of it)."""
    most: int = 64
    """Most balls for one part: fewer are faster and stand out farther than ``overhang``."""
    sharpness: float = 2000.0
    """k of the soft minimum, 1/m: larger is nearer to the true minimum (below it by at most
    log(balls)/k), and turns the gradient faster."""

    def __post_init__(self) -> None:
        if not 0.0 < self.overhang < float("inf"):
            raise InputError(f"overhang must be finite and > 0, got {self.overhang}")
        if self.most < 1:
            raise InputError(f"most must be >= 1, got {self.most}")
        if not 0.0 < self.sharpness < float("inf"):
            raise InputError(f"sharpness must be finite and > 0, got {self.sharpness}")


@dataclass(frozen=True)
class CollisionOptions:
    """Options of the collision world.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    cut_off: float = 0.15
    """Pairs farther apart than this are left out, m: larger sees obstacles earlier and costs about
    a microsecond a pair."""
    self_margin: float = 0.005
    """Two parts of the robot nearer than this at home are taken to belong together, m, and never
    measured: larger forgives shapes that are cut coarsely, and overlooks more."""
    cover: CoverOptions | None = None
    """Whether parts of the robot with flat or long sides are covered with balls and measured by a
    soft minimum: the gradient then turns smoothly where the nearest point would jump, for distances
    that are some millimetres too small outside, depths that may be too small inside (the sign is
    kept), and more time. None measures the shapes as they are."""

    def __post_init__(self) -> None:
        if not 0.0 < self.cut_off < float("inf"):
            raise InputError(f"cut_off must be finite and > 0, got {self.cut_off}")
        if not 0.0 <= self.self_margin < float("inf"):
            raise InputError(f"self_margin must be finite and >= 0, got {self.self_margin}")
