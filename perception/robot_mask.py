"""Removal of readings that are known to be no object: the robot itself, a tray, a wall."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from math import radians

import cv2
import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from eyehand.errors import InputError

from .frame import DepthFrame

MARGIN_PX = 3
"""Pixels around the robot's outline that are removed too. Depth there mixes robot and background,
and jitters."""
MARGIN_M = 0.01
"""Margin around posed volumes, m: the error of a camera's position, and of outlines of links."""
MARGIN_SLOPE = radians(1.0)
"""Further margin per distance from the camera: the error of a camera's direction, rad."""
DIRECTIONS = np.array(
    [np.divide(d, np.linalg.norm(d)) for d in product((-1, 0, 1), repeat=3) if any(d)]
)
"""Normals of the 26 planes around a volume, unit, (26, 3), in its own frame. They leave at
most 8 % of the radius free around a round link."""
AXES = [int(np.argmax(DIRECTIONS @ (sign * axis))) for axis in np.eye(3) for sign in (-1, 1)]
"""Indices of the directions -x, x, -y, y, -z, z: they bound the box around a volume."""


@dataclass(frozen=True)
class PosedVolumes:
    """Convex volumes with their poses, such as the links of a robot.

    Raises
    ------
    InputError
        If the shapes do not agree, or a number is not finite.
    """

    extents: NDArray[np.float64]
    """Extents along `DIRECTIONS` in the volumes' own frames, (N, 26), m; see `volume_extents`."""
    poses: NDArray[np.float64]
    """Poses T_a_volume (N, 4, 4), in the world frame or the camera frame, m."""

    def __post_init__(self) -> None:
        count = len(self.extents)
        if self.extents.shape != (count, 26) or self.poses.shape != (count, 4, 4):
            raise InputError(
                "volumes need extents (N, 26) and poses (N, 4, 4), "
                f"got {self.extents.shape} and {self.poses.shape}"
            )
        if not (np.isfinite(self.extents).all() and np.isfinite(self.poses).all()):
            raise InputError("the extents and poses of volumes must be finite")


def volume_extents(points: Sequence[ArrayLike]) -> NDArray[np.float64]:
    """Return the extents of the convex hulls of N sets of points (V, 3) m, as (N, 26) m."""
    extents = [(np.asarray(one, np.float64) @ DIRECTIONS.T).max(axis=0) for one in points]
    return np.array(extents).reshape(-1, len(DIRECTIONS))


def mask_robot(frame: DepthFrame, robot: NDArray[np.bool_], margin: int = MARGIN_PX) -> DepthFrame:
    """Return a frame without readings on and near the robot.

    Parameters
    ----------
    frame
        The frame.
    robot
        Mask of the robot's pixels, (H, W), for example drawn from its joint angles.
    margin
        Pixels around the mask that are removed too. More pixels forgive a larger error of the
        camera's pose and hide more of the scene.

    Raises
    ------
    InputError
        If no reading is left, or the mask has another size.
    """
    if not robot.any():
        return frame
    side = 2 * margin + 1
    mask = cv2.dilate(robot.astype(np.uint8), np.ones((side, side), np.uint8))
    return frame.without(mask > 0)


def mask_volumes(frame: DepthFrame, volumes: PosedVolumes) -> DepthFrame:
    """Return a frame without readings in and near posed volumes.

    A reading is removed if it lies in a volume that is grown by ``MARGIN_M`` and ``MARGIN_SLOPE``
    times its depth, or in the image within ``MARGIN_PX`` of such a reading. Readings in front of
    the volumes and behind them stay.

    Parameters
    ----------
    frame
        The frame.
    volumes
        The volumes, in the world frame if the frame has `T_world_camera`, else in the camera frame.

    Raises
    ------
    InputError
        If no reading is left.
    """
    poses = volumes.poses
    if frame.T_world_camera is not None:
        poses = frame.T_world_camera.inv().as_matrix() @ poses
    rotations, origins = poses[:, :3, :3], poses[:, :3, 3]
    normals = np.ascontiguousarray(DIRECTIONS @ np.swapaxes(rotations, 1, 2))
    offsets = volumes.extents + np.einsum("nki,ni->nk", normals, origins)
    k = frame.intrinsics
    robot = np.zeros(frame.depth.shape, np.bool_)
    boxes = _image_boxes(volumes.extents, rotations, origins, frame)
    mark_volumes(
        frame.depth.copy(),
        (k.fx, k.fy, k.cx, k.cy),
        (normals, offsets, boxes),
        (MARGIN_M, MARGIN_SLOPE),
        robot,
    )
    return mask_robot(frame, robot)


def mask_points(
    frame: DepthFrame, is_masked: Callable[[NDArray[np.float64]], NDArray[np.bool_]]
) -> DepthFrame:
    """Return a frame without readings in given parts of the world.

    Parameters
    ----------
    frame
        The frame. Without `T_world_camera` the points are in the camera frame.
    is_masked
        Function from points (N, 3), m, to a mask (N,) of those to remove.

    Raises
    ------
    InputError
        If no reading is left.
    """
    measured = frame.depth > 0
    points = frame.points()[measured].astype(np.float64)
    if frame.T_world_camera is not None:
        points = frame.T_world_camera.apply(points)
    mask = np.zeros(measured.shape, np.bool_)
    mask[measured] = is_masked(points)
    return frame.without(mask)


def _image_boxes(
    extents: NDArray[np.float64],
    rotations: NDArray[np.float64],
    origins: NDArray[np.float64],
    frame: DepthFrame,
) -> NDArray[np.int64]:
    """Return the first and last row and column (N, 4) in which each volume can appear.

    The margin is included. A volume that reaches the plane of the lens can appear everywhere.
    """
    k = frame.intrinsics
    # The margin grows with depth; that of the farthest reading bounds it.
    margin = MARGIN_M + MARGIN_SLOPE * float(frame.depth.max())
    low, high = -extents[:, AXES[0::2]] - margin, extents[:, AXES[1::2]] + margin
    corners = np.stack(
        [np.where(np.array(upper), high, low) for upper in product((False, True), repeat=3)], axis=1
    )
    corners = corners @ np.swapaxes(rotations, 1, 2) + origins[:, None]
    whole = corners[..., 2].min(axis=1) <= 1e-3
    pixels = k.project(corners)
    last = np.array([k.width, k.height], np.float64)
    first_pixel = np.clip(np.floor(pixels.min(axis=1)), 0, last)
    end_pixel = np.clip(np.ceil(pixels.max(axis=1)) + 1, 0, last)
    first_pixel[whole], end_pixel[whole] = 0.0, last
    return np.column_stack(
        [first_pixel[:, 1], end_pixel[:, 1], first_pixel[:, 0], end_pixel[:, 0]]
    ).astype(np.int64)


@njit(cache=True, nogil=True)
def mark_volumes(depth, pinhole, volumes, margins, robot):
    """Mark the readings of a depth image (H, W), m, in grown convex volumes.

    Parameters
    ----------
    depth
        (H, W) float32, m; 0 = no reading.
    pinhole
        fx, fy, cx, cy, px.
    volumes
        Normals (N, K, 3) and offsets (N, K) of their planes, camera frame: n·x <= offset inside;
        and the first and end row and column of each in the image, (N, 4).
    margins
        Growth of the volumes: m, and m per m of depth.
    robot
        Mask (H, W) to which the readings are added.
    """
    fx, fy, cx, cy = pinhole
    normals, offsets, boxes = volumes
    for g in range(len(offsets)):
        for v in range(boxes[g, 0], boxes[g, 1]):
            for u in range(boxes[g, 2], boxes[g, 3]):
                z = np.float64(depth[v, u])
                if z <= 0 or robot[v, u]:
                    continue
                x, y = (u - cx) / fx * z, (v - cy) / fy * z
                grown = margins[0] + margins[1] * z
                inside = True
                for i in range(offsets.shape[1]):
                    n = normals[g, i]
                    if n[0] * x + n[1] * y + n[2] * z > offsets[g, i] + grown:
                        inside = False
                        break
                if inside:
                    robot[v, u] = True
