"""Exact depth frames of a container with boxes in it, viewed steeply from above."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation
from synthetic_solids import CAMERA

from eyehand.perception import DepthFrame

ROOM_DEPTH = 3.0
"""Maximum depth of a reading, m."""


class Block(NamedTuple):
    """A box with its centre at `at`, rotated about its y axis by `pitch`, then about z by `yaw`."""

    at: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float = 0.0
    pitch: float = 0.0


class Tub(NamedTuple):
    """A container with its inner floor at z = 0, centred at the origin."""

    length: float = 0.4
    width: float = 0.3
    height: float = 0.1
    thickness: float = 0.01
    base: float = 0.004
    yaw: float = 0.2

    def blocks(self) -> list[Block]:
        """Return the floor and the walls; wall k is the first corner's side."""
        rotation = Rotation.from_euler("z", self.yaw)
        tall, long, wide = self.height + self.base, self.length, self.width
        parts = [((0.0, 0.0, -self.base / 2), (long, wide, self.base))]
        for sign in (-1, 1):
            middle = (self.height - self.base) / 2
            x, y = sign * (long + self.thickness) / 2, sign * (wide + self.thickness) / 2
            parts += [
                ((x, 0.0, middle), (self.thickness, wide + 2 * self.thickness, tall)),
                ((0.0, y, middle), (long + 2 * self.thickness, self.thickness, tall)),
            ]
        return [Block(tuple(rotation.apply(at)), size, self.yaw) for at, size in parts]


def camera_pose(elevation: float = 1.2, distance: float = 0.75) -> RigidTransform:
    """Return the pose of a camera that looks at the origin from `elevation` rad above -y."""
    back = np.array([0.0, -np.cos(elevation), np.sin(elevation)])
    right = np.array([1.0, 0.0, 0.0])
    axes = np.column_stack([right, np.cross(-back, right), -back])
    return RigidTransform.from_components(distance * back, Rotation.from_matrix(axes))


def tub_frame(
    tub: Tub | None,
    contents: list[Block] | None = None,
    table: float | None = None,
    elevation: float = 1.2,
) -> tuple[DepthFrame, NDArray[np.int32], RigidTransform]:
    """Return the frame, the labels (0 = background, k = k-th content) and T_world_camera.

    The table lies at height `table`, m, or else directly below the tub.
    """
    T_world_camera = camera_pose(elevation)
    rotation = T_world_camera.rotation.as_matrix()
    rays = CAMERA.rays() @ rotation.T
    eye = T_world_camera.translation
    base = tub.base if tub else 0.0
    depth = ((-base if table is None else table) - eye[2]) / rays[..., 2]
    labels = np.zeros(depth.shape, np.int32)
    blocks = [(0, block) for block in (tub.blocks() if tub else [])]
    blocks += list(enumerate(contents or [], start=1))
    for label, block in blocks:
        hit = _intersect(block, eye, rays)
        labels[hit < depth] = label
        depth = np.minimum(depth, hit)
    depth = np.where((depth > 0) & (depth < ROOM_DEPTH), depth, 0.0).astype(np.float32)
    return DepthFrame(depth, CAMERA), labels, T_world_camera


def _intersect(
    block: Block, eye: NDArray[np.float64], rays: NDArray[np.float64]
) -> NDArray[np.float64]:
    turned = Rotation.from_euler("ZY", [block.yaw, block.pitch]).inv().as_matrix()
    origin, half = turned @ (eye - np.array(block.at)), np.array(block.size) / 2
    with np.errstate(divide="ignore"):
        faces = (np.array([[-half], [half]]).reshape(2, 1, 1, 3) - origin) / (rays @ turned.T)
    enter, leave = faces.min(axis=0).max(axis=-1), faces.max(axis=0).min(axis=-1)
    return np.where((enter < leave) & (enter > 0), enter, np.inf)
