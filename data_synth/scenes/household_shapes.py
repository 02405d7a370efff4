"""Random solids of household size, and the orientations in which they rest on a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception.superquadric import MIN_EXPONENT, Kind, Superquadric

if TYPE_CHECKING:
    from .tabletop_options import TabletopOptions

EXPONENT_RANGE = (0.2, 1.3)
"""Exponents of the kind ``superquadric``: low is boxy, 1 is round, above 1 is pinched."""
SLENDERNESS = 3.0
"""Maximum height over width of a standing solid with a flat foot. Slimmer ones topple easily."""
ROUND_SLENDERNESS = 1.2
"""Maximum height over width of a standing solid without a flat foot."""
BASE_SHARE = 0.6
"""Minimum width of a solid that carries another, as a share of the largest width."""
BASE_SLENDERNESS = 0.9
"""Maximum height over width of a solid that carries another."""


def draw_shape(kind: Kind, options: TabletopOptions, rng: np.random.Generator) -> Superquadric:
    """Draw a solid with its shape frame at the origin, a1 >= a2."""
    low, high = options.width_range
    wide = rng.uniform(low, high)
    narrow = rng.uniform(low, wide)
    shortest, tallest = options.height_range
    if kind == "sphere":
        return _solid(kind, (wide, wide, wide), (1.0, 1.0))
    if kind == "cylinder":
        height = rng.uniform(shortest, max(shortest, min(tallest, 1.2 * SLENDERNESS * wide)))
        return _solid(kind, (wide, wide, height), (MIN_EXPONENT, 1.0))
    if kind == "box":
        height = rng.uniform(shortest, max(shortest, min(tallest, SLENDERNESS * narrow)))
        return _solid(kind, (wide, narrow, height), (MIN_EXPONENT, MIN_EXPONENT))
    height = rng.uniform(shortest, max(shortest, min(tallest, 2.0 * narrow)))
    if kind == "ellipsoid":
        return _solid(kind, (wide, narrow, height), (1.0, 1.0))
    e1, e2 = rng.uniform(*EXPONENT_RANGE, size=2)
    return _solid(kind, (wide, narrow, height), (e1, e2))


def draw_base_shape(options: TabletopOptions, rng: np.random.Generator) -> Superquadric:
    """Draw a box or cylinder that is low and wide enough to carry another object."""
    flat: list[Kind] = [kind for kind in options.kinds if kind in ("box", "cylinder")]
    kind = flat[rng.integers(len(flat))]
    high = options.width_range[1]
    wide, other = rng.uniform(max(options.width_range[0], BASE_SHARE * high), high, size=2)
    narrow = min(wide, other)
    wide = max(wide, other)
    shortest, tallest = options.height_range
    height = rng.uniform(shortest, max(shortest, min(tallest, BASE_SLENDERNESS * narrow)))
    if kind == "cylinder":
        return _solid(kind, (wide, wide, height), (MIN_EXPONENT, 1.0))
    return _solid(kind, (wide, narrow, height), (MIN_EXPONENT, MIN_EXPONENT))


def rest_rotation(
    shape: Superquadric, rng: np.random.Generator, *, upright: bool = False
) -> Rotation:
    """Draw a rotation (world from shape) in which the solid stands on the table, with any yaw.

    Parameters
    ----------
    shape
        The solid; its pose is not used.
    rng
        Source of randomness.
    upright
        Keep the shape's z-axis up.
    """
    axis = 2 if upright else int(rng.choice(_stable_axes(shape)))
    # A rotation about (1, 1, 1) by one or two thirds of a circle maps the x- or y-axis to z.
    turn = Rotation.from_rotvec(np.ones(3) / np.sqrt(3) * 2 * np.pi / 3 * ((2 - axis) % 3))
    return Rotation.from_rotvec([0.0, 0.0, rng.uniform(0, 2 * np.pi)]) * turn


def _stable_axes(shape: Superquadric) -> list[int]:
    if shape.kind == "sphere":
        return [2]
    if shape.kind == "cylinder":
        slender = shape.semi_axes[2] / shape.semi_axes[0]
        # A cylinder shorter than wide would topple from its side.
        return ([2] if slender <= SLENDERNESS else []) + ([0] if slender >= 1 else [])
    if shape.kind == "ellipsoid":
        return [int(np.argmin(shape.semi_axes))]
    limit = SLENDERNESS if shape.kind == "box" else ROUND_SLENDERNESS
    axes = [
        k for k in range(3) if shape.semi_axes[k] <= limit * np.delete(shape.semi_axes, k).min()
    ]
    return axes or [int(np.argmin(shape.semi_axes))]


def _solid(
    kind: Kind, extents: tuple[float, float, float], exponents: tuple[float, float]
) -> Superquadric:
    return Superquadric(np.array(extents) / 2, exponents, RigidTransform.identity(), kind)
