"""Remove the walls and the floor of a container from the candidates."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .above_support import BAND_WAVES, MIN_HEIGHT, SUPPORT_SIGMAS
from .measure_container import FoundContainer
from .working_image import WorkingImage

WALL_BAND = 0.006
"""Distance inside and above a wall within which readings belong to it, m: the error of its
measured faces."""
OUTER_MARGIN = 0.012
"""Distance outside a wall up to which readings below its rim belong to it, m."""


def remove_walls(
    above: NDArray[np.bool_], image: WorkingImage, found: FoundContainer
) -> NDArray[np.bool_]:
    """Return the candidates (H, W) without the walls and the floor of a container."""
    rows, columns = found.window
    k = image.intrinsics.cropped(rows, columns)
    rays = (np.arange(k.width) - k.cx) / k.fx, (np.arange(k.height) - k.cy) / k.fy
    plane, depth = found.container.floor, np.ascontiguousarray(image.depth[found.window])
    axes = np.vstack([plane.normal, found.support.axes])
    spread = max(
        SUPPORT_SIGMAS * plane.tolerance / max(found.support.depth, 1e-6) ** 2,
        BAND_WAVES * found.support.wave,
    )
    kept = above.copy()
    part = np.ascontiguousarray(above[found.window])
    unmark_walls(part, depth, rays, (axes, plane.offset, spread), found.sides)
    kept[found.window] = part
    return kept


@njit(cache=True, nogil=True)
def unmark_walls(above, depth, rays, frame, sides):
    """Unmark the readings (H, W) at the walls, up to their rims, and on the floor between them."""
    rows, columns = depth.shape
    rays_u, rays_v = rays
    axes, offset, spread = frame
    for v in range(rows):
        for u in range(columns):
            z = np.float64(depth[v, u])
            if z <= 0 or not above[v, u]:
                continue
            height = z * (axes[0, 0] * rays_u[u] + axes[0, 1] * rays_v[v] + axes[0, 2]) + offset
            x = z * (axes[1, 0] * rays_u[u] + axes[1, 1] * rays_v[v] + axes[1, 2])
            y = z * (axes[2, 0] * rays_u[u] + axes[2, 1] * rays_v[v] + axes[2, 2])
            band = max(spread * z * z, WALL_BAND)
            floor_band = max(spread * z * z, MIN_HEIGHT)
            in_wall, inside, within = False, True, True
            for k in range(len(sides)):
                behind = sides[k, 0] * x + sides[k, 1] * y - sides[k, 2]
                # A rim hides the outer face of a wall that leans outwards.
                within = within and behind < sides[k, 5] + OUTER_MARGIN
                if sides[k, 4] > 0:
                    behind -= sides[k, 4] * (height - sides[k, 3])
                inside = inside and behind < 0
                in_wall = in_wall or (behind > -band and height < sides[k, 3] + band)
            if (within and in_wall) or (inside and height < floor_band):
                above[v, u] = False
