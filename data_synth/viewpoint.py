"""Where the camera of a random scene stands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception.frame import CameraIntrinsics
from eyehand.perception.superquadric import mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike, NDArray

    from eyehand.perception.superquadric import Superquadric

    from .tabletop_options import ViewOptions

_DRAWS = 60
_OUTLINE_RESOLUTION = 16
_COARSE = 4
"""Visible shares are counted on every fourth column and row."""


def look_at(eye: ArrayLike, target: ArrayLike) -> RigidTransform:
    """T_world_camera of a camera at `eye` whose optical axis goes through `target`.

    Image columns stay level (camera x is horizontal in the world).

    Parameters
    ----------
    eye, target
        World points (3,), m.

    Raises
    ------
    InputError
        If the line of sight is vertical or has no length.
    """
    eye = np.asarray(eye, dtype=np.float64)
    forward = np.asarray(target, dtype=np.float64) - eye
    right = np.cross(forward, [0.0, 0.0, 1.0])
    if np.linalg.norm(right) < 1e-9:
        raise InputError(
            f"the line of sight must not be vertical, got eye {eye.tolist()} and "
            f"target {(eye + forward).tolist()}"
        )
    z = forward / np.linalg.norm(forward)
    x = right / np.linalg.norm(right)
    axes = np.column_stack([x, np.cross(z, x), z])
    return RigidTransform.from_components(eye, Rotation.from_matrix(axes))


def camera_intrinsics(options: ViewOptions) -> CameraIntrinsics:
    """Pinhole camera of the chosen size, its principal point in the middle of the image."""
    width, height = options.image_size
    focal = options.focal_share * width
    return CameraIntrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)


def draw_viewpoint(
    shapes: Sequence[Superquadric],
    options: ViewOptions,
    rng: np.random.Generator,
    seen: Callable[[CameraIntrinsics, RigidTransform], NDArray[np.intp]],
) -> RigidTransform | None:
    """Draw a place for the camera from which all solids lie whole in the image, none hidden.

    Parameters
    ----------
    shapes
        Solids in the world; the camera looks at the middle of their centres.
    options
        Ranges of elevation and distance, and the image.
    rng
        Source of randomness.
    seen
        Pixels that a camera with these intrinsics at this T_world_camera sees of each solid.

    Returns
    -------
    RigidTransform or None
        T_world_camera, or None when no draw showed all of them.
    """
    camera = camera_intrinsics(options)
    coarse = _coarser(camera)
    centres = np.array([shape.centre for shape in shapes])
    target = (centres.min(axis=0) + centres.max(axis=0)) / 2
    vertices = np.vstack([mesh(shape, _OUTLINE_RESOLUTION)[0] for shape in shapes])
    last = np.array([camera.width - 1, camera.height - 1])
    for _ in range(_DRAWS):
        azimuth = rng.uniform(0, 2 * np.pi)
        elevation = rng.uniform(*options.elevation_range)
        distance = rng.uniform(*options.distance_range)
        level = np.cos(elevation)
        towards = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
        T_world_camera = look_at(target + distance * np.array(towards), target)
        pixels = camera.project(T_world_camera.inv().apply(vertices))
        # NaN behind the camera fails both comparisons.
        if np.all((pixels >= options.margin) & (pixels <= last - options.margin)):
            shown = seen(coarse, T_world_camera) / (coarse.width * coarse.height)
            if shown.min() >= options.least_share:
                return T_world_camera
    return None


def _coarser(camera: CameraIntrinsics) -> CameraIntrinsics:
    """Return the same field of view in a quarter of the columns and rows."""
    k = camera
    width, height = max(k.width // _COARSE, 1), max(k.height // _COARSE, 1)
    x, y = width / k.width, height / k.height
    cx, cy = (k.cx + 0.5) * x - 0.5, (k.cy + 0.5) * y - 0.5
    return CameraIntrinsics(k.fx * x, k.fy * y, cx, cy, width, height)
