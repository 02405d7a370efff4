"""Spheres that together contain a part of the robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .collision_options import CoverOptions
from .mujoco_binding import Model, mujoco


def cover_geoms(
    model: Model, geoms: Sequence[int], options: CoverOptions | None
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Cover several geoms with spheres; without options there are no spheres.

    Returns
    -------
    spheres, covers
        The spheres of all geoms one after another (B, 4), see :func:`cover_geom`. For each geom of
        the model, the index of its first sphere and their number (geoms, 2).
    """
    spheres = [np.empty((0, 4))]
    covers = np.zeros((model.ngeom, 2), dtype=np.int64)
    if options is None:
        return spheres[0], covers
    for geom in geoms:
        covers[geom, 0] = sum(map(len, spheres))
        spheres.append(cover_geom(model, geom, options))
        covers[geom, 1] = len(spheres[-1])
    return np.vstack(spheres), covers


def cover_geom(model: Model, geom: int, options: CoverOptions) -> NDArray[np.float64]:
    """Cover one geom with spheres: (B, 4), centres in its frame and radii, m.

    Boxes and capsules are covered closely. A mesh gets the spheres of its bounding box, and a
    cylinder those spheres of its bounding box that touch it. Spheres and ellipsoids get none,
    because they have no flat or long side on which the closest point could jump.
    """
    kinds = mujoco.mjtGeom
    size = model.geom_size[geom]
    kind = model.geom_type[geom]
    if kind == kinds.mjGEOM_BOX:
        return cover_box(size, options)
    if kind == kinds.mjGEOM_CAPSULE:
        return cover_capsule(size[0], size[1], options)
    if kind == kinds.mjGEOM_CYLINDER:
        spheres = cover_box(np.array([size[0], size[0], size[1]]), options)
        from_axis = np.linalg.norm(spheres[:, :2], axis=1)
        return spheres[from_axis <= size[0] + spheres[:, 3]]
    if kind == kinds.mjGEOM_MESH:
        middle, half = np.split(model.geom_aabb[geom], 2)
        spheres = cover_box(half, options)
        spheres[:, :3] += middle
        return spheres
    return np.empty((0, 4))


def cover_box(half_extents: NDArray[np.float64], options: CoverOptions) -> NDArray[np.float64]:
    """Divide a box into the cells of a grid, and cover each cell with its circumscribed sphere.

    The cells are as close to cubes as the box allows. The sphere around a cube of edge a extends
    (√3 - 1) a / 2 beyond it. If there are more cells than allowed, larger cells are used.

    Parameters
    ----------
    half_extents
        (3,), m.
    options
        Limits of overhang and number of spheres.

    Returns
    -------
    spheres
        (B, 4): centres in the box's frame and radii, m.
    """
    edge = 2.0 * options.overhang / (np.sqrt(3.0) - 1.0)
    cells = np.maximum(np.ceil(2.0 * half_extents / edge), 1.0)
    while np.prod(cells) > options.max_spheres:
        # One cell less in the direction in which cells are shortest.
        sizes = np.where(cells > 1.0, 2.0 * half_extents / cells, np.inf)
        cells[int(np.argmin(sizes))] -= 1.0
    middles = [
        half * (2.0 * np.arange(int(count)) + 1.0 - int(count)) / int(count)
        for half, count in zip(half_extents, cells, strict=True)
    ]
    centres = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 3)
    radius = float(np.linalg.norm(half_extents / cells))
    return np.column_stack([centres, np.full(len(centres), radius)])


def cover_capsule(radius: float, half_length: float, options: CoverOptions) -> NDArray[np.float64]:
    """Cover a capsule along z with a row of equal spheres (B, 4), as in :func:`cover_box`.

    Spheres at spacing s along the axis contain the capsule if their radius is √(r² + s²/4).
    """
    max_half_spacing = np.sqrt((radius + options.overhang) ** 2 - radius**2)
    gaps = min(int(np.ceil(half_length / max_half_spacing)), max(options.max_spheres - 1, 1))
    heights = np.linspace(-half_length, half_length, gaps + 1)
    size = float(np.hypot(radius, half_length / gaps))
    if options.max_spheres == 1:
        heights, size = np.zeros(1), radius + half_length
    return np.column_stack([np.zeros((len(heights), 2)), heights, np.full(len(heights), size)])
