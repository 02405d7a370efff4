"""Outlines of solids in the image, and the visible share of their area."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from .superquadric import Superquadric, SuperquadricFit, mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from .frame import CameraIntrinsics, DepthFrame

OUTLINE_RESOLUTION = 24
"""Mesh resolution of an outline. A finer mesh follows rims more closely and costs time."""
RASTER_PX = 512
"""Side of the image on which the outlines of several parts are drawn to measure their union, px."""
OCCLUDER_GAP = 0.01
"""A reading this much nearer than the object's edge belongs to an object in front, m."""
OCCLUDER_STRIDE = 4
"""Every n-th point of the object is used to find the depth of its edge."""


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


def hidden_rays(
    rays: NDArray[np.float64],
    cloud: NDArray[np.float64],
    frame: DepthFrame,
    T_scene_camera: RigidTransform,
    mask: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Return a mask (K,) of the view directions that carry no information on an object's outline.

    Such a ray leaves the image, ends on an object in front, or ends on the object itself. Rays of
    the last kind pass the removed border of the object's segment.

    Parameters
    ----------
    rays
        Directions (K, 3) from the camera that pass close to the object, scene frame.
    cloud
        The object's points (N, 3), m, scene frame. The point nearest to a ray in the image gives
        the depth to compare with.
    frame
        The depth frame.
    T_scene_camera
        Maps camera coordinates to scene coordinates.
    mask
        The object's pixels (H, W), its border included.
    """
    camera = frame.intrinsics
    matrix = T_scene_camera.as_matrix()
    R, t = matrix[:3, :3], matrix[:3, 3]
    pixels = camera.project(rays @ R)
    object_points = (cloud[::OCCLUDER_STRIDE] - t) @ R
    object_pixels = camera.project(object_points)
    distances = np.linalg.norm(pixels[:, None] - object_pixels[None], axis=-1)
    object_depth = object_points[np.argmin(distances, axis=1), 2]
    columns, rows = np.round(np.nan_to_num(pixels, nan=-1.0)).astype(int).T
    outside = (columns < 0) | (rows < 0) | (columns >= camera.width) | (rows >= camera.height)
    columns = np.clip(columns, 0, camera.width - 1)
    rows = np.clip(rows, 0, camera.height - 1)
    measured = frame.depth[rows, columns]
    in_front = (measured > 0) & (measured < object_depth - OCCLUDER_GAP)
    return outside | in_front | mask[rows, columns]


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
