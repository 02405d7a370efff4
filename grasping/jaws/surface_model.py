"""Surface points with normals of each object: measured ones, and those of its fitted solids."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.perception import Superquadric, perpendicular_pair

from .point_blocks import point_blocks

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject, SupportPlane
    from eyehand.perception.superquadric import Vessel

    from .point_blocks import Spheres

MIN_GRID, MAX_GRID = 11, 41
"""Samples along each side of the cube that is projected onto a solid, between which its size
decides: 6 · 11² = 726 points are 6 mm apart on a box of 60 x 60 x 100 mm."""
SAMPLE_SPACING = 0.006
"""Distance of the samples on larger solids, m."""
VOXEL = 0.006
"""Side of the cells in which measured points are averaged, m. It removes a part of the noise."""
SURFACE_BLOCK = 0.015
"""Side of the blocks of a surface's points, m: a little less than the side of a pad."""
MAX_MEASURED = 2000
"""Maximum number of averaged points per object."""
MIN_FALLBACK_POINTS = 12
"""Minimum number of points from which a box is fitted to an object without a solid."""
MIN_SIDE = 0.004
"""Minimum side of such a box, m."""
TOLERANCE = 1e-4
"""Minimum depth of the inner side of a vessel's wall, m."""
FLAT = 0.7
"""Cosine between a normal and the opening of a ring above which the surface is no wall."""
AWAY = -0.2
"""Cosine between the normal of the solid at a reading and its line of sight below which the reading
does not lie on that side: the camera cannot see it."""
MAX_GAP, FOOT_HEIGHT = 0.010, 0.006
"""Height of a solid above the support up to which it stands on it, and height of its foot above
its lowest point, m."""
MIN_FOOT = 0.003
"""Minimum distance of the centre of mass of a standing object from the edge of its foot, m."""
DIRECTIONS = 180
"""Number of directions in which this distance is computed."""
_SQUARE = 0.1
"""Exponent of a box with slightly rounded edges."""


@dataclass(frozen=True, eq=False)
class ObjectSurface:
    """What is known of an object's surface, in the scene's frame."""

    label: int
    """Label of the object."""
    points: NDArray[np.float64]
    """Points, (N, 3), m: first the measured ones, then those of the solids."""
    normals: NDArray[np.float64]
    """Outward unit normals, (N, 3)."""
    blocks: Spheres
    """Spheres around blocks of points; no block has both measured points and those of solids."""
    measured: int
    """Number of measured points."""
    solids: tuple[Superquadric, ...]
    """Solids, largest first."""
    centre: NDArray[np.float64]
    """Estimated centre of mass, (3,), m."""
    volume: float
    """Volume of the solids, m³."""
    accepted: bool
    """Whether the fit accepted the solids."""
    boxed: bool
    """Whether a box around the points stands in for the solids, because the fit found none."""
    stands: bool = True
    """Whether the object would not topple if it were its solids, or something else holds it. An
    object that stands although its solids would topple continues behind its visible side."""
    vessel: Vessel | None = None
    """The object as a vessel whose wall can be gripped at the rim; None for another object."""

    @property
    def size(self) -> NDArray[np.float64]:
        """Sizes of the largest solid along its axes, sorted, (3,), m."""
        largest = max(self.solids, key=lambda solid: solid.volume)
        return np.sort(2.0 * largest.semi_axes)


def object_surface(item: SceneObject, scene: Scene) -> ObjectSurface | None:
    """Sample the surface of an object; None if it has too few points for a box."""
    measured = _averaged(item.points)
    fit = item.fit
    solids = fit.parts or ((fit.superquadric,) if fit.superquadric is not None else ())
    boxed = not solids
    if boxed:
        box = _enclosing_box(item.points, _up(scene), scene)
        if box is None:
            return None
        solids = (box,)
    if fit.vessel is None:
        samples, normals = _solid_samples(solids)
        nearest = _nearest_normals(measured, solids)
    else:
        samples, normals = _vessel_samples(fit.vessel)
        nearest = fit.vessel.normals(measured)
    volumes = np.array([solid.volume for solid in solids])
    centre = volumes @ np.array([solid.centre for solid in solids]) / volumes.sum()
    sight = scene.view_origin - measured
    away = np.einsum("ij,ij->i", nearest, sight) < AWAY * np.linalg.norm(sight, axis=1)
    nearest[away] = 0.0
    blocks = point_blocks([measured, samples], [0, 1], SURFACE_BLOCK)
    return ObjectSurface(
        label=item.label,
        points=blocks.points,
        normals=np.concatenate([nearest, normals])[blocks.order],
        blocks=blocks.blocks,
        measured=len(measured),
        solids=tuple(solids),
        centre=centre,
        volume=float(volumes.sum()),
        accepted=bool(fit),
        boxed=boxed,
        stands=_stands(blocks.points, centre, item, scene.support),
        vessel=fit.vessel,
    )


def _stands(
    points: NDArray[np.float64],
    centre: NDArray[np.float64],
    item: SceneObject,
    support: SupportPlane | None,
) -> bool:
    """Return whether a centre of mass (3,) lies over the points (N, 3) that touch the support.

    An object that lies on another one has no such points.
    """
    if support is None:
        return True
    height = support.height(points)
    foot = points[height < min(float(height.min()), MAX_GAP) + FOOT_HEIGHT]
    if len(foot) == 0:
        return bool(item.rests_on)
    angle = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS
    level = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ perpendicular_pair(support.normal)
    return bool(((foot - centre) @ level.T).max(axis=0).min() >= MIN_FOOT)


def _up(scene: Scene) -> NDArray[np.float64]:
    if scene.support is not None:
        return scene.support.normal
    return np.array([0.0, 0.0, 1.0 if scene.reference_frame == "world" else -1.0])


def _averaged(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Average points in the cells of a grid, at most ``MAX_MEASURED``."""
    if len(points) == 0:
        return np.zeros((0, 3))
    cell = np.floor(points / VOXEL).astype(np.int64)
    cell -= cell.min(axis=0)
    size = cell.max(axis=0) + 1
    key = (cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2]
    _, index, count = np.unique(key, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(index, points[:, axis]) for axis in range(3)], axis=1)
    means = sums / count[:, None]
    if len(means) > MAX_MEASURED:
        means = means[:: -(-len(means) // MAX_MEASURED)]
    return means


@cache
def _cube(count: int) -> NDArray[np.float64]:
    """Return points on the cube [-1, 1]³, `count` along each side, (6 count², 3)."""
    line = (np.arange(count) + 0.5) / count * 2.0 - 1.0
    u, v = (part.ravel() for part in np.meshgrid(line, line))
    one = np.ones_like(u)
    faces = []
    for axis in range(3):
        for side in (-one, one):
            faces.append(np.roll(np.column_stack([side, u, v]), axis, axis=1))
    return np.concatenate(faces)


def _solid_samples(
    solids: tuple[Superquadric, ...],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sample the surface of a union of solids: points (N, 3) and normals (N, 3)."""
    points, normals = [], []
    for number, solid in enumerate(solids):
        # Of the middle axis: the long sides of a thin object would have more samples than needed.
        count = int(2.0 * np.median(solid.semi_axes) / SAMPLE_SPACING)
        cube = _cube(min(max(count, MIN_GRID), MAX_GRID))
        surface = solid.project_radially(solid.to_parent(cube * solid.semi_axes))
        outside = np.ones(len(surface), bool)
        for other, part in enumerate(solids):
            if other != number:
                outside &= ~part.contains(surface)
        points.append(surface[outside])
        normals.append(solid.normals(surface[outside]))
    return np.concatenate(points), np.concatenate(normals)


def _vessel_samples(vessel: Vessel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sample both sides of a vessel's wall, and its floor: points (N, 3) and normals (N, 3)."""
    outer, outwards = _solid_samples((vessel.outer,))
    # The outer solid is closed: its top is no surface.
    below = (vessel.heights(outer) < 0.0) & (outwards @ vessel.opening < FLAT)
    outer, outwards = outer[below], outwards[below]
    inner = outer - vessel.drawn_wall * outwards
    kept = (vessel.heights(inner) < 0.0) & (vessel.outer.distance(inner) < -TOLERANCE)
    if vessel.through:
        kept &= np.abs(outwards @ vessel.opening) < FLAT
    return np.concatenate([outer, inner[kept]]), np.concatenate([outwards, -outwards[kept]])


def _nearest_normals(
    points: NDArray[np.float64], solids: tuple[Superquadric, ...]
) -> NDArray[np.float64]:
    """Return the normal (N, 3) of the nearest solid at each point."""
    if len(solids) == 1 or len(points) == 0:
        return solids[0].normals(points)
    distance = np.abs([solid.distance(points) for solid in solids])
    choice = np.argmin(distance, axis=0)
    normals = np.empty_like(points)
    for number, solid in enumerate(solids):
        mine = choice == number
        normals[mine] = solid.normals(points[mine])
    return normals


def _enclosing_box(
    points: NDArray[np.float64], up: NDArray[np.float64], scene: Scene
) -> Superquadric | None:
    """Return the upright box of least area around points, down to the support if that is near."""
    if len(points) < MIN_FALLBACK_POINTS:
        return None
    across = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    across /= np.linalg.norm(across)
    frame = np.stack([across, np.cross(up, across), up])
    local = points @ frame.T
    angles = np.arange(0.0, np.pi / 2, np.pi / 24)
    best = None
    for angle in angles:
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        flat = local[:, :2] @ turn.T
        low, high = np.percentile(flat, [2, 98], axis=0)
        area = float(np.prod(high - low))
        if best is None or area < best[0]:
            best = area, turn, low, high
    assert best is not None
    _, turn, low, high = best
    bottom, top = np.percentile(local[:, 2], [2, 98])
    if scene.support is not None:
        bottom = min(bottom, top - MIN_SIDE)
        ground = -scene.support.offset
        bottom = ground if bottom - ground < 0.03 else bottom
    axes = np.vstack([turn @ frame[:2], up])
    middle = np.append(0.5 * (low + high), 0.5 * (bottom + top))
    half = np.maximum(0.5 * np.append(high - low, top - bottom), 0.5 * MIN_SIDE)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = axes.T, middle @ axes
    if np.linalg.det(matrix[:3, :3]) < 0:
        matrix[:3, 0] *= -1.0
    pose = RigidTransform.from_matrix(matrix)
    return Superquadric(half, (_SQUARE, _SQUARE), pose, "box")
