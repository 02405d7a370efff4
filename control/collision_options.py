"""Options of the collision world, each with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass

from eyehand.errors import InputError


@dataclass(frozen=True)
class CoverOptions:
    """Options of the spheres that cover parts of the robot for the soft minimum of distances.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    overhang: float = 0.004
    """Maximum distance by which spheres extend beyond a part, m. The number of spheres grows with
    the inverse cube of it."""
    max_spheres: int = 64
    """Maximum number of spheres for one part. Fewer are faster, and may extend farther than
    ``overhang``."""
    sharpness: float = 2000.0
    """k of the soft minimum, 1/m. The result is below the true minimum by at most log(spheres)/k. A
    larger k is more exact, and its gradient changes direction faster."""

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
    """Pairs farther apart than this are skipped, m. A larger one includes obstacles earlier, and
    costs about a microsecond per pair."""
    self_margin: float = 0.005
    """Two parts of the robot nearer than this in the home posture are never checked for collision,
    m. A larger one accepts coarser shapes, and misses more self-collisions."""
    cover: CoverOptions | None = None
    """Spheres that cover parts with flat or long sides, for a distance by soft minimum; None uses
    the shapes themselves. With spheres, the gradient changes smoothly where the nearest point would
    jump. But distances are some millimetres too small, penetration depths may be too small (the
    sign is correct), and a cycle takes longer."""

    def __post_init__(self) -> None:
        if not 0.0 < self.cut_off < float("inf"):
            raise InputError(f"cut_off must be finite and > 0, got {self.cut_off}")
        if not 0.0 <= self.self_margin < float("inf"):
            raise InputError(f"self_margin must be finite and >= 0, got {self.self_margin}")
