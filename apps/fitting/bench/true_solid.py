"""What clouds are taken from: any solid that knows its inside and how far it reaches."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from eyehand.perception import Superquadric
from eyehand.perception.superquadric import mesh

from .compound_solids import CompoundSolid
from .odd_solids import PosedSolid

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from eyehand.perception.superquadric import Kind

SHARP = 0.1
"""Exponent up to which an edge is sharp: its corner lies within 5 % of the half diagonal of the
box's, which noise of 1 mm does not tell apart on what a hand grasps."""
MESH_RESOLUTION = 128
"""Facets around a superquadric: one of 80 mm is true to 0.024 mm."""


class TrueSolid(Protocol):
    """A solid in the cloud's frame. Superquadrics are some."""

    @property
    def centre(self) -> NDArray[np.float64]:
        """Middle of its bounds along its own axes, (3,), m."""
        ...

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Own axes as columns, (3, 3)."""
        ...

    def contains(self, points: ArrayLike, /) -> NDArray[np.bool_]:
        """Whether points (…, 3) lie in it or on its surface, (…,)."""
        ...

    def support(self, directions: ArrayLike, /) -> NDArray[np.float64]:
        """Largest ``d·x`` over it for directions d (…, 3), (…,), m: its bounds in any frame."""
        ...


def true_kind(solid: TrueSolid) -> Kind | None:
    """Name the simplest kind that is this very shape; None for what is no superquadric.

    A superquadric drawn with both exponents up to SHARP *is* a box, one with (1, 1) an ellipsoid,
    or a sphere where its semi-axes are equal, and one with (up to SHARP, 1) a cylinder where a1
    and a2 are equal: to call it so is right, and to call it a superquadric is not, for it spends
    numbers on nothing. A cylinder over an ellipse stays a superquadric: no simpler kind has its
    shape.
    """
    if not isinstance(solid, Superquadric):
        return None
    if any(solid.taper):
        return "tapered"
    (e1, e2), (a1, a2, a3) = solid.exponents, solid.semi_axes
    if e1 <= SHARP and e2 <= SHARP:
        return "box"
    if e2 == 1 and a1 == a2 and e1 <= SHARP:
        return "cylinder"
    if e1 == e2 == 1:
        return "sphere" if a1 == a2 == a3 else "ellipsoid"
    return "superquadric"


def convex_parts(solid: TrueSolid) -> Sequence[TrueSolid]:
    """Convex solids whose union a solid is: itself, unless it is a compound."""
    return solid.parts if isinstance(solid, CompoundSolid) else [solid]


def surface_mesh(solid: TrueSolid) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Closed mesh of a convex solid, (V, 3) m and (T, 3), counter-clockwise from outside."""
    if isinstance(solid, PosedSolid):
        return solid.mesh()
    if isinstance(solid, Superquadric):
        return mesh(solid, MESH_RESOLUTION)
    raise TypeError(f"no mesh of a {type(solid).__name__}")
