"""Start points of the search: boxes around the cloud in a few frames."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..perpendicular import perpendicular_pair
from .parameters import ShapeParameters
from .problem import FitProblem

_MIN_THICKNESS = 0.1
"""Minimum semi-axis of a box as a share of its largest one: a view of one face has no depth."""
_HALF_RIGHT_ANGLES = Rotation.from_rotvec(0.25 * np.pi * np.eye(3)).as_matrix()


def starting_boxes(problem: FitProblem, has_plane: bool) -> list[ShapeParameters]:
    """Return boxes around the cloud, upright on the support plane or along the principal axes.

    On a plane the smallest rectangle around the footprint (rotating calipers) gives two axes, and
    the box reaches down to the plane. Without a plane the principal axes are also rotated by 45°
    about each of them, because those of one view often differ from the axes of the solid.
    """
    points = problem.points
    _, _, rows = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    principal = _right_handed(rows.T)
    boxes = [_box_around(points, principal, None)]
    if has_plane:
        plane = problem.terms.plane
        normal, offset = plane[:3], float(plane[3])
        frame = _footprint_frame(points, normal)
        return [_box_around(points, frame, -offset), *boxes]
    turned = (_box_around(points, principal @ turn, None) for turn in _HALF_RIGHT_ANGLES)
    return [*boxes, *turned]


def axis_permutations(shape: ShapeParameters) -> list[ShapeParameters]:
    """Return the same box with each of its axes as local z once."""
    permutations = []
    for last in (2, 0, 1):
        order = [(last + 1) % 3, (last + 2) % 3, last]
        permutations.append(
            shape._replace(
                log_axes=shape.log_axes[order], R=np.ascontiguousarray(shape.R[:, order])
            )
        )
    return permutations


def swapped_axes(shape: ShapeParameters) -> list[ShapeParameters]:
    """Return solids that are similar to this one but have another axis as z.

    Local z becomes x or y. The exponents change places, or ε2 is used for both.
    """
    swapped = []
    for order in ([1, 2, 0], [2, 0, 1]):
        turned = shape._replace(
            log_axes=shape.log_axes[order], R=np.ascontiguousarray(shape.R[:, order])
        )
        swapped.append(turned._replace(exponents=shape.exponents[::-1].copy()))
        swapped.append(turned._replace(exponents=np.full(2, shape.exponents[1])))
    return swapped


def rotated_dual(shape: ShapeParameters) -> ShapeParameters:
    """Rotate a solid by 45° about z and mirror ε2 at 1, which gives nearly the same surface.

    A square is a diamond rotated by 45°: ε2 near 0 and near 2 explain the same cloud.
    """
    half = np.sqrt(0.5)
    turn = np.array([[half, -half, 0.0], [half, half, 0.0], [0.0, 0.0, 1.0]])
    mirrored = 2.0 - shape.exponents[1]
    # Both cross-sections have the same area.
    mean = float(np.mean(shape.log_axes[:2]))
    growth = 0.5 * np.log(2.0) * np.clip(1.0 - shape.exponents[1], -1.0, 1.0)
    axes = np.array([mean + growth, mean + growth, shape.log_axes[2]])
    return shape._replace(
        log_axes=axes, exponents=np.array([shape.exponents[0], mirrored]), R=shape.R @ turn
    )


def _footprint_frame(
    points: NDArray[np.float64], normal: NDArray[np.float64]
) -> NDArray[np.float64]:
    side, other = perpendicular_pair(normal)
    flat = np.column_stack([points @ side, points @ other]).astype(np.float32)
    corners = cv2.boxPoints(cv2.minAreaRect(flat)).astype(np.float64)
    edge = corners[1] - corners[0]
    if np.linalg.norm(edge) < 1e-9:
        edge = corners[2] - corners[1]
    along = (edge[0] * side + edge[1] * other) / max(float(np.linalg.norm(edge)), 1e-12)
    return np.array([along, np.cross(normal, along), normal], dtype=np.float64).T


def _box_around(
    points: NDArray[np.float64], frame: NDArray[np.float64], floor: float | None
) -> ShapeParameters:
    local = points @ frame
    low, high = local.min(axis=0), local.max(axis=0)
    if floor is not None and floor < high[2]:
        low[2] = min(low[2], floor)
    half = 0.5 * (high - low)
    half = np.maximum(half, _MIN_THICKNESS * half.max())
    return ShapeParameters(np.log(half), np.array([1.0, 1.0]), frame, frame @ (0.5 * (low + high)))


def _right_handed(frame: NDArray[np.float64]) -> NDArray[np.float64]:
    if np.linalg.det(frame) < 0:
        frame = frame * np.array([1.0, 1.0, -1.0])
    return frame
