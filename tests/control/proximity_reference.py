"""Distances, closest points and distance rows in NumPy and MuJoCo's Python calls.

The reference that the kernels of `control/proximity_kernels.py` are tested against.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from eyehand.control.capsule_in_box import axis_in_box
from eyehand.control.distance_kernels import SHIFT_M, TOUCHING_M
from eyehand.control.mujoco_binding import mujoco
from eyehand.control.proximity_tables import (
    BOUND,
    HALF,
    HELD_AXES,
    HELD_BODY,
    HELD_GEOM,
    HELD_POSITION,
    KIND,
    MIDDLE,
    SIZE,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control.proximity_tables import ProximityTables

    Array = NDArray[np.float64]
    Measured = tuple[float, Array, Array, Array]

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
_CAPSULE = int(mujoco.mjtGeom.mjGEOM_CAPSULE)
_BOX = int(mujoco.mjtGeom.mjGEOM_BOX)


def proximity_reference(tables: ProximityTables, q: NDArray[np.float64]) -> tuple:
    """Measure all pairs closer than the cut-off at ``q`` (n,).

    Returns
    -------
    index, distance, normal, on_robot, on_other, rows, drift
        As `proximity_kernels.near_pairs`.
    """
    data = tables.data
    data.qpos[tables.joints[:, 0]] = q
    mujoco.mj_kinematics(tables.model, data)
    _move_held_objects(tables)
    near = np.flatnonzero(_lower_bounds(tables) < tables.cut_off)
    measured = [
        (pair, *measure_exact(tables, int(a), int(b), tables.cut_off))
        for pair, (a, b, _) in zip(near.tolist(), tables.pairs[near], strict=True)
    ]
    return _results(tables, [one for one in measured if one[1] < tables.cut_off])


def measure_exact(tables: ProximityTables, a: int, b: int, cut_off: float) -> Measured:
    """Return the signed distance of geoms a and b, the normal from b to a, and closest points."""
    kinds = tables.shapes[a, KIND], tables.shapes[b, KIND]
    if kinds == (_CAPSULE, _BOX):
        crossing = _capsule_in_box(tables, a, b)
        if crossing is not None:
            return crossing
    if kinds == (_BOX, _CAPSULE):
        crossing = _capsule_in_box(tables, b, a)
        if crossing is not None:
            distance, normal, on_capsule, on_box = crossing
            return distance, -normal, on_box, on_capsule
    measured = _measure_mujoco(tables, a, b, cut_off)
    return _separate(tables, a, b, measured) if abs(measured[0]) < TOUCHING_M else measured


def _measure_mujoco(tables: ProximityTables, a: int, b: int, cut_off: float) -> Measured:
    segment = np.zeros(6)
    distance: float = mujoco.mj_geomDistance(tables.model, tables.data, a, b, cut_off, segment)
    normal = segment[:3] - segment[3:]
    length = math.sqrt(normal @ normal)
    if length > 0.0:
        normal = normal * ((1.0 if distance > 0.0 else -1.0) / length)
    return distance, normal, segment[:3], segment[3:]


def _separate(tables: ProximityTables, a: int, b: int, touching: Measured) -> Measured:
    positions = tables.data.geom_xpos
    centres = positions[a] - positions[b]
    directions = [touching[1], centres, *(s * row for row in np.eye(3) for s in (1.0, -1.0))]
    directions = [
        direction / np.linalg.norm(direction) for direction in directions if np.any(direction)
    ]
    for direction in directions:
        positions[a] += SHIFT_M * direction
        distance, normal, on_a, on_b = _measure_mujoco(tables, a, b, 1.0)
        positions[a] -= SHIFT_M * direction
        if distance > TOUCHING_M:
            return touching[0], normal, on_a - SHIFT_M * direction, on_b
    return touching[0], directions[0], touching[2], touching[3]


def _capsule_in_box(tables: ProximityTables, capsule: int, box: int) -> Measured | None:
    frame = tables.data.geom_xmat[box].reshape(3, 3)
    origin = tables.data.geom_xpos[box]
    radius, half_length = tables.shapes[capsule, SIZE : SIZE + 2]
    centre = (tables.data.geom_xpos[capsule] - origin) @ frame
    half_axis = half_length * tables.data.geom_xmat[capsule, 2::3] @ frame
    half_extents = tables.shapes[box, SIZE : SIZE + 3]
    separation, fraction, out = axis_in_box(
        tuple(centre.tolist()), tuple(half_axis.tolist()), tuple(half_extents.tolist())
    )
    if separation > 0.0:
        return None
    normal = frame @ out
    point = origin + frame @ (centre + fraction * half_axis)
    return separation - radius, normal, point - radius * normal, point - separation * normal


def _lower_bounds(tables: ProximityTables) -> Array:
    """Return lower bounds on the distances of all pairs, from bounding spheres and boxes."""
    a, b = tables.pairs[:, :2].T
    gaps = np.maximum(_sphere_box_distance(tables, a, b), _sphere_box_distance(tables, b, a))
    planes = tables.shapes[b, KIND] == _PLANE
    if planes.any():
        a, b = a[planes], b[planes]
        centres = tables.data.geom_xpos[a] - tables.data.geom_xpos[b]
        up = tables.data.geom_xmat[b, 2::3]
        gaps[planes] = np.einsum("pi,pi->p", up, centres) - tables.shapes[a, BOUND]
    return gaps


def _sphere_box_distance(
    tables: ProximityTables, spheres: NDArray[np.int64], boxes: NDArray[np.int64]
) -> Array:
    data, shapes = tables.data, tables.shapes
    centres = data.geom_xpos[spheres] - data.geom_xpos[boxes]
    inside = np.einsum("prc,pr->pc", data.geom_xmat[boxes].reshape(-1, 3, 3), centres)
    inside = np.abs(inside - shapes[boxes, MIDDLE : MIDDLE + 3])
    beyond = np.maximum(inside - shapes[boxes, HALF : HALF + 3], 0.0)
    return np.sqrt(np.einsum("pc,pc->p", beyond, beyond)) - shapes[spheres, BOUND]


def _move_held_objects(tables: ProximityTables) -> None:
    data = tables.data
    for row in tables.held:
        geom, body = int(row[HELD_GEOM]), int(row[HELD_BODY])
        frame = data.xmat[body].reshape(3, 3)
        data.geom_xpos[geom] = data.xpos[body] + frame @ row[HELD_POSITION : HELD_POSITION + 3]
        data.geom_xmat[geom] = (frame @ row[HELD_AXES : HELD_AXES + 9].reshape(3, 3)).ravel()


def _results(tables: ProximityTables, found: list) -> tuple:
    index = np.array([row[0] for row in found], dtype=np.int64)
    distance = np.array([row[1] for row in found])
    force, on_robot, on_other = (
        np.array([row[k] for row in found]).reshape(-1, 3) for k in (2, 3, 4)
    )
    moment = np.cross(on_robot, force)
    a, b = tables.pairs[index, :2].T
    side = tables.moves[a].astype(np.float64) - tables.moves[b]
    axes = tables.data.xaxis[tables.joints[:, 1]]
    anchors = tables.data.xanchor[tables.joints[:, 1]]
    turning = np.einsum("jk,pjk->pj", axes, moment[:, None] - np.cross(anchors, force[:, None]))
    rows = side * np.where(tables.joints[:, 2] == 1, turning, force @ axes.T)
    origin, velocity, turn = (tables.motion[b, k : k + 3] for k in (0, 3, 6))
    drift = -np.sum(velocity * force + turn * (moment - np.cross(origin, force)), axis=1)
    return index, distance, force, on_robot, on_other, rows, drift
