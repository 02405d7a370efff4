"""Lines that show the shape of a solid in pictures: rims, edges, great circles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .shape import Superquadric

MAX_EDGE_EXPONENT = 0.5
"""Exponents below this look like an edge, larger ones look round."""
SAMPLES = 96


def feature_curves(solid: Superquadric) -> list[NDArray[np.float64]]:
    """Return curves (K, 3) on the surface, in the frame of the solid, m.

    These are the two rims if ε1 is small, and the four upright edges if ε2 is small. Otherwise
    they are the great circles through the local axes.
    """
    e1, e2 = solid.exponents
    angle = np.linspace(0.0, 2.0 * np.pi, SAMPLES)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    section = circle / _norm(circle, e2)[:, None]
    flat = np.zeros((SAMPLES, 1))
    curves = []
    if e1 < MAX_EDGE_EXPONENT:
        curves += [np.hstack([section, flat + side]) for side in (-1.0, 1.0)]
    else:
        curves.append(np.hstack([section, flat]))
    if e2 < MAX_EDGE_EXPONENT:
        upright = np.linspace(-1.0, 1.0, SAMPLES)[:, None] if e1 < MAX_EDGE_EXPONENT else None
        for x, y in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
            corner = np.array([[x, y]])
            if upright is None:
                half = angle[: SAMPLES // 2] - 0.5 * np.pi
                curves.append(np.hstack([np.cos(half)[:, None] * corner, np.sin(half)[:, None]]))
            else:
                curves.append(np.hstack([np.repeat(corner, SAMPLES, axis=0), upright]))
    elif e1 >= MAX_EDGE_EXPONENT:
        curves.append(np.column_stack([circle[:, 0], flat[:, 0], circle[:, 1]]))
        curves.append(np.column_stack([flat[:, 0], circle[:, 0], circle[:, 1]]))
    return [
        solid.project_radially(solid.to_parent(solid.apply_taper(curve * solid.semi_axes)))
        for curve in curves
    ]


def _norm(points: NDArray[np.float64], exponent: float) -> NDArray[np.float64]:
    magnitude = np.maximum(np.abs(points), 1e-12)
    return np.exp(0.5 * exponent * np.logaddexp(*(2.0 / exponent * np.log(magnitude)).T))
