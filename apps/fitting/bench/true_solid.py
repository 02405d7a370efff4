"""The true solids of clouds: a protocol with inside test and support function."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eyehand.perception import Superquadric
from eyehand.perception.superquadric import Kind, mesh

from .compound_solids import CompoundSolid
from .odd_solids import PosedSolid

SHARP = 0.1
"""Exponent up to which an edge is sharp: its corner lies within 5 % of the half diagonal of the
box's, which noise of 1 mm does not tell apart on what a hand grasps."""
MESH_RESOLUTION = 128
"""Facets around a superquadric: one of 80 mm is true to 0.024 mm."""


class TrueSolid(Protocol):
    """A solid in the frame of the cloud. Superquadrics satisfy it."""

    @property
    def centre(self) -> NDArray[np.float64]:
        """Middle of the bounds along its own axes, (3,), m."""
        ...

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Own axes as columns, (3, 3)."""
        ...

    def contains(self, points: ArrayLike, /) -> NDArray[np.bool_]:
        """Return whether points (…, 3) lie inside or on the surface, (…,)."""
        ...

    def support(self, directions: ArrayLike, /) -> NDArray[np.float64]:
        """Return the maximum of ``d·x`` over the solid for directions d (…, 3), (…,), m."""
        ...


def true_kind(solid: TrueSolid) -> Kind | None:
    """Return the simplest kind with exactly this shape; None if it is no superquadric.

    A superquadric with both exponents up to SHARP is a box. Exponents (1, 1) make an ellipsoid, or
    a sphere if the semi-axes are equal. Exponents (up to SHARP, 1) make a cylinder if a1 and a2 are
    equal. For these only the simpler kind is right. A cylinder over an ellipse stays a
    superquadric, because no simpler kind has its shape.
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
    """Return the convex parts of a solid: the solid itself unless it is a compound."""
    return solid.parts if isinstance(solid, CompoundSolid) else [solid]


def surface_mesh(solid: TrueSolid) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return a closed mesh of a convex solid, (V, 3) m, (T, 3), counter-clockwise from outside."""
    if isinstance(solid, PosedSolid):
        return solid.mesh()
    if isinstance(solid, Superquadric):
        return mesh(solid, MESH_RESOLUTION)
    raise TypeError(f"no mesh of a {type(solid).__name__}")
