"""Distances, closest points and derivatives of all near pairs, in one compiled call.

A pair whose bounding spheres and boxes are farther apart than the cut-off is skipped. By virtual
work, the rate of a distance equals the power of a unit force that acts along the normal on the
robot's part. So each pair reduces to one wrench: force and moment about the world's origin. The
entries of a row are the products of the wrench with the joint axes.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .distance_kernels import TOUCHING_M, gap, measure, measure_apart
from .kinematics_kernels import set_posture
from .mujoco_binding import address
from .proximity_tables import (
    FULL_SCALE,
    HELD_AXES,
    HELD_BODY,
    HELD_GEOM,
    HELD_POSITION,
    ProximityTables,
    World,
)

NEAR_COLUMNS = 14
"""Columns of the array that `measure_near` fills."""


@njit(cache=True)
def near_pairs(
    q,
    model,
    data,
    qpos,
    anchors,
    axes,
    body_positions,
    body_axes,
    positions,
    matrices,
    joints,
    moves,
    shapes,
    motion,
    pairs,
    held,
    cut_off,
):
    """Compute the distances of all pairs nearer than the cut-off at ``q``.

    The arguments are a flat list for the reason given at `cycle_kernels.control_cycle`. ``model``
    and ``data`` are addresses, ``qpos`` to ``matrices`` are views of the data (``qpos``,
    ``xanchor``, ``xaxis``, ``xpos``, ``xmat``, ``geom_xpos``, ``geom_xmat``), the rest fields of
    :class:`ProximityTables`.

    Returns
    -------
    index (P,), distance (P,), normal (P, 3), on_robot (P, 3), on_other (P, 3), rows (P, n),
    drift (P,): as in :class:`Proximity`; ``index`` is the index of the pair.
    """
    set_posture(model, data, q, qpos, joints[:, 0])
    update_held_geoms(held, body_positions, body_axes, positions, matrices)
    world = World(model, data, positions, matrices, shapes, cut_off)
    near = np.empty((len(pairs), NEAR_COLUMNS))
    needed = np.full(len(pairs), cut_off)
    count = measure_near(near, world, pairs, needed)
    return _results(near[:count], pairs, anchors, axes, joints, moves, motion)


def pair_distance(tables: ProximityTables, a: int, b: int, cut_off: float) -> float:
    """Return the signed distance of two geoms for the poses in the data, m, at most the cut-off."""
    model, data = tables.model, tables.data
    world = World(
        address(model), address(data), data.geom_xpos, data.geom_xmat,
        tables.shapes, cut_off,
    )  # fmt: skip
    return measure(world, a, b, cut_off, np.empty(9))


@njit(cache=True)
def measure_near(near, world, pairs, needed):
    """Fill rows of ``near`` (pairs, NEAR_COLUMNS) for the poses in the data; return their count.

    A row holds the pair, its distance, the wrench on the robot's part (force, moment about the
    world's origin), the closest points on the robot's and on the other part. Distance and wrench
    are multiplied by the scale of the pair. ``world`` is a :class:`World`, the rest are fields of
    :class:`ProximityTables`. A pair beyond its distance in ``needed`` (pairs,), m, is left out if a
    nearer one was found before.
    """
    # Read once, because each access to an array of a named tuple counts its references.
    positions, matrices, shapes = world.positions, world.matrices, world.shapes
    cut_off = world.cut_off
    contact = np.empty(9)
    count, least = 0, np.inf
    for pair in range(len(pairs)):
        a, b = pairs[pair, 0], pairs[pair, 1]
        scale = pairs[pair, 2] / FULL_SCALE
        apart = scale * gap(a, b, positions, matrices, shapes)
        if apart >= cut_off or (apart >= needed[pair] and apart >= least):
            continue
        if apart > scale * TOUCHING_M:
            distance = measure_apart(world.model, world.data, a, b, cut_off, contact)
        else:
            distance = measure(world, a, b, cut_off, contact)
        distance *= scale
        if distance < cut_off:
            x, y, z = scale * contact[0], scale * contact[1], scale * contact[2]
            near[count, 0], near[count, 1] = pair, distance
            near[count, 2], near[count, 3], near[count, 4] = x, y, z
            near[count, 5] = contact[4] * z - contact[5] * y
            near[count, 6] = contact[5] * x - contact[3] * z
            near[count, 7] = contact[3] * y - contact[4] * x
            for column in range(6):
                near[count, 8 + column] = contact[3 + column]
            least = min(least, distance)
            count += 1
    return count


@njit(cache=True)
def distance_row(near_row, pair, anchors, axes, joints, moves, motion, row):
    """Fill the derivative (n,) of a distance by the joints from its row of `measure_near`.

    Return the rate of the distance due to the motion of the obstacle, m/s.
    """
    fx, fy, fz = near_row[2], near_row[3], near_row[4]
    mx, my, mz = near_row[5], near_row[6], near_row[7]
    a, b = pair[0], pair[1]
    for column in range(len(joints)):
        # A joint that moves both parts does not change their distance.
        if moves[a, column] == moves[b, column]:
            row[column] = 0.0
            continue
        joint = joints[column, 1]
        ax, ay, az = axes[joint, 0], axes[joint, 1], axes[joint, 2]
        if joints[column, 2] == 1:
            x, y, z = anchors[joint, 0], anchors[joint, 1], anchors[joint, 2]
            work = ax * (mx - y * fz + z * fy)
            work += ay * (my - z * fx + x * fz)
            work += az * (mz - x * fy + y * fx)
        else:
            work = ax * fx + ay * fy + az * fz
        row[column] = work if moves[a, column] else -work
    x, y, z = motion[b, 0], motion[b, 1], motion[b, 2]
    approach = motion[b, 3] * fx + motion[b, 4] * fy + motion[b, 5] * fz
    approach += motion[b, 6] * (mx - y * fz + z * fy)
    approach += motion[b, 7] * (my - z * fx + x * fz)
    approach += motion[b, 8] * (mz - x * fy + y * fx)
    return -approach


@njit(cache=True)
def update_held_geoms(held, body_positions, body_axes, positions, matrices):
    """Move the geoms of held objects with the bodies that hold them."""
    for k in range(len(held)):
        geom, body = int(held[k, HELD_GEOM]), int(held[k, HELD_BODY])
        for row in range(3):
            positions[geom, row] = body_positions[body, row]
            for inner in range(3):
                into = body_axes[body, 3 * row + inner]
                positions[geom, row] += into * held[k, HELD_POSITION + inner]
            for column in range(3):
                total = 0.0
                for inner in range(3):
                    into = body_axes[body, 3 * row + inner]
                    total += into * held[k, HELD_AXES + 3 * inner + column]
                matrices[geom, 3 * row + column] = total


@njit(cache=True)
def _results(near, pairs, anchors, axes, joints, moves, motion):
    count = len(near)
    index = np.empty(count, np.int64)
    distance, drift = np.empty(count), np.empty(count)
    normal, on_robot, on_other = np.empty((count, 3)), np.empty((count, 3)), np.empty((count, 3))
    rows = np.empty((count, len(joints)))
    for row in range(count):
        pair = int(near[row, 0])
        index[row] = pair
        distance[row] = near[row, 1]
        for axis in range(3):
            normal[row, axis] = near[row, 2 + axis] * FULL_SCALE / pairs[pair, 2]
            on_robot[row, axis] = near[row, 8 + axis]
            on_other[row, axis] = near[row, 11 + axis]
        drift[row] = distance_row(
            near[row], pairs[pair], anchors, axes, joints, moves, motion, rows[row]
        )
    return index, distance, normal, on_robot, on_other, rows, drift
