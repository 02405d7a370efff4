"""Noise of a structured-light depth camera, added to a noise-free depth image."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import CameraIntrinsics


AXIAL_BASE_M = 0.0012
AXIAL_GROWTH_PER_M = 0.0019
AXIAL_START_M = 0.4
"""Nguyen, Izadi and Lovell 2012, eq (2), fitted to Kinect: σ_z = base + growth (z - start)²."""

MIN_EDGE_STEP = 0.02
"""Neighbours lie on two surfaces if their depths differ by more than this share of the smaller."""

_MIN_NEAR_STEP = 0.05
"""The same share within two pixels on either side. Steep surfaces have smaller steps."""


@dataclass(frozen=True)
class DepthNoise:
    """Strength of each error; 0 switches it off.

    Sources: axial noise by Nguyen, Izadi and Lovell, "Modeling Kinect Sensor Noise for Improved
    3D Reconstruction and Tracking", 3DIMPVT 2012; lateral jitter and disparity steps by Barron
    and Malik, "Intrinsic Scene Properties from a Single RGB-D Image", CVPR 2013, as adopted by
    Handa, Whelan, McDonald and Davison, "A Benchmark for RGB-D Visual Odometry, 3D Reconstruction
    and SLAM", ICRA 2014. Dropouts and flying pixels at edges were chosen by eye, not fitted.

    Raises
    ------
    InputError
        If a value is negative, a share is above 1, or an angle lies outside [0, π/2).
    """

    axial: float = 0.0
    """Standard deviation along the optical axis, in units of Nguyen's σ_z."""
    lateral: float = 0.0
    """Standard deviation of the image position that a pixel reads, px: makes outlines ragged."""
    correlation: float = 0.0
    """Standard deviation of the kernel that correlates axial and lateral noise, px. At 0 the pixels
    are independent, and smoothing removes the noise too easily."""
    disparity_step: float = 0.0
    """Disparity is rounded to multiples of this, px: Kinect's is 1/8."""
    baseline: float = 0.075
    """Distance between projector and camera, m. A disparity step causes the depth step
    z² step / (f baseline)."""
    edge_dropout: float = 0.0
    """Probability that a pixel on either side of a depth step has no reading."""
    flying: float = 0.0
    """Probability that a pixel on either side of a depth step reads a depth between the two."""
    grazing_dropout: float = 0.0
    """Probability that a surface at the angle `grazing_end` has no reading; it rises from 0 at
    `grazing_start`."""
    grazing_start: float = 1.31
    """Angle between line of sight and surface normal where readings begin to fail, rad."""
    grazing_end: float = 1.52
    """Angle where `grazing_dropout` is reached, rad."""
    hole_share: float = 0.0
    """Share of the image without reading, in random holes."""
    hole_size: float = 5.0
    """Correlation length of the holes, px."""

    def __post_init__(self) -> None:
        for name in ("axial", "lateral", "correlation", "disparity_step"):
            value = getattr(self, name)
            if not 0 <= value < np.inf:
                raise InputError(f"{name} must be >= 0 and finite, got {value}")
        for name in ("edge_dropout", "flying", "grazing_dropout", "hole_share"):
            value = getattr(self, name)
            if not 0 <= value <= 1:
                raise InputError(f"{name} is a share and must lie in [0, 1], got {value}")
        for name in ("baseline", "hole_size"):
            value = getattr(self, name)
            if not 0 < value < np.inf:
                raise InputError(f"{name} must be > 0 and finite, got {value}")
        if not 0 <= self.grazing_start < self.grazing_end < np.pi / 2:
            raise InputError(
                "grazing_start and grazing_end must rise within [0, π/2) rad, got "
                f"{self.grazing_start} and {self.grazing_end}"
            )

    @classmethod
    def none(cls) -> DepthNoise:
        """Return no noise at all."""
        return cls()

    @classmethod
    def realistic(cls, scale: float = 1.0) -> DepthNoise:
        """Return the errors of the first Kinect, times `scale`."""
        return cls(
            axial=1.0,
            lateral=0.5,
            correlation=0.8,
            disparity_step=0.125,
            edge_dropout=0.25,
            flying=0.1,
            grazing_dropout=0.9,
            hole_share=0.003,
        ).scaled(scale)

    def scaled(self, scale: float) -> DepthNoise:
        """Return all strengths times `scale` >= 0, with shares limited to 1."""
        if not 0 <= scale < np.inf:
            raise InputError(f"the noise scale must be >= 0 and finite, got {scale}")
        lengths = ("axial", "lateral", "disparity_step")
        shares = ("edge_dropout", "flying", "grazing_dropout", "hole_share")
        strengths = {name: scale * getattr(self, name) for name in lengths}
        strengths |= {name: min(scale * getattr(self, name), 1.0) for name in shares}
        return replace(self, **strengths)


def axial_sigma(z: NDArray[np.floating]) -> NDArray[np.floating]:
    """Compute Nguyen's standard deviation of depths z (…,), both in m."""
    return AXIAL_BASE_M + AXIAL_GROWTH_PER_M * (z - AXIAL_START_M) ** 2


def add_depth_noise(
    depth: NDArray[np.floating],
    intrinsics: CameraIntrinsics,
    rng: np.random.Generator,
    options: DepthNoise | None = None,
) -> NDArray[np.float32]:
    """Add noise to a depth image.

    Parameters
    ----------
    depth
        Noise-free depth, (H, W), m; 0 = no reading.
    intrinsics
        The camera.
    rng
        Source of randomness.
    options
        Strength of each error; `DepthNoise.realistic` when not given.

    Returns
    -------
    NDArray
        (H, W) float32, m; 0 = no reading. Pixels without a reading never gain one, except next to
        a pixel with one, by lateral jitter.

    Raises
    ------
    InputError
        If depth is not an image of the camera's size.
    """
    noise = DepthNoise.realistic() if options is None else options
    clean = np.ascontiguousarray(depth, dtype=np.float32)
    if clean.shape != (intrinsics.height, intrinsics.width):
        raise InputError(
            f"depth must be (H, W) = {(intrinsics.height, intrinsics.width)}, got {clean.shape}"
        )
    z = clean.copy()
    if noise.lateral > 0:
        z = _jittered(z, noise, rng)
    if noise.flying > 0 or noise.edge_dropout > 0:
        z = _disturbed_edges(z, noise, rng)
    if noise.axial > 0:
        field = blurred(rng.standard_normal(z.shape, dtype=np.float32), noise.correlation)
        shifted = np.maximum(z + noise.axial * axial_sigma(z) * field, 0)
        z = np.where(z > 0, shifted, np.float32(0))
    if noise.disparity_step > 0:
        z = quantised(z, intrinsics.fx * noise.baseline, noise.disparity_step)
    if noise.grazing_dropout > 0:
        chance = grazing_chance(
            clean, intrinsics, noise.grazing_dropout, noise.grazing_start, noise.grazing_end
        )
        z[rng.random(z.shape, np.float32) < chance] = 0
    if noise.hole_share > 0:
        z[_holes(z.shape, noise, rng)] = 0
    return z.astype(np.float32, copy=False)


def blurred(field: NDArray[np.float32], correlation: float) -> NDArray[np.float32]:
    """Blur white noise and keep its variance."""
    if correlation <= 0:
        return field
    size = 2 * int(np.ceil(3 * correlation)) + 1
    kernel = cv2.getGaussianKernel(size, correlation, cv2.CV_32F)
    # Blurring scales the variance by the sum of the squared weights, here back to 1.
    kernel = kernel / np.linalg.norm(kernel)
    return np.asarray(cv2.sepFilter2D(field, cv2.CV_32F, kernel, kernel), np.float32)


def _jittered(
    z: NDArray[np.float32], noise: DepthNoise, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Read each pixel at a random position beside it.

    Depths are interpolated on a surface. At a step between two surfaces, the depth is that of one.
    """
    height, width = z.shape
    # A normal step in the plane has a random direction and a Rayleigh length (Box and Muller
    # 1958), which is cheaper than two normal draws.
    length = np.sqrt(-2.0 * np.asarray(cv2.log(1.0 - rng.random(z.shape, np.float32))))
    along_u, along_v = cv2.polarToCart(length, 2 * np.pi * rng.random(z.shape, np.float32))
    u = noise.lateral * blurred(np.asarray(along_u, np.float32), noise.correlation)
    v = noise.lateral * blurred(np.asarray(along_v, np.float32), noise.correlation)
    u += np.arange(width, dtype=np.float32)
    v += np.arange(height, dtype=np.float32)[:, None]
    border = cv2.BORDER_REPLICATE
    nearest = np.asarray(cv2.remap(z, u, v, cv2.INTER_NEAREST, borderMode=border), np.float32)
    between = np.asarray(cv2.remap(z, u, v, cv2.INTER_LINEAR, borderMode=border), np.float32)
    # Interpolation next to a step would give depths that are on neither side.
    around = np.ones((5, 5), np.uint8)
    far = np.asarray(cv2.dilate(z, around), np.float32)
    stepped = far - np.asarray(cv2.erode(z, around)) > _MIN_NEAR_STEP * far
    stepped |= np.abs(between - nearest) > MIN_EDGE_STEP * nearest
    return np.where(stepped, nearest, between)


def _disturbed_edges(
    z: NDArray[np.float32], noise: DepthNoise, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Remove pixels, or mix them with a neighbour on another surface."""
    kernel = np.ones((3, 3), np.uint8)
    far = np.asarray(cv2.dilate(z, kernel))
    near = np.asarray(cv2.erode(np.where(z > 0, z, np.float32(np.inf)), kernel))
    edge = (z > 0) & (far - near > MIN_EDGE_STEP * near)
    rows, columns = np.nonzero(edge)
    chance = rng.random(len(rows), np.float32)
    share = rng.random(len(rows), np.float32)
    low, high = near[rows, columns], far[rows, columns]
    disturbed = np.where(chance < noise.flying, low + share * (high - low), z[rows, columns])
    # The upper end of the same draw, so that the two chances add up.
    disturbed[chance > 1 - noise.edge_dropout] = 0
    z[rows, columns] = disturbed
    return z


def quantised(z: NDArray[np.float32], focal_baseline: float, step: float) -> NDArray[np.float32]:
    """Round disparity f b / z to multiples of `step`; a disparity of 0 is out of range."""
    unit = np.float32(focal_baseline / step)
    level = np.rint(np.divide(unit, z, out=np.zeros_like(z), where=z > 0))
    return np.divide(unit, level, out=np.zeros_like(z), where=level > 0)


def grazing_chance(
    z: NDArray[np.float32], intrinsics: CameraIntrinsics, most: float, first: float, last: float
) -> NDArray[np.float32]:
    """Compute the probability that a pixel is lost at a grazing angle, (H, W).

    It rises from 0 at the angle `first` to `most` at the angle `last`, rad, between line of sight
    and surface normal.
    """
    k = intrinsics
    x = ((np.arange(k.width) - k.cx) / k.fx).astype(np.float32)
    y = ((np.arange(k.height) - k.cy) / k.fy).astype(np.float32)[:, None]
    along_u = k.fx * _slope(z, 1)
    along_v = k.fy * _slope(z, 0)
    # For z(u, v) the normal is (-fx z_u, -fy z_v, z + u' fx z_u + v' fy z_v), its product with
    # the ray (u', v', 1) is z.
    third = z + x * along_u + y * along_v
    normal = along_u * along_u + along_v * along_v + third * third
    cosine = z / np.sqrt(np.maximum(normal * (1 + x * x + y * y), 1e-12))
    # Python floats leave the arrays in single precision.
    start, end = float(np.cos(first)), float(np.cos(last))
    ramp = np.clip((start - cosine) * (1 / (start - end)), 0, 1)
    return (most * ramp).astype(np.float32, copy=False)


def _slope(z: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Compute the depth change per pixel along an axis: the smaller one-sided difference, m/px.

    The smaller difference is not affected by a step on one side of the pixel.
    """
    if axis == 0:
        return _slope(z.T, 1).T
    slope = np.zeros_like(z)
    if z.shape[1] > 1:
        step = z[:, 1:] - z[:, :-1]
        size = np.abs(step)
        slope[:, :1], slope[:, -1:] = step[:, :1], step[:, -1:]
        slope[:, 1:-1] = np.where(size[:, :-1] < size[:, 1:], step[:, :-1], step[:, 1:])
    return slope


def _holes(
    shape: tuple[int, ...], noise: DepthNoise, rng: np.random.Generator
) -> NDArray[np.bool_]:
    """Draw holes where a smooth random field is highest."""
    if noise.hole_share >= 1:
        return np.ones(shape, dtype=bool)
    height, width = shape
    coarse = (int(height / noise.hole_size) + 2, int(width / noise.hole_size) + 2)
    grid = rng.standard_normal(coarse, dtype=np.float32)
    field = np.asarray(cv2.resize(grid, (width, height), interpolation=cv2.INTER_CUBIC))
    # A third of the rows and columns gives the quantile accurately enough, in a ninth of the time.
    return field > np.quantile(field[::3, ::3], 1 - noise.hole_share)


SHAPE, SCALE = 1000.0, 0.001
"""Parameters of the gamma distribution of the factor of the whole image: mean 1, σ 3.2 %."""
BLOTCH_SIGMA = 0.005
"""Standard deviation of the blotches, m."""
BLOTCH_PX = 4
"""Distance between two independent values of the blotches, px."""
BLOTCH_SHARE = 0.5
"""Share of the frames with blotches."""


def add_dex_noise(depth: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Multiply a depth image by one random factor and, in half the frames, add smooth blotches.

    The noise of Dex-Net 2.0 (Mahler et al. 2017) with the parameters of GIGA's code.

    Parameters
    ----------
    depth
        Depth (H, W), m; 0 = no reading.
    rng
        Source of randomness.

    Returns
    -------
    NDArray
        Depth (H, W) float32, m. Pixels without a reading stay 0.
    """
    rows, columns = depth.shape
    noisy = depth * np.float32(rng.gamma(SHAPE, SCALE))
    if rng.random() < BLOTCH_SHARE:
        coarse = rng.standard_normal((rows // BLOTCH_PX, columns // BLOTCH_PX)) * BLOTCH_SIGMA
        noisy = noisy + cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_LINEAR)
    return np.where(depth > 0, np.maximum(noisy, 1e-3), 0.0).astype(np.float32)
