"""Spheres that together contain a part of the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .mujoco_binding import mujoco

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .collision_options import CoverOptions
    from .mujoco_binding import Model


def cover_parts(
    model: Model, geoms: Sequence[int], options: CoverOptions | None
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Cover several geoms; none if there are no options.

    Returns
    -------
    spheres, covers
        All spheres one after another (B, 4), and of each geom of the model its first sphere and
        their number (geoms, 2).
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
    """Cover a geom: (B, 4), centres in its frame and radii, m; no sphere if it is round already.

    Boxes and capsules are covered closely; a cylinder by the spheres of its bounding box that touch
    it, a mesh by those of its whole bounding box. Spheres and ellipsoids have no flat or long side
    on which the nearest point could jump.
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
        across = np.linalg.norm(spheres[:, :2], axis=1)
        return spheres[across <= size[0] + spheres[:, 3]]
    if kind == kinds.mjGEOM_MESH:
        middle, half = np.split(model.geom_aabb[geom], 2)
        spheres = cover_box(half, options)
        spheres[:, :3] += middle
        return spheres
    return np.empty((0, 4))


def cover_box(half_extents: NDArray[np.float64], options: CoverOptions) -> NDArray[np.float64]:
    """Cover a box with the spheres around the cells of a grid.

    Cells are as cubic as the box allows: a sphere around a cube of edge a stands out of it by
    (√3 - 1) a / 2. If that takes more spheres than allowed, cells grow.

    Parameters
    ----------
    half_extents
        (3,), m.

    Returns
    -------
    spheres
        (B, 4): centres in the box's frame and radii, m.
    """
    edge = 2.0 * options.overhang / (np.sqrt(3.0) - 1.0)
    cells = np.maximum(np.ceil(2.0 * half_extents / edge), 1.0)
    while np.prod(cells) > options.max_spheres:
        # Largest cells last: the direction whose cells are the smallest loses one.
        sizes = np.where(cells > 1.0, 2.0 * half_extents / cells, np.inf)
        cells[int(np.argmin(sizes))] -= 1.0
    places = [_middles(half, int(count)) for half, count in zip(half_extents, cells, strict=True)]
    centres = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, 3)
    radius = float(np.linalg.norm(half_extents / cells))
    return np.column_stack([centres, np.full(len(centres), radius)])


def cover_capsule(radius: float, half_length: float, options: CoverOptions) -> NDArray[np.float64]:
    """Cover a capsule along z with a row of spheres of one radius: (B, 4), as :func:`cover_box`.

    Spheres at distance s along the axis contain the capsule if their radius is √(r² + s²/4).
    """
    most = np.sqrt((radius + options.overhang) ** 2 - radius**2)
    gaps = min(int(np.ceil(half_length / most)), max(options.max_spheres - 1, 1))
    places = np.linspace(-half_length, half_length, gaps + 1)
    size = float(np.hypot(radius, half_length / gaps))
    if options.max_spheres == 1:
        places, size = np.zeros(1), radius + half_length
    return np.column_stack([np.zeros((len(places), 2)), places, np.full(len(places), size)])


def _middles(half: float, count: int) -> NDArray[np.float64]:
    return half * (2.0 * np.arange(count) + 1.0 - count) / count
