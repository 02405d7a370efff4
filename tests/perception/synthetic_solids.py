"""Exact depth frames of boxes, balls, bowls and horizontal plates, with their labels.

Positions are in the table frame: x right, y away from the camera, z up. The camera is
`CAMERA_HEIGHT` m above (0, 0). It looks forward and 37 degrees down.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.segmentation.working_image import WorkingImage, working_image

CAMERA = CameraIntrinsics(260.0, 260.0, 159.5, 119.5, 320, 240)
CAMERA_HEIGHT = 0.6
"""Height of the camera above the table, m."""
EXACT_NOISE = 1e-3
"""Disparity noise σ that the stages assume for exact frames, 1/m."""
MAX_DEPTH = 5.0
"""Maximum depth of a reading, m."""
TABLE_AXES = np.array([[1.0, 0.0, 0.0], [0.0, -0.6, 0.8], [0.0, -0.8, -0.6]])
"""Axes of the table frame as rows, in the camera frame."""
T_TABLE_CAMERA = RigidTransform.from_components(
    [0.0, 0.0, CAMERA_HEIGHT], Rotation.from_matrix(TABLE_AXES)
)
"""Pose of the camera in the table frame."""


class Solid(Protocol):
    """A surface that rays can hit."""

    def intersect(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the factors (H, W) that scale rays (H, W, 3) to the surface; inf = no hit."""
        ...


class Plate(NamedTuple):
    """A horizontal rectangle without thickness: a table top, a shelf or the floor."""

    x: tuple[float, float] = (-np.inf, np.inf)
    y: tuple[float, float] = (-np.inf, np.inf)
    z: float = 0.0

    def intersect(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Intersect rays with the rectangle."""
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.z - CAMERA_HEIGHT) / rays[..., 2]
            x, y = t * rays[..., 0], t * rays[..., 1]
        inside = (x > self.x[0]) & (x < self.x[1]) & (y > self.y[0]) & (y < self.y[1])
        return np.where(inside & (t > 0), t, np.inf)


class Box(NamedTuple):
    """A box at (x, y), rotated by `yaw` rad about z, with its bottom at height `base`, m."""

    x: float
    y: float
    size: tuple[float, float, float]
    base: float = 0.0
    yaw: float = 0.0

    def intersect(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Intersect rays with the box: a ray enters through the last of three near faces."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        rotation = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        half = np.array(self.size) / 2
        origin = rotation @ (
            np.array([0.0, 0.0, CAMERA_HEIGHT]) - [self.x, self.y, self.base + half[2]]
        )
        with np.errstate(divide="ignore"):
            walls = (np.array([[-half], [half]]).reshape(2, 1, 1, 3) - origin) / (rays @ rotation.T)
        enter, leave = walls.min(axis=0).max(axis=-1), walls.max(axis=0).min(axis=-1)
        return np.where((enter < leave) & (enter > 0), enter, np.inf)


class Ball(NamedTuple):
    """A ball with its centre at (x, y, z)."""

    x: float
    y: float
    z: float
    radius: float

    def intersect(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Intersect rays with the front of the ball."""
        return intersect_sphere(self, rays)[0]


class Bowl(NamedTuple):
    """The outer side of a bowl: a hollow ball cut off at height `rim`, m."""

    x: float
    y: float
    z: float
    radius: float
    rim: float

    def intersect(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Intersect rays with the front of the ball below the rim."""
        return self.below_rim(intersect_sphere(self, rays)[0], rays)

    def inside(self) -> BowlInside:
        """Return the inner side of the bowl, a separate surface."""
        return BowlInside(self)

    def below_rim(self, t: NDArray[np.float64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Replace hits above the rim by inf."""
        height = np.where(np.isfinite(t), t, 0.0) * rays[..., 2] + CAMERA_HEIGHT
        return np.where(height < self.rim, t, np.inf)


class BowlInside(NamedTuple):
    """The inner side of a bowl."""

    bowl: Bowl

    def intersect(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Intersect rays with the back of the ball below the rim."""
        return self.bowl.below_rim(intersect_sphere(self.bowl, rays)[1], rays)


def exact_image(frame: DepthFrame) -> WorkingImage:
    """Return the working image of an exact frame, unfiltered, with the noise set."""
    return working_image(frame)._replace(noise=EXACT_NOISE)


def heights(frame: DepthFrame) -> NDArray[np.float64]:
    """Return the heights (H, W) of a frame's readings above the table, m."""
    return frame.points() @ TABLE_AXES[2] + CAMERA_HEIGHT


def intersect_sphere(ball: Ball | Bowl, rays: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the ray factors (H, W) at which rays enter and leave a sphere; inf = no hit."""
    centre = np.array([ball.x, ball.y, ball.z - CAMERA_HEIGHT])
    square = (rays**2).sum(axis=-1)
    middle = rays @ centre
    discriminant = middle**2 - square * (centre @ centre - ball.radius**2)
    half_chord = np.sqrt(np.maximum(discriminant, 0.0))
    return [
        np.where(discriminant > 0, (middle + sign * half_chord) / square, np.inf)
        for sign in (-1, 1)
    ]


def solid_frame(
    solids: Sequence[Solid],
    plates: tuple[Plate, ...] = (Plate(),),
    camera: CameraIntrinsics = CAMERA,
    known_pose: bool = False,
) -> tuple[DepthFrame, NDArray[np.int32]]:
    """Return the frame and the labels (0 = plates, k = k-th solid).

    The frame has the camera pose when `known_pose` is true.
    """
    rays = camera.rays() @ TABLE_AXES.T
    depth = np.full(rays.shape[:2], MAX_DEPTH)
    labels = np.zeros(depth.shape, np.int32)
    for plate in plates:
        depth = np.minimum(depth, plate.intersect(rays))
    for label, solid in enumerate(solids, start=1):
        hit = solid.intersect(rays)
        labels[hit < depth] = label
        depth = np.minimum(depth, hit)
    depth = np.where(depth < MAX_DEPTH, depth, 0.0).astype(np.float32)
    return DepthFrame(depth, camera, T_TABLE_CAMERA if known_pose else None), labels
