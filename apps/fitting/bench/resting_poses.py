"""Resting poses of a mesh on a table: faces of its hull with the centre of mass above them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

CONTACT = 0.003
"""Vertices of the hull within this distance of a face touch the table with it, m. The bottoms of
scanned boxes are uneven by about as much."""
MIN_STABILITY = np.radians(8.0)
"""Minimum tilt after which an object falls back onto its face, rad. Less would not stand for long
on a real table. If no face reaches it, the most stable one counts."""
MIN_TURN = np.radians(30.0)
"""Minimum angle between the upward directions of two resting poses, rad."""
TILT_COST = 1.0
"""Stability, rad, that outweighs one radian of turn from the file's own upward direction."""


class Face(NamedTuple):
    """A face of the convex hull on which the object can rest."""

    up: NDArray[np.float64]
    """Direction away from the table, (3,), in the mesh's frame."""
    stability: float
    """Smallest tilt that turns the object over an edge of the face, rad."""


def resting_rotations(vertices: NDArray[np.float64], count: int) -> list[Rotation]:
    """Return at most `count` rotations that turn a mesh's vertices (V, 3) to rest on z = const.

    The first pose is the stable one nearest to the file's own z-axis. The others follow by their
    stability, each at least MIN_TURN from all before.
    """
    faces = _stable_faces(vertices)
    z = np.array([0.0, 0.0, 1.0])
    first = max(faces, key=lambda face: face.stability - TILT_COST * _angle(face.up, z))
    chosen = [first]
    for face in sorted(faces, key=lambda face: -face.stability):
        if len(chosen) >= count:
            break
        if all(_angle(face.up, other.up) >= MIN_TURN for other in chosen):
            chosen.append(face)
    return [_turn_up(face.up) for face in chosen]


def hull_facets(vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return outward normals (F, 3) and areas (F,) of a hull's facets, largest first, m².

    Triangles whose normals differ by less than 5° from a larger one count as one facet.
    """
    hull = ConvexHull(vertices)
    corners = vertices[hull.simplices]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    normals = hull.equations[:, :3]
    near = normals @ normals.T > np.cos(np.radians(5.0))
    sums = near @ areas
    taken = np.zeros(len(areas), dtype=bool)
    kept: list[int] = []
    for index in np.argsort(-sums):
        if not taken[index]:
            kept.append(int(index))
            taken |= near[index]
    return normals[kept], sums[kept]


def _stable_faces(vertices: NDArray[np.float64]) -> list[Face]:
    hull = ConvexHull(vertices)
    centre = _centre_of_mass(vertices, hull)
    corners = vertices[hull.vertices]
    equations = np.unique(hull.equations.round(6), axis=0)
    faces = []
    for normal, offset in zip(equations[:, :3], equations[:, 3], strict=True):
        touching = corners[corners @ normal + offset > -CONTACT]
        faces.append(Face(-normal, _stability(touching, centre, normal, float(offset))))
    stable = [face for face in faces if face.stability >= MIN_STABILITY]
    return stable or [max(faces, key=lambda face: face.stability)]


def _stability(
    touching: NDArray[np.float64],
    centre: NDArray[np.float64],
    normal: NDArray[np.float64],
    offset: float,
) -> float:
    """Return the smallest tilt, rad, that turns a body over; negative if it falls by itself."""
    turn = _turn_up(-normal).as_matrix()
    plan = (touching - centre) @ turn.T[:, :2]
    height = -float(normal @ centre + offset)
    if len(plan) < 3 or np.linalg.matrix_rank(plan - plan[0], tol=1e-6) < 2:
        return -np.inf
    # Distances of the centre of mass from the polygon's edges, positive inside.
    inside = -ConvexHull(plan, qhull_options="QJ").equations[:, 2]
    return float(np.arctan2(inside.min(), height))


def _centre_of_mass(vertices: NDArray[np.float64], hull: ConvexHull) -> NDArray[np.float64]:
    """Return the centre of mass (3,) of the solid hull."""
    middle = vertices[hull.vertices].mean(axis=0)
    corners = vertices[hull.simplices] - middle
    volumes = np.abs(np.linalg.det(corners))
    return middle + volumes @ corners.mean(axis=1) * 0.75 / volumes.sum()


def _turn_up(up: NDArray[np.float64]) -> Rotation:
    """Return the smallest rotation that turns a direction (3,) to z."""
    z = np.array([0.0, 0.0, 1.0])
    axis = np.cross(up, z)
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        return Rotation.identity() if up[2] > 0 else Rotation.from_rotvec([np.pi, 0.0, 0.0])
    return Rotation.from_rotvec(axis / length * np.arctan2(length, float(up[2])))


def _angle(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return float(np.arccos(np.clip(a @ b, -1.0, 1.0)))
