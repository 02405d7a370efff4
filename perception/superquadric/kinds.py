"""The ladder's rungs: how each kind of solid spends its few numbers on the full parameters."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from .shape import PARAMETER_COUNT, Kind

if TYPE_CHECKING:
    from numpy.typing import NDArray


@cache
def basis(kind: Kind) -> NDArray[np.float64]:
    """Matrix B (13, k) with full parameter step = B @ step of the kind's k free numbers.

    Full parameters are log a1, log a2, log a3, ε1, ε2, rotation (3), translation (3), taper (2).
    """
    columns: list[NDArray[np.float64]] = []
    unit = np.eye(13)
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


def fixed_exponents(kind: Kind, edge: float) -> tuple[float, float] | None:
    """Exponents (ε1, ε2) of a kind that does not fit them, None where they are free."""
    fixed: dict[Kind, tuple[float, float]] = {
        "sphere": (1.0, 1.0),
        "ellipsoid": (1.0, 1.0),
        "cylinder": (edge, 1.0),
        "box": (edge, edge),
    }
    return fixed.get(kind)


def starting_axes(kind: Kind, semi_axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Semi-axes (3,) of the nearest solid of this kind."""
    if kind == "sphere":
        return np.full(3, np.median(semi_axes))
    if kind == "cylinder":
        radius = np.sqrt(semi_axes[0] * semi_axes[1])
        return np.array([radius, radius, semi_axes[2]])
    return np.asarray(semi_axes, dtype=np.float64)
