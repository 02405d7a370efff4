"""Observe the table: take depth images until one of them, or several fused, give a valid scene."""

from __future__ import annotations

import logging
import time
from dataclasses import replace
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np

from eyehand.errors import DeviceError, InputError
from eyehand.perception import mask_volumes

from .frame_fusion import fuse_frames
from .robot_checks import check_frame
from .robot_watch import one_line
from .scene_validation import WALL_MARGIN, validate_scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame, Scene

    from .cell import Cell
    from .tray import Tray

_log = logging.getLogger("eyehand")

MAX_FRAMES = 5
"""Number of depth images fused when one image gives no valid scene. A pixel without a reading in
one image usually has one in another; a camera takes so many in 0.2 s."""
MIN_TRAY_SHARE = 0.8
"""Minimum share of the readings of a wall of the tray that lie at it. The others are flying pixels.
An object that touches a wall has a smaller share, unless it is less than 20 mm wide."""


def observe(cell: Cell) -> tuple[Scene | None, float, str]:
    """Capture a depth image and perceive the scene in it.

    If the scene is not valid, more images are captured and fused.

    Returns
    -------
    tuple
        The scene without the tray and the objects in it, or None; the computing time in ms; and the
        reason why there is no valid scene, empty otherwise.
    """
    cell.enter("observe")
    frames: list[DepthFrame] = []
    frame: DepthFrame | None = None
    spent, problem = 0.0, ""
    for count in (1, MAX_FRAMES - 1):
        began = time.perf_counter()
        try:
            for _ in range(count):
                frames.append(_capture(cell))
            began = time.perf_counter()
            frame = fuse_frames(frames)
            scene = _without_tray(cell.perceive(frame), cell.tray)
            problem = validate_scene(frame, scene, cell.tray, cell.scene)
        except (InputError, DeviceError) as error:
            scene, problem = None, f"no valid depth image: {error}"
        spent += 1e3 * (time.perf_counter() - began)
        if scene is not None and not problem:
            cell.scene, cell.frame = scene, frame
            return scene, spent, ""
    return None, spent, problem


def _capture(cell: Cell) -> DepthFrame:
    """Capture a depth image, and remove the readings of the robot.

    Whatever the camera's driver raises becomes a `DeviceError`.
    """
    try:
        frame = cell.robot.capture()
    except Exception as error:
        raise DeviceError(one_line(error)) from error
    check_frame(frame)
    # Not the image itself: a driver may use its memory again.
    cell.image_checksum = crc32(frame.depth.tobytes())
    masked = mask_volumes(frame, cell.robot_volumes())
    share = 1.0 - np.count_nonzero(masked.depth) / max(np.count_nonzero(frame.depth), 1)
    if share > 0.0:
        _log.info("readings on the robot, by its description: %.0f %%", 100.0 * share)
    return masked


def _without_tray(scene: Scene, tray: Tray) -> Scene:
    """Return a scene without the objects and the background in the tray, and without its walls."""
    objects = tuple(item for item in scene.objects if not _is_in_tray(item.points, tray))
    if len(objects) < len(scene.objects):
        _log.info("objects in the tray, or walls of it: %d", len(scene.objects) - len(objects))
    background = scene.background[~tray.encloses(scene.background, WALL_MARGIN)]
    return replace(scene, objects=objects, background=background)


def _is_in_tray(points: NDArray[np.float64], tray: Tray) -> bool:
    """Return whether points (N, 3), world, m, belong to the tray or to an object in it."""
    wall = float(tray.encloses(points, WALL_MARGIN).mean()) >= MIN_TRAY_SHARE
    return wall or tray.contains(points.mean(axis=0))
