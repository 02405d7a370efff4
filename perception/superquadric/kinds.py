"""Parameterisation of each kind of solid: its free numbers within the full parameters."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from .parameters import N_PARAMETERS
from .shape import PARAMETER_COUNT, Kind

EDGE_EXPONENT = 0.1
"""Exponent of the sharp edges of cylinders, and of boxes while kinds are compared."""
BOX_EXPONENT = 0.06
"""Exponents of the selected box. The sides of exact boxes then have no bias (at 0.1 they are 0.7 mm
too long). At 0.04, a side of which only one end was seen is up to 40 mm too long without a view."""


@cache
def basis(kind: Kind) -> NDArray[np.float64]:
    """Return the matrix B (13, k) with full step = B @ step of the k free numbers of a kind.

    See :data:`~.parameters.N_PARAMETERS` for the order of a full step.
    """
    columns: list[NDArray[np.float64]] = []
    unit = np.eye(N_PARAMETERS)
    if kind == "sphere":
        columns = [unit[0] + unit[1] + unit[2]]
    elif kind == "cylinder":
        columns = [unit[0] + unit[1], unit[2], unit[5], unit[6]]
    elif kind in ("ellipsoid", "box"):
        columns = [*unit[:3], *unit[5:8]]
    else:
        columns = list(unit[:8])
    matrix = np.column_stack([*columns, *unit[8:11]])
    if kind == "tapered":
        matrix = np.column_stack([matrix, *unit[11:]])
    assert matrix.shape[1] == PARAMETER_COUNT[kind]
    matrix = np.ascontiguousarray(matrix)
    matrix.setflags(write=False)
    return matrix


def fixed_exponents(kind: Kind) -> tuple[float, float] | None:
    """Return the exponents (ε1, ε2) of a kind that does not fit them; None if they are free."""
    fixed: dict[Kind, tuple[float, float]] = {
        "sphere": (1.0, 1.0),
        "ellipsoid": (1.0, 1.0),
        "cylinder": (EDGE_EXPONENT, 1.0),
        "box": (EDGE_EXPONENT, EDGE_EXPONENT),
    }
    return fixed.get(kind)


def starting_axes(kind: Kind, semi_axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the semi-axes (3,) of the most similar solid of this kind."""
    if kind == "sphere":
        return np.full(3, np.median(semi_axes))
    if kind == "cylinder":
        radius = np.sqrt(semi_axes[0] * semi_axes[1])
        return np.array([radius, radius, semi_axes[2]])
    return np.asarray(semi_axes, dtype=np.float64)
