"""How much of a solid's outline the camera saw as that object."""

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
"""Mesh resolution behind an outline; more follows rims closer."""

RASTER = 512
"""Pixels across which outlines of several parts are drawn to tell the area they cover together."""

OCCLUDER_GAP = 0.01
"""A reading this much nearer than the object's edge belongs to something before it, m."""
OCCLUDER_STRIDE = 4
"""Every n-th of the object's points stands for its edge's depth."""


def outline(
    solid: Superquadric, camera: CameraIntrinsics, T_camera_scene: RigidTransform
) -> NDArray[np.float64] | None:
    """Outline polygon (K, 2) of a solid in the image, px; None where it reaches behind the camera.

    A superquadric with exponents up to 2 is convex, so its outline is the convex hull of the
    projected surface.
    """
    vertices, _ = mesh(solid, OUTLINE_RESOLUTION)
    pixels = camera.project(T_camera_scene.apply(vertices))
    if not np.all(np.isfinite(pixels)):
        return None
    hull = cv2.convexHull(pixels.astype(np.float32)).reshape(-1, 2)
    return hull.astype(np.float64)


def hidden_rays(
    rays: NDArray[np.float64],
    cloud: NDArray[np.float64],
    frame: DepthFrame,
    T_scene_camera: RigidTransform,
    mask: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Tell which rays from the camera say nothing about an object's outline.

    They leave the image, end on something before the object, or on the object itself, where its
    outline is cut and its border peeled.

    Parameters
    ----------
    rays
        (K, 3) directions in the scene's frame that pass the object closely.
    cloud
        (N, 3) the object's points in the scene's frame; the one nearest to a ray gives the depth
        at which something counts as before it.
    mask
        (H, W) the object's pixels, its border included.
    """
    camera = frame.intrinsics
    matrix = T_scene_camera.as_matrix()
    R, t = matrix[:3, :3], matrix[:3, 3]
    pixels = camera.project(rays @ R)
    own = (cloud[::OCCLUDER_STRIDE] - t) @ R
    own_pixels = camera.project(own)
    gaps = np.linalg.norm(pixels[:, None] - own_pixels[None], axis=-1)
    depth_there = own[np.argmin(gaps, axis=1), 2]
    columns, rows = np.round(np.nan_to_num(pixels, nan=-1.0)).astype(int).T
    outside = (columns < 0) | (rows < 0) | (columns >= camera.width) | (rows >= camera.height)
    columns = np.clip(columns, 0, camera.width - 1)
    rows = np.clip(rows, 0, camera.height - 1)
    seen = frame.depth[rows, columns]
    before = (seen > 0) & (seen < depth_there - OCCLUDER_GAP)
    return outside | before | mask[rows, columns]


def visible_share(
    pixels: int,
    fit: SuperquadricFit,
    frame: DepthFrame,
    T_scene_camera: RigidTransform,
) -> float:
    """Share of a fit's outline area, of all its parts, that the object's own pixels fill, 0-1.

    What another object hides, what lies outside the image, and what has no reading all lower it.
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
    area = _covered(polygons)
    if area < 1.0:
        return 0.0
    return float(min(pixels / area, 1.0))


def _covered(polygons: list[NDArray[np.float64]]) -> float:
    """Area of the union of polygons (K, 2), px²."""
    if len(polygons) == 1:
        return float(cv2.contourArea(polygons[0].astype(np.float32)))
    low = np.min([polygon.min(axis=0) for polygon in polygons], axis=0)
    reach = float(np.max([(polygon - low).max() for polygon in polygons]))
    scale = RASTER / max(reach, 1.0)
    canvas = np.zeros((RASTER + 1, RASTER + 1), dtype=np.uint8)
    for polygon in polygons:
        cv2.fillConvexPoly(canvas, np.round((polygon - low) * scale).astype(np.int32), 1)
    return float(np.count_nonzero(canvas)) / scale**2
