"""The sense of touch of a simulated hand, with the imperfections of its pads and electronics."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError
from eyehand.grasping import HandModel, HandReading
from eyehand.tactile import (
    Calibration,
    FoamMemory,
    MemoryFilter,
    TactileImage,
    calibrate,
    fit_creep,
    fit_memory,
)
from eyehand.tactile.sensors import RestTracker

from ..pad import run_bench
from ..pad.calibration_bench import MAX_LOAD_PA as SOFT_MAX_LOAD_PA
from ..pad.sensor_memory import SensorMemory
from .fingertip_pads import COLUMNS, ROWS, tip_array

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.grasping import ParallelHand
    from eyehand.grasping.hands import AnyReading

    from ..pad import SensorModel, TactileReadout
    from .fingertip_pads import FingertipPads

MAX_LOAD_PA = 800e3
"""Highest pressure that the tactels measure, Pa: 20 N on a tactel of a fingertip."""
PAD_AREA_M2 = 1e-4
"""Area of the single tactel of a phalanx, the palm, or the back of a fingertip. It measures up to
80 N."""
THRESHOLD_SIGMAS = 4.0
"""Reading above rest from which a tactel counts as loaded, in standard deviations of the noise."""
_PRESS_PA, _PRESS_S, _RELEASE_S, _HOLD_S = 100e3, 0.5, 2.0, 8.0
"""Presses from which the memory of the foam is fitted: their pressure, the times of a short press
and its release, and the time of a long one. A short press creeps little."""
_PRESS_IMAGES_PER_S = 50.0


class HandTouch:
    """Fingertip arrays and single tactels on all other pads, read through a sensor model.

    It does what the driver of a real hand does: it tracks the readings at rest, converts readings
    to pressures by a calibration on a bench, and removes the memory of the foam that one press has
    shown. Noise, gains that changed since the calibration, creep, wait and lag remain.

    Parameters
    ----------
    sensor
        Sensor model of all pads.
    hand
        The hand.
    tips
        Names of the pads that carry a fingertip array.
    seed
        Source of characteristics and noise, >= 0.

    Raises
    ------
    InputError
        If the hand has jaws.
    """

    def __init__(
        self,
        sensor: SensorModel,
        hand: HandModel | ParallelHand,
        tips: Sequence[str],
        seed: int = 0,
    ) -> None:
        if not isinstance(hand, HandModel):
            raise InputError("a sensor model needs a hand with fingers, got a gripper with jaws")
        pads = hand.pads
        self._shear = sensor.shear
        self._pad_of_tip = np.array([pads.index(name) for name in tips], dtype=np.intp)
        self._taxels = len(tips) * ROWS * COLUMNS
        count = self._taxels + len(pads)
        self._areas = np.full(count, PAD_AREA_M2)
        self._areas[: self._taxels] = tip_array().area
        readout, self._calibration = _calibrated(sensor, count, seed)
        self._memory = SensorMemory(sensor, readout, seed)
        self._rng = np.random.default_rng((seed, 4))
        self._tracker = RestTracker(self._calibration)
        self._filter = MemoryFilter(_fitted_memory(sensor, count, seed), doubt=0.0)
        self._threshold = self._calibration.threshold(THRESHOLD_SIGMAS)
        self._time: float | None = None
        self._forces, self._images = np.zeros(len(pads)), np.zeros((len(tips), ROWS * COLUMNS))

    def sense(self, exact: AnyReading, data: Any, tips: FingertipPads) -> None:
        """Take an image after a physics step.

        Parameters
        ----------
        exact
            Exact reading of the hand.
        data
            `MjData`, not before the last image.
        tips
            The fingertips of its model.
        """
        tactels = tips.pressures(data, self._shear)
        # What a fingertip bears beside its array loads the single tactel of its pad.
        beside = _finger_reading(exact).forces.copy()
        beside[self._pad_of_tip] -= sum_forces(tips.pressures(data))
        true = np.concatenate([tactels.ravel(), np.maximum(beside, 0.0) / PAD_AREA_M2])
        time = float(data.time)
        dt = 0.0 if self._time is None else time - self._time
        self._time = time
        raw = self._tracker.correct(self._memory.read(time, true, self._rng), dt)
        saturated = self._calibration.is_saturated(raw)
        read = self._filter.correct(self._calibration.to_pressure(raw), dt, saturated)
        read = np.where(read > self._threshold, read, 0.0)
        self._images = read[: self._taxels].reshape(self._images.shape)
        self._forces = read[self._taxels :] * PAD_AREA_M2
        np.add.at(self._forces, self._pad_of_tip, sum_forces(self._images))

    def touched(self, exact: AnyReading) -> HandReading:
        """Return a reading of the hand with the forces and images of the last :meth:`sense`."""
        images = tuple(TactileImage(image, tip_array()) for image in self._images)
        return replace(_finger_reading(exact), forces=self._forces, tips=images)


def _finger_reading(reading: AnyReading) -> HandReading:
    assert isinstance(reading, HandReading), "the constructor refuses jaws"
    return reading


def sum_forces(pressures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sum of the tactels' forces (T,), N, of fingertip images (T, 12), Pa."""
    return pressures.sum(axis=1) * tip_array().area


@lru_cache(maxsize=8)
def _calibrated(sensor: SensorModel, count: int, seed: int) -> tuple[TactileReadout, Calibration]:
    """Return the electronics of the tactels and their calibration on a bench."""
    soft = sensor.readout(count, seed)
    # A hand is stiffer than a pad: the same curves over a wider range.
    stiffness = MAX_LOAD_PA / SOFT_MAX_LOAD_PA
    readout = replace(soft, half_pressures=stiffness * soft.half_pressures)
    return readout, calibrate(run_bench(readout, seed, max_load=MAX_LOAD_PA))


@lru_cache(maxsize=8)
def _fitted_memory(sensor: SensorModel, count: int, seed: int) -> FoamMemory:
    """Press all tactels evenly, briefly and for long, and fit the memory to what is read."""
    late = sensor.wait + 3.0 * sensor.lag
    times, read = _pressed(sensor, count, seed, _PRESS_S, _PRESS_S + _RELEASE_S)
    loaded, released = times < _PRESS_S, times > _PRESS_S + late
    memory = fit_memory(read[loaded][-1], read[released], times[released] - _PRESS_S)
    times, read = _pressed(sensor, count, seed, _HOLD_S, _HOLD_S)
    return fit_creep(memory, read[times > late], times[times > late])


def _pressed(
    sensor: SensorModel, count: int, seed: int, press: float, seconds: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the times (M,), s, and the pressures (M, count), Pa, read in a press from time 0."""
    readout, calibration = _calibrated(sensor, count, seed)
    memory, rng = SensorMemory(sensor, readout, seed), np.random.default_rng((seed, 5))
    times = np.arange(0.0, seconds, 1.0 / _PRESS_IMAGES_PER_S)
    pressures = np.where(times[:, None] < press, _PRESS_PA, np.zeros(count))
    read = [
        calibration.to_pressure(memory.read(time, row, rng))
        for time, row in zip(times.tolist(), pressures, strict=True)
    ]
    return times, np.array(read)
