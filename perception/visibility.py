"""Outlines of solids in the image, their visible share, and the empty space around objects."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from .frame import CameraIntrinsics, DepthFrame
from .superquadric import FreeSpace, Superquadric, SuperquadricFit, mesh

OUTLINE_RESOLUTION = 24
"""Mesh resolution of an outline. A finer mesh follows rims more closely and costs time."""
RASTER_PX = 512
"""Side of the image on which the outlines of several parts are drawn to measure their union, px."""
GRID_RAYS = 1200
"""Approximate number of rays around one object."""
SURROUNDINGS = 0.5
"""Width of the surroundings of the object's box, as a share of its longer side ..."""
MIN_SURROUNDINGS_PX = 8
"""... plus this, px."""
EDGE_PX = 2
"""Pixels beside an edge that may mix two surfaces."""


def outline(
    solid: Superquadric, camera: CameraIntrinsics, T_camera_scene: RigidTransform
) -> NDArray[np.float64] | None:
    """Return the outline polygon (K, 2) of a solid in the image, px.

    A superquadric with exponents up to 2 is convex, so its outline is the convex hull of the
    projected surface. The result is None if the solid reaches behind the camera.
    """
    vertices, _ = mesh(solid, OUTLINE_RESOLUTION)
    pixels = camera.project(T_camera_scene.apply(vertices))
    if not np.all(np.isfinite(pixels)):
        return None
    hull = cv2.convexHull(pixels.astype(np.float32)).reshape(-1, 2)
    return hull.astype(np.float64)


def outline_points(
    solid: Superquadric,
    polygon: NDArray[np.float64],
    camera: CameraIntrinsics,
    T_camera_scene: RigidTransform,
) -> NDArray[np.float64]:
    """Return the surface points (K, 3), m, scene frame, of the corners (K, 2) of an outline, px."""
    vertices, _ = mesh(solid, OUTLINE_RESOLUTION)
    pixels = camera.project(T_camera_scene.apply(vertices))
    return vertices[np.argmin(np.linalg.norm(polygon[:, None] - pixels, axis=2), axis=1)]


def view_free_space(
    mask: NDArray[np.bool_], frame: DepthFrame, T_scene_camera: RigidTransform
) -> FreeSpace:
    """Return the space around an object that a depth frame shows to be empty.

    The rays are pixels on a regular grid over the object's box and its surroundings. Each depth is
    the smallest reading within EDGE_PX of the pixel, because pixels at an edge mix two surfaces. A
    pixel of the object takes it from the object's own pixels, so that its depth is not that of an
    occluder beside it. Pixels without a reading have depth 0.

    Parameters
    ----------
    mask
        The object's pixels (H, W).
    frame
        The depth frame.
    T_scene_camera
        Maps camera coordinates to scene coordinates.
    """
    camera = frame.intrinsics
    mask = np.ascontiguousarray(mask, dtype=bool)
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    origin = np.asarray(T_scene_camera.translation)
    if not width:
        none = np.zeros(0)
        return FreeSpace(origin, np.zeros((0, 3)), none, none.astype(bool), 0.0)
    around = int(SURROUNDINGS * (max(width, height) - 1)) + MIN_SURROUNDINGS_PX
    bottom, right = top + height + around, left + width + around
    top, left = max(top - around, 0), max(left - around, 0)
    readings = frame.depth[top:bottom, left:right]
    object_pixels = mask[top:bottom, left:right]
    step = max(round(np.sqrt(readings.size / GRID_RAYS)), 1)
    start = step // 2
    z = nearest_readings(readings, object_pixels, start, step)
    v, u = np.indices(z.shape) * step + start
    rays = np.stack(
        [(u + left - camera.cx) / camera.fx, (v + top - camera.cy) / camera.fy, np.ones(z.shape)],
        axis=-1,
    ).reshape(-1, 3)
    length = np.linalg.norm(rays, axis=1)
    return FreeSpace(
        origin=origin,
        rays=(rays / length[:, None]) @ T_scene_camera.as_matrix()[:3, :3].T,
        depth=z.ravel() * length,
        on_object=object_pixels[start::step, start::step].ravel(),
        pitch=step / camera.fx,
    )


@njit(cache=True, nogil=True)
def nearest_readings(readings, object_pixels, start, step):
    """Return the smallest reading within EDGE_PX of each pixel on a grid, m; 0 = no reading there.

    Around a pixel of the object only the object's readings count.

    Parameters
    ----------
    readings
        Depth (H, W), m; 0 = no reading.
    object_pixels
        The object's pixels (H, W).
    start, step
        First row and column of the grid, and its step, px.
    """
    rows, columns = readings.shape
    down, across = -(-(rows - start) // step), -(-(columns - start) // step)
    nearest = np.zeros((down, across))
    for k in range(down):
        for m in range(across):
            v, u = start + k * step, start + m * step
            if readings[v, u] <= 0:
                continue
            least, inside = readings[v, u], object_pixels[v, u]
            for y in range(max(v - EDGE_PX, 0), min(v + EDGE_PX + 1, rows)):
                for x in range(max(u - EDGE_PX, 0), min(u + EDGE_PX + 1, columns)):
                    z = readings[y, x]
                    if 0 < z < least and (object_pixels[y, x] or not inside):
                        least = z
            nearest[k, m] = least
    return nearest


def visible_share(
    pixels: int,
    fit: SuperquadricFit,
    frame: DepthFrame,
    T_scene_camera: RigidTransform,
) -> float:
    """Return the share of a fit's outline area that the object's own pixels cover, 0-1.

    Occlusion by other objects, the image border and missing readings lower the share. A fit of
    several parts counts as the union of their outlines.
    """
    if fit.superquadric is None or not fit:
        return 0.0
    T_camera_scene = T_scene_camera.inv()
    polygons: list[NDArray[np.float64]] = []
    for part in fit.parts or (fit.superquadric,):
        polygon = outline(part, frame.intrinsics, T_camera_scene)
        if polygon is None:
            return 0.0
        polygons.append(polygon)
    area = _union_area(polygons)
    if area < 1.0:
        return 0.0
    return float(min(pixels / area, 1.0))


def _union_area(polygons: list[NDArray[np.float64]]) -> float:
    """Return the area of the union of polygons (K, 2), px²."""
    if len(polygons) == 1:
        return float(cv2.contourArea(polygons[0].astype(np.float32)))
    low = np.min([polygon.min(axis=0) for polygon in polygons], axis=0)
    reach = float(np.max([(polygon - low).max() for polygon in polygons]))
    scale = RASTER_PX / max(reach, 1.0)
    canvas = np.zeros((RASTER_PX + 1, RASTER_PX + 1), dtype=np.uint8)
    for polygon in polygons:
        cv2.fillConvexPoly(canvas, np.round((polygon - low) * scale).astype(np.int32), 1)
    return float(np.count_nonzero(canvas)) / scale**2
