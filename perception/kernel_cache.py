"""Compilation of all numba kernels ahead of the first frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .frame import CameraIntrinsics, DepthFrame
from .scene import Scene, perceive
from .segmentation import SegmentationOptions, segment
from .segmentation.cut_necks import NECK, separate_parts
from .segmentation.furniture_walls import Face, remove_faces
from .segmentation.local_planes import LocalPlanes, fit_centred_windows
from .segmentation.remove_steep import MIN_COSINE, NEARER, REACH, count_nearer, count_steep
from .segmentation.select_objects import count_inner
from .segmentation.sliver_pixels import replace_by_nearest
from .segmentation.working_image import working_image
from .superquadric.levenberg_marquardt import descend


def kernels_are_cached() -> bool:
    """Report whether the kernels of this version of the code are compiled and stored on disk."""
    for kernel in (fit_centred_windows, descend):
        folder = Path(kernel.stats.cache_path or ".")
        source = Path(kernel.py_func.__code__.co_filename)
        pattern = f"{source.stem}.{kernel.py_func.__qualname__}-*.nbi"
        indices = list(folder.glob(pattern)) if folder.is_dir() else []
        if not any(index.stat().st_mtime >= source.stat().st_mtime for index in indices):
            return False
    return True


def warm_up() -> Scene:
    """Compile or load every kernel, so that the first frame is as fast as the next ones.

    It perceives a small synthetic frame: two balls on a plane, one in front of the other. The
    frame is also segmented at half resolution, and with a coloured bin and missing readings in
    view, which uses further kernels. An L-shaped object needs the kernels of several
    parts.

    Returns
    -------
    Scene
        The scene of the two balls, 12 cm wide. A caller loads the kernels of its own steps with it.
    """
    camera = CameraIntrinsics(100.0, 100.0, 63.5, 47.5, 128, 96)
    rays = camera.rays()
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    up = np.array([0.0, -0.8, -0.6])
    plane = 0.5 / np.maximum(-(rays @ up), 1e-6)
    ball = np.minimum(_ball(rays, -0.05, 0.48), _ball(rays, 0.06, 0.56))
    distance = np.minimum(plane, ball)
    depth = np.where(distance < 2.0, distance * rays[..., 2], 0.0)
    frame = DepthFrame(depth.astype(np.float32), camera)
    scene = perceive(frame)
    perceive(_angle_frame(camera))
    segment(frame, SegmentationOptions(stride=2))
    segment(_bin_frame(camera))
    # Small images have no slivers, no seams, no necks, no small regions and no furniture.
    image = working_image(frame, 1)
    wall = Face(np.eye(3), 0.0, 0.0, np.zeros(2), np.zeros(2))
    remove_faces(np.ones(depth.shape, np.bool_), image, [wall])
    ones, second, flat = np.ones((8, 8), np.int32), np.array([False, True]), np.ones((8, 8), "f4")
    replace_by_nearest(ones, second, 1)
    separate_parts(ones, second, flat, 2.0, NECK)
    count_inner(np.arange(8, dtype=np.int32), ones)
    count_steep(ones, second, LocalPlanes(flat, flat, flat, flat), image.pinhole, MIN_COSINE)
    count_nearer(ones, second, flat, NEARER, REACH)
    return scene


def _angle_frame(camera: CameraIntrinsics) -> DepthFrame:
    """Return a view from above on an angle of two bars."""
    depth = np.full((camera.height, camera.width), 0.6, np.float32)
    depth[30:70, 40:50] = depth[60:70, 40:80] = 0.56
    return DepthFrame(depth, camera)


def _bin_frame(camera: CameraIntrinsics) -> DepthFrame:
    """Return a view from above into a bin with a box of two colours, and with missing readings."""
    depth = np.full((camera.height, camera.width), 0.6, np.float32)
    depth[18:78, 32:96] = 0.5
    depth[22:74, 36:92] = 0.6
    depth[34:60, 44:60] = depth[34:60, 64:80] = 0.55
    depth[34:60, 60:64] = 0.53
    missing = np.random.default_rng(0).random(depth.shape) < 0.4
    depth[missing & (np.arange(camera.width) > 76)] = 0.0
    colour = np.zeros((*depth.shape, 3), np.uint8)
    colour[:, 62:] = 200
    return DepthFrame(depth, camera, colour=colour)


def _ball(rays: NDArray[np.float64], x: float, z: float) -> NDArray[np.float64]:
    """Return the distance along unit rays (H, W, 3) to a ball of 6 cm radius, m, or infinity."""
    centre = np.array([x, 0.02, z])
    along = rays @ centre
    square = along**2 - (centre @ centre - 0.06**2)
    return np.where(square > 0, along - np.sqrt(np.maximum(square, 0.0)), np.inf)
