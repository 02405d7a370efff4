"""Convert a scene to obstacles: table, walls, objects, occluded and unknown space, background."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import Box, ConvexMesh, Cylinder, Ellipsoid, Obstacle, Sphere
from eyehand.errors import InputError
from eyehand.perception import Scene, SceneObject, Superquadric, Wall, perpendicular_pair
from eyehand.perception.superquadric import mesh

from .fit_uncertainty import max_side_std
from .occlusion import Slab, hull_points, occluded_points, separating_slab

TABLE = "table"
"""Name of the table among the obstacles."""
TABLE_MARGIN = 0.5
"""Extent of the table beyond the objects, m. More keeps a far-reaching elbow off it, but may cover
what stands beside the table."""
TABLE_THICKNESS = 0.1
"""Thickness of the table, m. More stops a hand that comes from below."""
MAX_GROWTH = 0.005
"""Maximum growth of an object for its uncertainty, m. More keeps away from unseen sides, but closes
gaps between objects."""
OCCLUDED_LENGTH = 0.12
"""Length of the occluded space behind an object, m. More is safer, but leaves less free space."""
FINGER_SPACE = 0.03
"""Distance from the target that the occluded space of other objects keeps free, m."""
PUSH_SHRINK = 0.012
"""Shrinkage of other objects when the hand may push them, m. More clears denser piles, but touches
more."""
MAX_SHRINK_SHARE = 0.6
"""Maximum shrinkage as a share of an object's smallest semi-axis. Its core stays an obstacle."""
MIN_HALF_THICKNESS = 0.002
"""Half the thickness of the box around coplanar points, m."""
BACKGROUND_SIDE, MAX_BACKGROUND = 0.05, 48
"""Side of the cells whose readings of no object become a box, m, and their maximum number. More
cells follow such surfaces closer, and slow down the arm's control. Larger cells replace them."""
MIN_READINGS = 4
"""Minimum number of readings of such a cell. Fewer are noise."""
MESH_RESOLUTION = 24
"""Points around the mesh of a superquadric. Its chords cut off 1 mm of a radius of 60 mm."""


def scene_obstacles(
    scene: Scene, target: SceneObject | None = None, *, may_push: bool = False
) -> tuple[Obstacle, ...]:
    """Return the obstacles of a hand on its way to an object.

    Parameters
    ----------
    scene
        Perceived scene.
    target
        The object to grasp. Neither it nor the space behind it is an obstacle, because the fingers
        close there. None makes all objects obstacles.
    may_push
        Whether the hand may push the other objects aside. They shrink instead of growing, and
        occluded space is free.

    Returns
    -------
    tuple of Obstacle
        Obstacles in the scene's frame: ``table``, ``wall N`` of a container, ``unknown N``,
        ``object N`` by label, ``object N, part 2`` and so on for its further solids,
        ``background N`` around readings of no object, and ``behind N``. The last one is the convex
        space between an object, its occluded space and the table. Growth and occluded space never
        close the gap between an object and the target. What overlaps the target, of regions
        without readings and of the background, is no obstacle.
    """
    target_points = hull_points(target) if target is not None else None
    obstacles = []
    if scene.support is not None:
        obstacles.append(_table(scene))
    walls = [wall for container in scene.containers for wall in container.walls]
    obstacles += [_wall(wall, f"wall {number}") for number, wall in enumerate(walls, start=1)]
    for number, region in enumerate(scene.unknown, start=1):
        if target_points is None or separating_slab(region.corners, target_points).width > 0.0:
            shape = ConvexMesh(region.corners)
            obstacles.append(Obstacle(f"unknown {number}", shape, RigidTransform.identity()))
    obstacles += _background(scene.background, target_points)
    for item in scene.objects:
        if target is not None and item.label == target.label:
            continue
        points = hull_points(item)
        if len(points) == 0:
            continue
        slab = None
        if target_points is not None and len(target_points):
            slab = separating_slab(points, target_points)
        growth = min(max_side_std(item.fit), MAX_GROWTH)
        if slab is not None:
            growth = min(growth, max(0.5 * slab.width, 0.0))
        obstacles += _object(item, points, growth, may_shrink=target is not None and may_push)
        if not may_push:
            occluded = _occluded_space(scene, item, points, slab)
            if occluded is not None:
                obstacles.append(occluded)
    return tuple(obstacles)


def solid_obstacle(solid: Superquadric, growth: float, name: str) -> Obstacle:
    """Return a solid, grown by a length in m, as a primitive or as the hull of its mesh."""
    axes = solid.semi_axes + growth
    match solid.kind:
        case "sphere":
            shape = Sphere(float(axes[0]))
        case "ellipsoid":
            shape = Ellipsoid(axes)
        case "cylinder":
            shape = Cylinder(float(axes[0]), float(axes[2]))
        case "box":
            shape = Box(axes)
        case _:
            local = solid.to_local(mesh(solid, MESH_RESOLUTION)[0])
            return Obstacle(name, ConvexMesh(local * (axes / solid.semi_axes)), solid.pose)
    return Obstacle(name, shape, solid.pose)


def _object(
    item: SceneObject, points: NDArray[np.float64], growth: float, *, may_shrink: bool
) -> list[Obstacle]:
    name = f"object {item.label}"
    obstacles = []
    for solid in item.fit.parts or (item.fit.superquadric,):
        if solid is None or not item.fit:
            break
        if may_shrink:
            growth = -min(PUSH_SHRINK, MAX_SHRINK_SHARE * float(solid.semi_axes.min()))
        part = f"{name}, part {len(obstacles) + 1}" if obstacles else name
        obstacles.append(solid_obstacle(solid, growth, part))
    if obstacles:
        return obstacles
    try:
        return [Obstacle(name, ConvexMesh(points), RigidTransform.identity())]
    except InputError:
        return [_box_around(points, name)]


def _background(points: NDArray[np.float64], target: NDArray[np.float64] | None) -> list[Obstacle]:
    """Return boxes around readings of no object (N, 3), m, apart from those at the target."""
    side, index, count = BACKGROUND_SIDE, np.zeros(0, np.int64), np.zeros(0, np.int64)
    while len(points):
        _, index, count = np.unique(
            np.floor(points / side), axis=0, return_inverse=True, return_counts=True
        )
        if len(count) <= MAX_BACKGROUND:
            break
        side *= 1.5
    parts = [points[index.ravel() == k] for k in np.flatnonzero(count >= MIN_READINGS)]
    if target is not None:
        parts = [part for part in parts if separating_slab(part, target).width > 0.0]
    return [_box_around(part, f"background {k}") for k, part in enumerate(parts, start=1)]


def _box_around(points: NDArray[np.float64], name: str) -> Obstacle:
    """Return the box along the axes around points (N, 3), m."""
    half = np.maximum(0.5 * np.ptp(points, axis=0), MIN_HALF_THICKNESS)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return Obstacle(name, Box(half), RigidTransform.from_translation(middle))


def _occluded_space(
    scene: Scene, item: SceneObject, points: NDArray[np.float64], slab: Slab | None
) -> Obstacle | None:
    if slab is not None and slab.width <= 0.0:
        return None
    corners = occluded_points(
        points, scene.view_origin, scene.support, OCCLUDED_LENGTH, slab, FINGER_SPACE
    )
    try:
        return Obstacle(f"behind {item.label}", ConvexMesh(corners), RigidTransform.identity())
    except InputError:
        return None


def _wall(wall: Wall, name: str) -> Obstacle:
    """Return the box outside the inner face of a wall."""
    axes, (low, high) = wall.axes.T, wall.bounds()
    pose = RigidTransform.from_components(axes @ (0.5 * (low + high)), Rotation.from_matrix(axes))
    return Obstacle(name, Box(0.5 * (high - low)), pose)


def _table(scene: Scene) -> Obstacle:
    support = scene.support
    assert support is not None
    side, other = perpendicular_pair(support.normal)
    axes = np.column_stack([side, other, support.normal])
    clouds = [item.points for item in scene.objects if len(item.points)]
    points = np.vstack(clouds) if clouds else scene.view_origin[None]
    plan = points @ axes[:, :2]
    low, high = plan.min(axis=0), plan.max(axis=0)
    half = np.append(0.5 * (high - low) + TABLE_MARGIN, 0.5 * TABLE_THICKNESS)
    centre = axes @ np.append(0.5 * (low + high), -support.offset - half[2])
    pose = RigidTransform.from_components(centre, Rotation.from_matrix(axes))
    return Obstacle(TABLE, Box(half), pose)
