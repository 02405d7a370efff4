"""Camera poses: looking at a point, and random viewpoints of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics
from eyehand.perception.superquadric import Superquadric, mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike, NDArray

    from .tabletop_options import TabletopOptions, ViewOptions

FOCAL_SHARE = 525.0 / 640.0
"""Focal length divided by the image width, a typical value of depth cameras."""
MIN_VISIBLE_SHARE = 4e-4
"""Minimum share of the image's pixels that every object covers, approximately. With 0, hidden
objects are allowed. Above 1e-3, small distant objects are excluded."""

_MARGIN_PX = 2.0
"""Every object's outline stays this far inside the image."""
_MAX_DRAWS = 60
_OUTLINE_RESOLUTION = 16
COARSE_STEPS = (4,)
"""Reduction factors of the images in which visible shares are counted: a quarter of the width and
height."""
FINE_STEPS = (4, 2)
"""Reduction factors for fallen objects. The second image, of half the width and height, shows thin
parts of objects between others more exactly than the first. It rejects further views and takes 5
times as long."""


def look_at(eye: ArrayLike, target: ArrayLike) -> RigidTransform:
    """Return T_world_camera of a camera at `eye` whose optical axis goes through `target`.

    Image rows are level: the camera's x-axis is horizontal in the world.

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
    """Return a pinhole camera of this image size, its principal point in the middle."""
    width, height = options.image_size
    focal = FOCAL_SHARE * width
    return CameraIntrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)


def draw_viewpoint(
    shapes: Sequence[Superquadric],
    options: ViewOptions,
    rng: np.random.Generator,
    count_pixels: Callable[[CameraIntrinsics, RigidTransform], NDArray[np.intp]],
    steps: tuple[int, ...] = COARSE_STEPS,
) -> RigidTransform | None:
    """Draw a camera pose that shows all solids completely in the image, none hidden.

    Parameters
    ----------
    shapes
        Solids in the world; the camera looks at the middle of their centres.
    options
        Ranges of elevation and distance, and the image.
    rng
        Source of randomness.
    count_pixels
        Function of intrinsics and T_world_camera that counts the visible pixels of each solid.
    steps
        Reduction factors of the image. In each reduced image, every solid must cover at least
        `MIN_VISIBLE_SHARE`.

    Returns
    -------
    RigidTransform or None
        T_world_camera, or None if no draw showed all of them.
    """
    camera = camera_intrinsics(options)
    cameras = [reduced(camera, step) for step in steps]
    centres = np.array([shape.centre for shape in shapes])
    target = (centres.min(axis=0) + centres.max(axis=0)) / 2
    vertices = np.vstack([mesh(shape, _OUTLINE_RESOLUTION)[0] for shape in shapes])
    last = np.array([camera.width - 1, camera.height - 1])
    for _ in range(_MAX_DRAWS):
        T_world_camera = _random_viewpoint(target, options, rng)
        pixels = camera.project(T_world_camera.inv().apply(vertices))
        # NaN behind the camera fails both comparisons.
        if np.all((pixels >= _MARGIN_PX) & (pixels <= last - _MARGIN_PX)):
            shares = (count_pixels(k, T_world_camera).min() / (k.width * k.height) for k in cameras)
            if all(share >= MIN_VISIBLE_SHARE for share in shares):
                return T_world_camera
    return None


def draw_table_view(options: TabletopOptions, rng: np.random.Generator) -> RigidTransform:
    """Draw a camera pose for an empty table.

    Parameters
    ----------
    options
        Work area and camera ranges; the camera looks at a random point of the work area.
    rng
        Source of randomness.

    Returns
    -------
    RigidTransform
        T_world_camera.
    """
    spot = rng.uniform(-0.5, 0.5, size=2) * options.work_area
    return _random_viewpoint(np.append(spot, options.table_height), options.view, rng)


def _random_viewpoint(
    target: NDArray[np.float64], options: ViewOptions, rng: np.random.Generator
) -> RigidTransform:
    azimuth = rng.uniform(0, 2 * np.pi)
    elevation = rng.uniform(*options.elevation_range)
    distance = rng.uniform(*options.distance_range)
    level = np.cos(elevation)
    towards = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
    return look_at(target + distance * np.array(towards), target)


def reduced(camera: CameraIntrinsics, step: int) -> CameraIntrinsics:
    """Return the intrinsics of an image with width and height divided by `step`."""
    k = camera
    width, height = max(k.width // step, 1), max(k.height // step, 1)
    x, y = width / k.width, height / k.height
    cx, cy = (k.cx + 0.5) * x - 0.5, (k.cy + 0.5) * y - 0.5
    return CameraIntrinsics(k.fx * x, k.fy * y, cx, cy, width, height)
