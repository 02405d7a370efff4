"""A scene as obstacles: the table, the other objects, and the space behind them that nobody saw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import Box, ConvexMesh, Cylinder, Ellipsoid, Obstacle, Sphere
from eyehand.errors import InputError
from eyehand.perception import perpendicular_pair
from eyehand.perception.superquadric import mesh

from .fit_uncertainty import side_doubt
from .occlusion import Gap, gap_between, outline, shadow

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject, Superquadric

THINNEST = 0.002
"""Half the thickness of the box that stands for points which lie in one plane, m."""
MESH_RESOLUTION = 24
"""Points around the mesh of a solid that is none of the plain shapes: its chords cut a millimetre
off one of 60 mm."""
MOST_GIVE = 0.6
"""Share of an object's smallest half extent by which it shrinks at most: its core stays."""
TABLE = "table"
"""Name of the table among the obstacles."""


@dataclass(frozen=True)
class SurroundingsOptions:
    """Options of :func:`surroundings`; lengths in m."""

    table_margin: float = 0.5
    """How far the table is taken to go on beyond the objects: more keeps a far-reaching elbow off
    it, and may run into what stands beside the table."""
    table_thickness: float = 0.1
    """Thickness of the table: more stops a hand that came from below it."""
    most_growth: float = 0.005
    """By how much an object grows for what is not sure of it, at most: more keeps farther off sides
    that nobody saw, and closes gaps between objects."""
    unseen: bool = True
    """Whether the space behind objects counts as occupied."""
    unseen_length: float = 0.12
    """How far behind an object that space goes on: more is safer, and leaves the arm less room."""
    give: float = 0.0
    """By how much other objects shrink, where the hand may push them aside, in place of growing:
    more clears denser piles, and touches more."""
    finger_space: float = 0.03
    """Room about the target that unseen space of other objects does not take."""


PUSHING = SurroundingsOptions(unseen=False, give=0.012)
"""For a hand that may push aside what stands around its target."""


def surroundings(
    scene: Scene, target: SceneObject | None = None, options: SurroundingsOptions | None = None
) -> tuple[Obstacle, ...]:
    """Give what a hand must not touch on its way to an object.

    Parameters
    ----------
    scene
        What was seen.
    target
        The object to grasp, which is no obstacle, nor is the space right behind it: fingers close
        there. None: all objects are obstacles.
    options
        Sizes of the table and of unseen space.

    Returns
    -------
    tuple of Obstacle
        In the scene's frame: ``table``, ``object N`` by label, and ``behind N``, the convex space
        between an object and what the camera could not see past it, down to the table. Where the
        object had room beside the target, its growth and unseen space leave it.
    """
    options = options or SurroundingsOptions()
    found = []
    goal = outline(target) if target is not None else None
    if scene.support is not None:
        found.append(_table(scene, options))
    for item in scene.objects:
        if target is not None and item.label == target.label:
            continue
        points = outline(item)
        if len(points) == 0:
            continue
        gap = gap_between(points, goal) if goal is not None and len(goal) else None
        growth = min(side_doubt(item.fit), options.most_growth)
        if gap is not None:
            growth = min(growth, max(0.5 * gap.width, 0.0))
        solid = item.fit.superquadric
        if target is not None and options.give and solid is not None:
            growth = -min(options.give, MOST_GIVE * float(solid.semi_axes.min()))
        found.append(_object(item, points, growth))
        if options.unseen:
            hidden = _behind(scene, item, points, gap, options)
            if hidden is not None:
                found.append(hidden)
    return tuple(found)


def enclosing(solid: Superquadric, growth: float, name: str) -> Obstacle:
    """Enclose a solid, grown by some m, in the plain shape of its kind, or the hull of its mesh."""
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


def _object(item: SceneObject, points: NDArray[np.float64], growth: float) -> Obstacle:
    name = f"object {item.label}"
    solid = item.fit.superquadric
    if solid is not None and item.fit:
        return enclosing(solid, growth, name)
    try:
        return Obstacle(name, ConvexMesh(points), RigidTransform.identity())
    except InputError:
        half = np.maximum(0.5 * np.ptp(points, axis=0), THINNEST)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return Obstacle(name, Box(half), RigidTransform.from_translation(middle))


def _behind(
    scene: Scene,
    item: SceneObject,
    points: NDArray[np.float64],
    gap: Gap | None,
    options: SurroundingsOptions,
) -> Obstacle | None:
    if gap is not None and gap.width <= 0.0:
        return None
    space = shadow(
        points,
        scene.view_origin,
        scene.support,
        options.unseen_length,
        gap,
        options.finger_space,
    )
    try:
        return Obstacle(f"behind {item.label}", ConvexMesh(space), RigidTransform.identity())
    except InputError:
        return None


def _table(scene: Scene, options: SurroundingsOptions) -> Obstacle:
    support = scene.support
    assert support is not None
    side, other = perpendicular_pair(support.normal)
    frame = np.column_stack([side, other, support.normal])
    clouds = [item.points for item in scene.objects if len(item.points)]
    seen = np.vstack(clouds) if clouds else scene.view_origin[None]
    flat = seen @ frame[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    half = np.append(0.5 * (high - low) + options.table_margin, 0.5 * options.table_thickness)
    centre = frame @ np.append(0.5 * (low + high), -support.offset - half[2])
    pose = RigidTransform.from_components(centre, Rotation.from_matrix(frame))
    return Obstacle(TABLE, Box(half), pose)
