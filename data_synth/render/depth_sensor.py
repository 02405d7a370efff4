"""Models of depth cameras: what each kind of camera makes of a noise-free view.

All four find depth by triangulation over a baseline, either between two cameras or between a
projector and a camera. They share five errors, in this order:

- **Shadow**: the second camera or the projector does not see a surface, which gets no reading.
- **Window**: matching compares windows, so that outlines follow the window instead of the object.
  Across small steps, the disparity of both sides mixes.
- **Disparity noise**, correlated over the window, so that depth noise grows with z² / (f b).
- **Missing contrast**: surfaces that are nearly black return no pattern. A passive camera has no
  match on surfaces without texture.
- **Quantisation** of the disparity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics

from .depth_noise import MIN_EDGE_STEP, blurred, grazing_chance, quantised
from .rendered_view import RenderedView

SensorName = Literal["kinect-v1", "stereo", "structured-light", "oak"]

GRAZING = (1.31, 1.50)
"""Angles between line of sight and surface normal where readings begin to fail, and where none is
left, rad."""
MAX_RANGE_M = 6.0
"""Readings beyond this distance are dropped. Noise makes some of nearly no disparity."""
DARKEST_DROPOUT = 0.8
"""Probability that a pixel of a perfectly black surface has no reading."""
_SPECKLE_PX = 3.0
"""Correlation length of holes on dark or plain surfaces."""


@dataclass(frozen=True)
class DepthSensor:
    """Parameters of a triangulating depth camera. Lengths in px are those of the depth image."""

    baseline: float
    """Distance between the two cameras, or between camera and projector, m. The second device lies
    on the camera's +x side."""
    window: int
    """Width of the matching window, odd, px."""
    noise: float
    """Standard deviation of the disparity on textured surfaces, px."""
    step: float
    """Disparity is rounded to multiples of this, px."""
    mixing: float
    """Steps of disparity smaller than this are smoothed over the window, px."""
    edge_dropout: float
    """Probability that a pixel at a larger step has no reading."""
    dark: float
    """Brightness in [0, 1] below which readings begin to fail; at 0, `DARKEST_DROPOUT` fail."""
    two_cameras: bool = False
    """Whether the second device is a camera: it does not see the left edge of the image."""
    plain_share: float = 0.0
    """Share of surfaces that have too little texture for a passive camera; 0 with a projector."""
    plain_dropout: float = 0.35
    """Probability that a pixel of such a surface has no reading. The others have four times the
    noise."""


SENSORS: dict[SensorName, DepthSensor] = {
    "kinect-v1": DepthSensor(
        baseline=0.075, window=9, noise=0.10, step=0.125, mixing=0.5, edge_dropout=0.35, dark=0.12
    ),
    "stereo": DepthSensor(
        baseline=0.050,
        window=9,
        noise=0.08,
        step=1 / 32,
        mixing=2.0,
        edge_dropout=0.05,
        dark=0.16,
        two_cameras=True,
    ),
    "structured-light": DepthSensor(
        baseline=0.250, window=1, noise=0.04, step=1e-3, mixing=0.0, edge_dropout=0.3, dark=0.10
    ),
    "oak": DepthSensor(
        baseline=0.075,
        window=13,
        noise=0.15,
        step=0.125,
        mixing=1.5,
        edge_dropout=0.1,
        dark=0.08,
        two_cameras=True,
        plain_share=0.35,
    ),
}
"""Parameters by name.

``kinect-v1``: projector at 75 mm, windows of 9 by 9 or 9 by 7 px, disparity in 1/8 px (Konolige
and Mihelich, "Technical description of Kinect calibration", ROS wiki). The axial noise at 1 m is
that of Nguyen, Izadi and Lovell 2012; see `depth_noise`.

``stereo``: two cameras at 50 mm with a pattern projector, as the RealSense D435. Disparity has five
fractional bits (Keselman, Woodfill, Grunnet-Jepsen and Bhowmik, "Intel RealSense Stereoscopic Depth
Cameras", CVPR workshops 2017). Its noise is 0.08 px on textured walls (Grunnet-Jepsen, Sweetser and
Woodfill, "Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras for Best Performance").

``structured-light``: fringes from a projector at 250 mm, decoded in each pixel, so without a
window. Noise and baseline are chosen to match an industrial scanner, see below.

``oak``: two passive cameras at 75 mm, three fractional bits, census windows with cost aggregation
and a median filter over 7 px (Luxonis, documentation of the node StereoDepth). The shares of
surfaces without texture were chosen by eye.

Standard deviation from local planes (11 by 11 px, the smoothest fifth of the windows), scaled to
1 m by z²: 1.1, 1.1, 0.23 and 1.1 mm in this order. Real frames have 0.8 mm (Xtion, of the first
Kinect's kind), 0.6 to 1.4 mm (RealSense) and 0.25 mm (PhoXi, without the rounding to mm).
"""


def sense_depth(
    view: RenderedView,
    intrinsics: CameraIntrinsics,
    rng: np.random.Generator,
    sensor: DepthSensor,
) -> NDArray[np.float32]:
    """Return what a sensor measures of a noise-free view.

    Parameters
    ----------
    view
        The view; without colours, nothing is too dark.
    intrinsics
        The camera.
    rng
        Source of randomness.
    sensor
        The sensor.

    Returns
    -------
    NDArray
        Depth (H, W) float32, m; 0 = no reading.
    """
    focal_baseline = float(intrinsics.fx * sensor.baseline)
    z = np.ascontiguousarray(view.depth, dtype=np.float32)
    disparity = np.divide(focal_baseline, z, out=np.zeros_like(z), where=z > 0)
    lost = shadow(disparity)
    if sensor.two_cameras:
        lost |= np.arange(intrinsics.width) < disparity
    measured, edge = matched_disparity(disparity, sensor.window, sensor.mixing, rng)
    lost |= edge & (rng.random(z.shape, np.float32) < sensor.edge_dropout)
    plain = _plain_surfaces(view, sensor.plain_share, rng)
    field = blurred(rng.standard_normal(z.shape, dtype=np.float32), sensor.window / 4)
    measured = measured + sensor.noise * np.where(plain, 4.0, 1.0).astype(np.float32) * field
    lost |= _speckles(z.shape, rng) < np.where(plain, sensor.plain_dropout, 0.0)
    lost |= _speckles(z.shape, rng) < _dark_chance(view, sensor.dark)
    lost |= rng.random(z.shape, np.float32) < grazing_chance(z, intrinsics, 1.0, *GRAZING)
    valid = (measured > focal_baseline / MAX_RANGE_M) & (z > 0) & ~lost
    out = np.divide(focal_baseline, measured, out=np.zeros_like(z), where=valid)
    return quantised(out, focal_baseline, sensor.step)


def sensor_of(name: str) -> DepthSensor:
    """Return the sensor with a name.

    Raises
    ------
    InputError
        If there is no such sensor.
    """
    names = {known: known for known in get_args(SensorName)}
    if name not in names:
        raise InputError(f"sensor {name!r} is unknown, expected {', '.join(names)}")
    return SENSORS[names[name]]


def _dark_chance(view: RenderedView, dark: float) -> NDArray[np.float32]:
    """Return the probability that a pixel is too dark, (H, W); brightness 0 to `dark`."""
    if view.colour is None:
        return np.zeros(view.depth.shape, np.float32)
    brightness = view.colour.max(axis=2).astype(np.float32) / 255
    return (DARKEST_DROPOUT * np.clip(1 - brightness / dark, 0.0, 1.0)).astype(np.float32)


def _plain_surfaces(
    view: RenderedView, share: float, rng: np.random.Generator
) -> NDArray[np.bool_]:
    """Draw which surfaces have no texture, (H, W): one draw for each object and background kind."""
    surface = view.labels.astype(np.int64)
    if view.background is not None:
        surface = np.where(surface > 0, surface, -view.background.astype(np.int64))
    lowest = int(surface.min())
    drawn = rng.random(int(surface.max()) - lowest + 1) < share
    return drawn[surface - lowest]


def _speckles(shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return a smooth random field, (H, W), whose values are uniform in [0, 1]."""
    field = blurred(rng.standard_normal(shape, dtype=np.float32), _SPECKLE_PX)
    # The logistic function with this slope is the normal distribution to 0.01.
    return np.reciprocal(1 + np.asarray(cv2.exp(-1.702 * field), np.float32))


_MAJORITY, _MAJORITY_SPREAD = 0.42, 0.08
"""Share of the window that the near surface must cover to win, and its variation over the image.
Below one half, because the near surface has more contrast: outlines grow (foreground fattening)."""
_MAJORITY_PX = 4.0
"""Correlation length of that variation."""
_MIN_STEP_PX = 1.0
"""Smaller differences between neighbours may be slopes."""
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
_SHADOW_SLACK_PX = 0.75
"""A surface is hidden if the second view sees a nearer one this far across its place, at least.
Steep surfaces that both see cross by less, because of the size of pixels."""


def shadow(disparity: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return a mask (H, W) of the pixels that the second device on the +x side does not see.

    A point at column u has the column u - d in the second view, where d is its disparity. A point
    is hidden if a point farther right in the first view lies farther left in the second one
    (the ordering constraint, Baker and Binford 1981).

    Parameters
    ----------
    disparity
        (H, W) px; 0 = nothing there.
    """
    columns = np.arange(disparity.shape[1], dtype=np.float32)
    place = np.where(disparity > 0, columns - disparity, np.float32(np.inf))
    leftmost = np.minimum.accumulate(place[:, ::-1], axis=1)[:, ::-1]
    hidden = np.zeros(disparity.shape, bool)
    hidden[:, :-1] = place[:, :-1] > leftmost[:, 1:] + _SHADOW_SLACK_PX
    return hidden & (disparity > 0)


def matched_disparity(
    disparity: NDArray[np.float32], window: int, mixing: float, rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return the disparity that windows match, without noise, and where it steps.

    Where the disparities within a window differ by `mixing` at most, the result is their mean,
    which is exact on planes. At larger steps, the near surface wins if it covers enough of the
    window, else the far one.

    Parameters
    ----------
    disparity
        (H, W) px; 0 = nothing there.
    window
        Width of the window, odd, px.
    mixing
        Largest step of disparity that is smoothed, px.
    rng
        Source of randomness.

    Returns
    -------
    matched, edge
        Disparity (H, W), px, and a mask (H, W) of the pixels within half a window of a larger step.
    """
    jump = np.asarray(cv2.morphologyEx(disparity, cv2.MORPH_GRADIENT, _CROSS), np.float32)
    step = (jump > np.maximum(max(mixing, _MIN_STEP_PX), MIN_EDGE_STEP * disparity)).astype(
        np.uint8
    )
    edge = np.asarray(cv2.dilate(step, np.ones((window // 2 | 1, window // 2 | 1), np.uint8))) > 0
    if window <= 1:
        return disparity, edge
    kernel = np.ones((window, window), np.uint8)
    stepped = np.asarray(cv2.dilate(step, kernel)) > 0
    size = (window, window)
    near = np.asarray(cv2.dilate(disparity, kernel), np.float32)
    far = np.asarray(cv2.erode(disparity, kernel), np.float32)
    middle = (near + far) / 2
    on_near = disparity > middle
    share = np.asarray(cv2.boxFilter(on_near.astype(np.float32), -1, size))
    white = rng.standard_normal(disparity.shape, dtype=np.float32)
    near_wins = share > _MAJORITY + _MAJORITY_SPREAD * blurred(white, _MAJORITY_PX)
    # On the winner's own side the disparity is the pixel's own, which keeps its slope.
    chosen = np.where(near_wins, np.where(on_near, disparity, near), disparity)
    chosen = np.where(~near_wins & on_near, far, chosen)
    mean = np.asarray(cv2.blur(disparity, size), np.float32)
    smooth = np.where(near - far <= mixing, mean, disparity)
    return np.where(stepped, chosen, smooth).astype(np.float32, copy=False), edge
