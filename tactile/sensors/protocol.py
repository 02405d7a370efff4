"""The protocol of tactile sensors: what a driver of a real or simulated array implements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..calibration_curves import check_bits
from ..image import TactileArray

MAX_PERIODS = 5.0
"""Maximum mean time between images, in periods of the stated rate. Longer gaps count as stops."""


@dataclass(frozen=True)
class SensorInfo:
    """The description of a tactile sensor.

    Raises
    ------
    InputError
        If the bits are not 1 to 16, or the rate is not positive.
    """

    name: str
    """Name of the sensor, for messages and recordings."""
    array: TactileArray
    """Tactels in the order of the readings: a grid of rows and columns, or a list of poses."""
    rate: float
    """Nominal number of images per second."""
    bits: int = 12
    """Bits of the converter, 1 to 16."""
    shear: bool = False
    """Whether images contain the shear stress on each tactel."""

    def __post_init__(self) -> None:
        check_bits(self.bits)
        if not 0 < self.rate < np.inf:
            raise InputError(f"rate must be > 0 images per second, got {self.rate}")

    def check_clock(self, images: int, seconds: float) -> None:
        """Raise an `InputError` if a time by the sensor's clock is too long for its images."""
        if seconds * self.rate > MAX_PERIODS * images:
            raise InputError(
                f"{self.name} took {seconds:g} s by its own clock for {images} images, and its "
                f"rate is {self.rate:g} per second: times must be in s, and rate that of the sensor"
            )


@dataclass(frozen=True)
class TactileFrame:
    """One image of a tactile sensor, before calibration."""

    time: float
    """Time of the image by the sensor's clock, s; the arrival for sensors without a clock."""
    raw: NDArray[np.uint16]
    """Readings of the tactels, (N,) uint16."""
    shear: NDArray[np.float64] | None = None
    """Shear stress on each tactel along the axes of `image.tangents`, (N, 2), Pa; None without."""

    def check(self, info: SensorInfo) -> None:
        """Raise an `InputError` if the image does not belong to a sensor with this description."""
        count = len(info.array.positions)
        raw = np.asarray(self.raw)
        if raw is not self.raw or raw.shape != (count,) or raw.dtype != np.uint16:
            raise InputError(
                f"{info.name}: raw must be {count} uint16, got {type(self.raw).__name__} "
                f"{raw.shape} {raw.dtype}; np.array(raw, np.uint16) converts integers"
            )
        top = 2**info.bits - 1
        if self.raw.max(initial=0) > top:
            raise InputError(
                f"{info.name}: raw must be 0 to {top} at {info.bits} bits, "
                f"got {self.raw.max()}: check bits of SensorInfo"
            )
        shape = None if self.shear is None else self.shear.shape
        if shape != ((count, 2) if info.shear else None):
            right = f"{count} x 2" if info.shear else "None"
            raise InputError(
                f"{info.name}: shear must be {right} because SensorInfo.shear is {info.shear}, got "
                f"{shape}"
            )
        if not np.isfinite(self.time):
            raise InputError(f"{info.name}: time must be finite, got {self.time}")


class TactileSensor(Protocol):
    """The driver of a tactile sensor. `eyehand.tactile.sensors` has several."""

    @property
    def info(self) -> SensorInfo:
        """Description of the sensor."""
        ...

    def read(self, timeout: float = 1.0) -> TactileFrame | None:
        """Wait for the next image and return it; None if none comes within the timeout, s.

        A lost connection is a `RuntimeError`, as `DeviceError` is, or an `OSError`. A recording
        returns None at its end.
        """
        ...

    def close(self) -> None:
        """Release the device or the file."""
        ...
