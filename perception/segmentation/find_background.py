"""Find what objects stand on and in: the supports and the containers of a depth frame."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..frame import DepthFrame
from .block_heights import block_heights
from .find_containers import find_containers, include_floors
from .frame_noise import NoiseProfile, noise_profile
from .freed_memory import reuse_freed_memory
from .measure_container import FoundContainer
from .options import SegmentationOptions
from .parallel_planes import FlatReadings, flat_readings
from .result import SupportPlane
from .support_extent import Support
from .support_plane import find_supports
from .working_image import REFERENCE_WIDTH, WorkingImage, working_image


class Background(NamedTuple):
    """A frame with its supports and containers, before the search for objects."""

    image: WorkingImage
    """The whole image, with the measured noise."""
    stride: int
    """Step of the frame's rows and columns in this image, px."""
    options: SegmentationOptions
    """The options for the width of this image."""
    profile: NoiseProfile
    """The noise over disparity."""
    readings: FlatReadings
    """The readings on flat surfaces."""
    tops: NDArray[np.float32]
    """Heights of the blocks of the image above the first plane, m; empty without a plane."""
    planes: list[Support]
    """The supports without the floors of containers, best first."""
    containers: list[FoundContainer]
    """The containers."""
    supports: list[Support]
    """The supports with the floors of the containers, first support first."""


def find_support(
    frame: DepthFrame, options: SegmentationOptions | None = None
) -> SupportPlane | None:
    """Return the support plane of a frame, camera frame, or None if it shows none.

    The plane equals that of :func:`.segment`. It takes a third of the time.

    Parameters
    ----------
    frame
        Depth frame of any size.
    options
        Options of the segmentation.
    """
    supports = find_background(frame, options or SegmentationOptions(), StageClock()).supports
    return supports[0].plane if supports else None


def find_background(
    frame: DepthFrame, options: SegmentationOptions, clock: StageClock
) -> Background:
    """Find the supports and the containers of a frame."""
    reuse_freed_memory()
    # More than the reference resolution costs time and gains 0.1 % of overlap.
    stride = options.stride * max(frame.intrinsics.width // REFERENCE_WIDTH, 1)
    image = working_image(frame, stride, median=options.median)
    options = options.scaled(image.intrinsics.width)
    clock.finish("image")
    noise, profile = noise_profile(image.disparity, options.window)
    image = image._replace(noise=noise)
    clock.finish("noise")
    readings = flat_readings(image, profile)
    planes = find_supports(image, options, profile, readings)
    clock.finish("support")
    tops, containers = np.zeros((0, 0), np.float32), []
    if planes:
        tops = block_heights(image, planes[0].plane)
        containers = find_containers(image, planes, tops)
        clock.finish("containers")
    supports = include_floors(planes, containers)
    return Background(image, stride, options, profile, readings, tops, planes, containers, supports)


class StageClock:
    """The time of each stage, s: from the end of the stage before to its own end."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def finish(self, stage: str) -> None:
        """Add the time since the last call to a stage."""
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._last
        self._last = now
