"""Options of the collision world, each with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass

from eyehand.errors import InputError


@dataclass(frozen=True)
class CoverOptions:
    """The spheres that cover parts of the robot for the soft minimum.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    overhang: float = 0.004
    """Maximum distance by which spheres extend beyond a part, m. The number of spheres grows with
    the inverse cube of it."""
    max_spheres: int = 64
    """Maximum number of spheres for one part: fewer are faster, and may stand out farther than
    ``overhang``."""
    sharpness: float = 2000.0
    """k of the soft minimum, 1/m: larger is nearer to the true minimum (below it by at most
    log(spheres)/k), and turns the gradient faster."""

    def __post_init__(self) -> None:
        if not 0.0 < self.overhang < float("inf"):
            raise InputError(f"overhang must be finite and > 0, got {self.overhang}")
        if self.max_spheres < 1:
            raise InputError(f"max_spheres must be >= 1, got {self.max_spheres}")
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
    """Pairs farther apart than this are skipped, m: larger includes obstacles earlier, and costs
    about a microsecond per pair."""
    self_margin: float = 0.005
    """Two parts of the robot nearer than this at home count as joined, m, and are never measured:
    larger accepts coarser shapes, and misses more self-collisions."""
    cover: CoverOptions | None = None
    """Spheres that cover parts with flat or long sides, for a distance by soft minimum.
    The gradient then turns smoothly where the nearest point would jump. In return distances
    are some millimetres too small outside, depths may be too small inside (the sign is kept), and a
    cycle takes longer. None measures the shapes as they are."""

    def __post_init__(self) -> None:
        if not 0.0 < self.cut_off < float("inf"):
            raise InputError(f"cut_off must be finite and > 0, got {self.cut_off}")
        if not 0.0 <= self.self_margin < float("inf"):
            raise InputError(f"self_margin must be finite and >= 0, got {self.self_margin}")
