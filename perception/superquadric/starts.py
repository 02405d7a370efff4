"""Starting guesses: the cloud's boxes in a few frames, each axis once as the solid's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from ..perpendicular import perpendicular_pair
from .problem import FitProblem, Guess

if TYPE_CHECKING:
    from numpy.typing import NDArray

_THINNEST = 0.1
"""A start is at least this thick, as a share of its largest semi-axis: a view of one face has no
depth of its own."""


_HALF_RIGHT_ANGLES = Rotation.from_rotvec(0.25 * np.pi * np.eye(3)).as_matrix()


def starting_boxes(problem: FitProblem, has_plane: bool) -> list[Guess]:
    """Boxes around the cloud: along its principal axes, and upright on its support plane.

    On a plane the footprint's smallest rectangle (rotating calipers) gives the other two axes,
    and the box reaches down to the plane. Without one the principal axes are also turned by 45°
    about each: of what one view shows they need not be the solid's.
    """
    points = problem.points
    _, _, rows = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    principal = _right_handed(rows.T)
    boxes = [_box_around(points, principal, None)]
    if has_plane:
        normal, offset = problem.plane[:3], float(problem.plane[3])
        frame = _footprint_frame(points, normal)
        return [_box_around(points, frame, -offset), *boxes]
    turned = (_box_around(points, principal @ turn, None) for turn in _HALF_RIGHT_ANGLES)
    return [*boxes, *turned]


def axis_permutations(guess: Guess) -> list[Guess]:
    """Give the same box with each of its axes as local z once."""
    permutations = []
    for last in (2, 0, 1):
        order = [(last + 1) % 3, (last + 2) % 3, last]
        permutations.append(
            guess._replace(axes=guess.axes[order], R=np.ascontiguousarray(guess.R[:, order]))
        )
    return permutations


def swapped_axes(guess: Guess) -> list[Guess]:
    """Give the solids that a wrong choice of z would take for this one.

    Local z goes to x and to y, and the exponents change places, or the one around z is taken for
    both.
    """
    swapped = []
    for order in ([1, 2, 0], [2, 0, 1]):
        turned = guess._replace(axes=guess.axes[order], R=np.ascontiguousarray(guess.R[:, order]))
        swapped.append(turned._replace(eps=guess.eps[::-1].copy()))
        swapped.append(turned._replace(eps=np.full(2, guess.eps[1])))
    return swapped


def turned_dual(guess: Guess) -> Guess:
    """Turn a solid by 45° about its z-axis with ε2 mirrored at 1: nearly the same surface.

    A square is a diamond turned by 45°: ε2 near 0 and near 2 explain the same cloud.
    """
    half = np.sqrt(0.5)
    turn = np.array([[half, -half, 0.0], [half, half, 0.0], [0.0, 0.0, 1.0]])
    mirrored = 2.0 - guess.eps[1]
    # Equal area of both cross-sections keeps the size when the shape flips.
    mean = float(np.mean(guess.axes[:2]))
    growth = 0.5 * np.log(2.0) * np.clip(1.0 - guess.eps[1], -1.0, 1.0)
    axes = np.array([mean + growth, mean + growth, guess.axes[2]])
    return guess._replace(axes=axes, eps=np.array([guess.eps[0], mirrored]), R=guess.R @ turn)


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
) -> Guess:
    local = points @ frame
    low, high = local.min(axis=0), local.max(axis=0)
    if floor is not None and floor < high[2]:
        low[2] = min(low[2], floor)
    half = 0.5 * (high - low)
    half = np.maximum(half, _THINNEST * half.max())
    return Guess(np.log(half), np.array([1.0, 1.0]), frame, frame @ (0.5 * (low + high)))


def _right_handed(frame: NDArray[np.float64]) -> NDArray[np.float64]:
    if np.linalg.det(frame) < 0:
        frame = frame * np.array([1.0, 1.0, -1.0])
    return frame
