"""A calibrated sensor: images in, features and faults out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import DeviceError, InputError

from ..calibration import Calibration
from ..feature_reader import FeatureReader
from ..features import ContactFeatures, FeatureOptions
from ..image import TactileImage
from ..phase_step import SensorFault
from .protocol import TactileFrame, TactileSensor
from .rest_tracker import RestTracker
from .sensor_monitor import SensorMonitor

MAX_STEP = 0.1
"""Maximum time between two images by which the drift is followed, s."""


@dataclass(frozen=True)
class ContactReading:
    """The contact that a sensor measures in one control cycle."""

    features: ContactFeatures
    """Features of the newest image."""
    fault: SensorFault | None
    """Fault of the sensor, for `TouchPhases.step`; None if it works."""
    frame: TactileFrame | None
    """The newest image; None if none arrived in this cycle."""
    side_force: NDArray[np.float64] | None
    """Tangential force on the array along its x and y, (2,), N; None without shear."""


class ContactSensor:
    """Read a sensor: remove drift, calibrate, compute features, and check the sensor.

    Parameters
    ----------
    sensor
        The driver.
    calibration
        Calibration of its tactels.
    options
        Detection and description of a contact.

    Raises
    ------
    InputError
        If the calibration belongs to another number of tactels, or of bits.
    """

    def __init__(
        self,
        sensor: TactileSensor,
        calibration: Calibration,
        options: FeatureOptions | None = None,
    ) -> None:
        if calibration.bits != sensor.info.bits:
            raise InputError(
                f"{sensor.info.name} has {sensor.info.bits} bits, and its calibration "
                f"{calibration.bits}"
            )
        self.sensor = sensor
        self._reader = FeatureReader(calibration, sensor.info.array, options)
        self.rest = RestTracker(calibration)
        self._monitor = SensorMonitor(sensor.info, calibration)
        self._time: float | None = None
        self._features = self._reader.read(np.zeros(len(calibration.rest), np.uint16))

    @property
    def image(self) -> TactileImage:
        """The last pressures, with dead tactels interpolated."""
        return self._reader.image

    def zero(self, images: int = 50) -> None:
        """Zero the sensor, which nothing may touch.

        Raises
        ------
        InputError
            If readings change meanwhile or show a load, or images or their times do not belong to
            the sensor's description.
        DeviceError
            If images do not arrive.
        """
        raws, times = [], []
        # A silent sensor is given up after one timeout.
        while len(raws) < images and (frame := self.sensor.read()) is not None:
            frame.check(self.sensor.info)
            raws.append(frame.raw)
            times.append(frame.time)
        if len(raws) < images:
            raise DeviceError(
                f"{self.sensor.info.name} returned {len(raws)} of {images} images for zeroing"
            )
        self.sensor.info.check_clock(images, times[-1] - times[0])
        self.rest.zero(np.array(raws))

    def read(self, dt: float) -> ContactReading:
        """Wait for the next image, at most for one control period.

        A driver that lost its device counts as a sensor that stopped.

        Parameters
        ----------
        dt
            Control period, s.

        Raises
        ------
        InputError
            If the image does not belong to the sensor's description.
        """
        try:
            frame = self.sensor.read(dt)
        except (RuntimeError, OSError):
            frame = None
        if frame is not None:
            frame.check(self.sensor.info)
        fault = self._monitor.check(frame, dt)
        side_force = None
        if frame is not None:
            passed = 0.0 if self._time is None else frame.time - self._time
            self._time = frame.time
            self._features = self._reader.read(self.rest.correct(frame.raw, min(passed, MAX_STEP)))
            if frame.shear is not None:
                side_force = self.sensor.info.array.areas @ frame.shear
        return ContactReading(self._features, fault, frame, side_force)
