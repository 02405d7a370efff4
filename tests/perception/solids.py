"""Boxes, balls, bowls and level plates before a camera, ray cast: exact frames, exact labels.

Places are in table coordinates: x right, y away from the camera, z up, the camera above (0, 0)
at `EYE` m, looking forward and down by 37 degrees.
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
EYE = 0.6
"""Height of the camera over the table, m."""
EXACT_NOISE = 1e-3
"""Noise σ of disparity that the stages assume for exact frames, 1/m."""
FAR = 5.0
"""Readings end here, m of depth."""
TABLE_AXES = np.array([[1.0, 0.0, 0.0], [0.0, -0.6, 0.8], [0.0, -0.8, -0.6]])
"""The table's axes as rows, in the camera's frame."""
T_TABLE_CAMERA = RigidTransform.from_components([0.0, 0.0, EYE], Rotation.from_matrix(TABLE_AXES))
"""Maps camera coordinates to table coordinates."""


class Solid(Protocol):
    """What a ray can meet."""

    def hit(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Multiples (H, W) of rays (H, W, 3) from the eye at which they meet it; inf = never."""
        ...


class Plate(NamedTuple):
    """A level rectangle without thickness: a table's top, a shelf, the floor."""

    x: tuple[float, float] = (-np.inf, np.inf)
    y: tuple[float, float] = (-np.inf, np.inf)
    z: float = 0.0

    def hit(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Meet the level z where that lies inside the rectangle."""
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.z - EYE) / rays[..., 2]
            x, y = t * rays[..., 0], t * rays[..., 1]
        inside = (x > self.x[0]) & (x < self.x[1]) & (y > self.y[0]) & (y < self.y[1])
        return np.where(inside & (t > 0), t, np.inf)


class Box(NamedTuple):
    """A box that stands at (x, y), turned by `yaw` rad about z, its bottom at `base` m."""

    x: float
    y: float
    size: tuple[float, float, float]
    base: float = 0.0
    yaw: float = 0.0

    def hit(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Enter through the last of the three near walls."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        half = np.array(self.size) / 2
        eye = turn @ (np.array([0.0, 0.0, EYE]) - [self.x, self.y, self.base + half[2]])
        with np.errstate(divide="ignore"):
            walls = (np.array([[-half], [half]]).reshape(2, 1, 1, 3) - eye) / (rays @ turn.T)
        enter, leave = walls.min(axis=0).max(axis=-1), walls.max(axis=0).min(axis=-1)
        return np.where((enter < leave) & (enter > 0), enter, np.inf)


class Ball(NamedTuple):
    """A ball with its centre at (x, y, z)."""

    x: float
    y: float
    z: float
    radius: float

    def hit(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Enter the sphere."""
        return sphere(self, rays)[0]


class Bowl(NamedTuple):
    """The part of a thin hollow ball below the height `rim`: its outer side."""

    x: float
    y: float
    z: float
    radius: float
    rim: float

    def hit(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Enter the sphere below the rim."""
        return self.below_rim(sphere(self, rays)[0], rays)

    def inside(self) -> BowlInside:
        """Give its inner side, which is another surface of the same thing."""
        return BowlInside(self)

    def below_rim(self, t: NDArray[np.float64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Keep the hits below the rim, inf elsewhere."""
        at = np.where(np.isfinite(t), t, 0.0) * rays[..., 2] + EYE
        return np.where(at < self.rim, t, np.inf)


class BowlInside(NamedTuple):
    """The inner side of a bowl."""

    bowl: Bowl

    def hit(self, rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Leave the sphere below the rim."""
        return self.bowl.below_rim(sphere(self.bowl, rays)[1], rays)


def exact_image(frame: DepthFrame) -> WorkingImage:
    """Return a frame as the image that the stages work on, without a filter, and its noise."""
    return working_image(frame)._replace(noise=EXACT_NOISE)


def heights(frame: DepthFrame) -> NDArray[np.float64]:
    """Heights (H, W) of a frame's readings over the table, m."""
    return frame.points() @ TABLE_AXES[2] + EYE


def sphere(ball: Ball | Bowl, rays: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Where rays enter and leave a sphere, inf = never."""
    centre = np.array([ball.x, ball.y, ball.z - EYE])
    square = (rays**2).sum(axis=-1)
    along = rays @ centre
    root = along**2 - square * (centre @ centre - ball.radius**2)
    way = np.sqrt(np.maximum(root, 0.0))
    return [np.where(root > 0, (along + sign * way) / square, np.inf) for sign in (-1, 1)]


def solid_frame(
    solids: Sequence[Solid],
    plates: tuple[Plate, ...] = (Plate(),),
    camera: CameraIntrinsics = CAMERA,
    known_place: bool = False,
) -> tuple[DepthFrame, NDArray[np.int32]]:
    """Frame and labels (0 = plates, k = k-th solid); with the camera's place where it is known."""
    rays = camera.rays() @ TABLE_AXES.T
    depth = np.full(rays.shape[:2], FAR)
    labels = np.zeros(depth.shape, np.int32)
    for plate in plates:
        depth = np.minimum(depth, plate.hit(rays))
    for number, solid in enumerate(solids, start=1):
        hit = solid.hit(rays)
        labels[hit < depth] = number
        depth = np.minimum(depth, hit)
    depth = np.where(depth < FAR, depth, 0.0).astype(np.float32)
    return DepthFrame(depth, camera, T_TABLE_CAMERA if known_place else None), labels
