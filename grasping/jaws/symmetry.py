"""Axes of symmetry of objects: grasps that differ by a turn about them are one grasp."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .candidates import ROUND_EXPONENT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .surface_model import ObjectSurface

    Axis = tuple[NDArray[np.float64], NDArray[np.float64]]
    """A point on an axis, (3,), m, and its unit direction, (3,)."""

MIN_RATIO = 0.9
"""Minimum ratio of the semi-axes of a section that counts as round."""
SAME_POSITION = 0.008
"""Two grasps may differ by as much along the axis and across it, m."""
SAME_COSINE = 0.17
"""Two grasps may differ by as much in the cosines to the axis: 10° near a right angle."""


def symmetry_axes(surface: ObjectSurface) -> list[Axis]:
    """Return the axes of symmetry of an object of one solid."""
    if len(surface.solids) != 1:
        return []
    solid = surface.solids[0]
    e1, e2 = solid.exponents
    a = solid.semi_axes
    axes = []
    for first, second, exponent in ((0, 1, e2), (1, 2, e1), (2, 0, e1)):
        ratio = min(a[first], a[second]) / max(a[first], a[second])
        if exponent >= ROUND_EXPONENT and ratio >= MIN_RATIO:
            axes.append((solid.centre, solid.rotation[:, 3 - first - second]))
    return axes


def is_turned(
    axes: Sequence[Axis],
    tip: NDArray[np.float64],
    other: NDArray[np.float64],
    rotation: NDArray[np.float64],
    turned: NDArray[np.float64],
) -> bool:
    """Return whether two poses differ by a turn about one of the axes alone."""
    return any(
        np.abs(_place(axis, tip) - _place(axis, other)).max() < SAME_POSITION
        and np.abs(_angles(axis, rotation) - _angles(axis, turned)).max() < SAME_COSINE
        for axis in axes
    )


def _place(axis: Axis, tip: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the coordinate along the axis and the distance from it, (2,), m."""
    offset = tip - axis[0]
    along = float(offset @ axis[1])
    return np.array([along, float(np.linalg.norm(offset - along * axis[1]))])


def _angles(axis: Axis, rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cosines of approach and closing direction to the axis, (2,)."""
    return np.array([float(rotation[:, 2] @ axis[1]), abs(float(rotation[:, 0] @ axis[1]))])
