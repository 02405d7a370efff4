"""A depth image with the camera that took it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_PLAUSIBLE_DEPTH_M = 100.0
"""Depth cameras measure no farther. A larger median means millimetres given as metres."""

MIN_READING_M, MAX_READING_M = 1e-4, 1e4
"""Readings outside this range come from a failed conversion, not from a camera."""

MAX_PIXELS = 1 << 23
"""Maximum size of an image, px. Depth cameras have up to 5 megapixels. Larger images would need
more than 1 GB of memory."""

MIN_FOCAL_PX, MAX_FOCAL_PX = 0.01, 1e6
"""Range of focal lengths, px. The lower one leaves room for images reduced a hundred times. Beyond
the upper one an image of any size is a single ray."""

MAX_PRINCIPAL_PX = 1e6
"""Maximum distance of the principal point from the first pixel, px. Beyond it
all viewing rays are nearly parallel."""


@dataclass(frozen=True)
class CameraIntrinsics:
    """Pinhole camera: pixel ``(u, v) = (fx x/z + cx, fy y/z + cy)``, no distortion.

    Pixel centres lie at whole numbers: the first pixel's centre is (0, 0).

    Raises
    ------
    InputError
        If a value is not finite, or a focal length, the principal point or the size is out of the
        range of any camera.
    """

    fx: float
    """Focal length along the image's width, px."""
    fy: float
    """Focal length along the image's height, px."""
    cx: float
    """Principal point, px from the first column's centre."""
    cy: float
    """Principal point, px from the first row's centre."""
    width: int
    """Columns of the image, px."""
    height: int
    """Rows of the image, px."""

    def __post_init__(self) -> None:
        values = (self.fx, self.fy, self.cx, self.cy)
        if not all(np.isfinite(values)):
            raise InputError(f"camera intrinsics must be finite, got fx, fy, cx, cy = {values}")
        for name in ("fx", "fy"):
            focal = getattr(self, name)
            if not MIN_FOCAL_PX <= focal <= MAX_FOCAL_PX:
                bounds = f"{MIN_FOCAL_PX:g} to {MAX_FOCAL_PX:g} px"
                raise InputError(f"focal lengths must be {bounds}, got {name}={focal:g}")
        if max(abs(self.cx), abs(self.cy)) > MAX_PRINCIPAL_PX:
            raise InputError(
                f"the principal point must lie within {MAX_PRINCIPAL_PX:g} px, "
                f"got cx={self.cx:g}, cy={self.cy:g}"
            )
        check_image_size(self.width, self.height)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """Camera matrix K, (3, 3) float64, row-major."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def reduced(self, stride: int) -> CameraIntrinsics:
        """Return the camera of the image's every `stride`-th row and column."""
        return CameraIntrinsics(
            self.fx / stride,
            self.fy / stride,
            self.cx / stride,
            self.cy / stride,
            -(-self.width // stride),
            -(-self.height // stride),
        )

    def cropped(self, rows: slice, columns: slice) -> CameraIntrinsics:
        """Return the camera of the image part ``[rows, columns]``."""
        (top, bottom, _), (left, right, _) = rows.indices(self.height), columns.indices(self.width)
        return CameraIntrinsics(
            self.fx, self.fy, self.cx - left, self.cy - top, right - left, bottom - top
        )

    def rays(self) -> NDArray[np.float64]:
        """Return the directions through every pixel with z = 1, camera frame, (H, W, 3) float64."""
        u = (np.arange(self.width) - self.cx) / self.fx
        v = (np.arange(self.height) - self.cy) / self.fy
        rays = np.empty((self.height, self.width, 3))
        rays[..., 0] = u
        rays[..., 1] = v[:, None]
        rays[..., 2] = 1.0
        return rays

    def project(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Project camera-frame points (…, 3), m, to pixels (…, 2). Points with z <= 0 give NaN."""
        points = np.asarray(points, dtype=np.float64)
        z = np.where(points[..., 2] > 0, points[..., 2], np.nan)
        u = self.fx * points[..., 0] / z + self.cx
        v = self.fy * points[..., 1] / z + self.cy
        return np.stack([u, v], axis=-1)


@dataclass(frozen=True)
class DepthFrame:
    """A depth image, its camera, and the camera's pose.

    Raises
    ------
    InputError
        If depth is not a 2-D float array of the camera's size, contains NaN, infinity or negative
        values, contains no reading, or is so large that it must be in millimetres. If colour has
        another size or type, T_world_camera another type, or the error of the scale is negative.
    """

    depth: NDArray[np.float32]
    """Distance along the optical axis, (H, W) float32, m; 0 = no reading."""
    intrinsics: CameraIntrinsics
    """The camera that took the image."""
    T_world_camera: RigidTransform | None = None
    """Maps camera coordinates to world coordinates. None if the camera's pose is unknown."""
    colour: NDArray[np.uint8] | None = None
    """Registered colour image, (H, W, 3) uint8 RGB, or None."""
    masked: NDArray[np.bool_] | None = None
    """Pixels whose readings were removed on purpose, (H, W) bool, or None: see `without`. Other
    pixels without a reading may show a transparent thing."""
    scale_error: float = math.inf
    """Standard deviation of the scale of the depth, a share of the distance. Infinity: unknown.
    :func:`eyehand.grasping.correct_depth` sets it."""

    def __post_init__(self) -> None:
        depth = np.asarray(self.depth)
        if depth.ndim != 2:
            raise InputError(f"depth must have shape (H, W), got {depth.shape}")
        if not np.issubdtype(depth.dtype, np.floating):
            raise InputError(f"depth must be floating point in metres, got dtype {depth.dtype}")
        pose = self.T_world_camera
        if pose is not None and not isinstance(pose, RigidTransform):
            raise InputError(
                "T_world_camera must be a RigidTransform, as from RigidTransform.from_matrix; got "
                f"{type(pose).__name__}"
            )
        expected = (self.intrinsics.height, self.intrinsics.width)
        if depth.shape != expected:
            raise InputError(
                f"depth is {depth.shape[1]}x{depth.shape[0]} px but the camera is "
                f"{expected[1]}x{expected[0]} px: give the intrinsics of this image size"
            )
        _check_depth_values(depth)
        object.__setattr__(self, "depth", _read_only(depth.astype(np.float32, copy=False)))
        if self.colour is not None:
            colour = np.asarray(self.colour)
            if colour.shape != (*expected, 3) or colour.dtype != np.uint8:
                raise InputError(
                    f"colour must be {(*expected, 3)} uint8 RGB, got {colour.shape} {colour.dtype}"
                )
            object.__setattr__(self, "colour", _read_only(colour))
        if not self.scale_error >= 0.0:
            raise InputError(f"scale_error must be at least 0, got {self.scale_error}")
        if self.masked is not None:
            masked = np.asarray(self.masked)
            if masked.shape != expected or masked.dtype != np.bool_:
                raise InputError(
                    f"masked must be {expected} bool, got {masked.shape} {masked.dtype}"
                )
            object.__setattr__(self, "masked", _read_only(masked))

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Mask of the pixels with a reading, (H, W) bool."""
        return self.depth > 0

    def without(self, mask: NDArray[np.bool_]) -> DepthFrame:
        """Return the frame without the readings of a mask (H, W), which `masked` then contains.

        Raises
        ------
        InputError
            If no reading is left, or the mask has another size.
        """
        if mask.shape != self.depth.shape:
            raise InputError(f"the mask must have shape {self.depth.shape}, got {mask.shape}")
        depth = np.where(mask, np.float32(0.0), self.depth)
        if not depth.any():
            raise InputError("the masks leave no reading of the frame")
        masked = mask if self.masked is None else mask | self.masked
        return replace(self, depth=depth, masked=masked)

    def points(self) -> NDArray[np.float32]:
        """Return the cloud in pixel order, camera frame, (H, W, 3) float32, m; 0 = no reading."""
        k = self.intrinsics
        u = ((np.arange(k.width) - k.cx) / k.fx).astype(np.float32)
        v = ((np.arange(k.height) - k.cy) / k.fy).astype(np.float32)
        points = np.empty((k.height, k.width, 3), dtype=np.float32)
        np.multiply(self.depth, u[None, :], out=points[..., 0])
        np.multiply(self.depth, v[:, None], out=points[..., 1])
        points[..., 2] = self.depth
        return points


def check_image_size(width: int, height: int) -> None:
    """Raise an :class:`InputError` if an image has no pixels, or more than ``MAX_PIXELS``."""
    if width < 1 or height < 1:
        raise InputError(f"image size must be >= 1 px, got {width}x{height}")
    if width * height > MAX_PIXELS:
        raise InputError(
            f"the image is {width}x{height} px, expected at most {MAX_PIXELS / 1e6:.1f} megapixels"
        )


def _check_depth_values(depth: NDArray[np.floating]) -> None:
    bad = int(np.count_nonzero(~np.isfinite(depth)))
    if bad:
        raise InputError(
            f"depth holds {bad} NaN or infinite pixels: write 0 where there is no reading"
        )
    lowest = float(depth.min())
    if lowest < 0:
        raise InputError(f"depth holds negative values (lowest {lowest:.4g} m): must be >= 0")
    readings = depth[depth > 0]
    if readings.size == 0:
        raise InputError("depth is 0 everywhere: the frame holds no reading")
    nearest, farthest = float(readings.min()), float(readings.max())
    # The median of a whole image takes longer than all other checks.
    median = float(np.median(readings)) if farthest > MAX_PLAUSIBLE_DEPTH_M else farthest
    if median > MAX_PLAUSIBLE_DEPTH_M:
        raise InputError(
            f"median depth is {median:.0f} m: it looks like millimetres given as metres, "
            "multiply by 0.001 (centimetres by 0.01)"
        )
    if nearest < MIN_READING_M or farthest > MAX_READING_M:
        raise InputError(
            f"depth holds readings from {nearest:.3g} to {farthest:.3g} m: set what lies outside "
            f"[{MIN_READING_M}, {MAX_READING_M:.0f}] m to 0"
        )


def _read_only(array: NDArray) -> NDArray:
    view = array.view()
    view.setflags(write=False)
    return view
