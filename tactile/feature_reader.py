"""Convert raw readings to contact features, for the cycles of a servo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .calibration import Calibration
from .feature_kernels import SATURATED, VALUE_COUNT, Buffers, read_features
from .features import ContactFeatures, FeatureOptions, kernel_rule, unpack, with_hough
from .image import TactileArray, TactileImage
from .load_memory import FoamMemory, MemoryFilter


class FeatureReader:
    """Calibrate readings and compute the features of the contact, in one compiled call.

    The reader stores the centre of the last contact. If there are several contacts, it selects the
    one nearest to it. It does not smooth the features: the servo averages pressure and orientation
    (`ServoOptions.window`).

    Parameters
    ----------
    calibration
        Calibration of the array's tactels.
    array
        Geometry of the array.
    options
        Detection and description of a contact.
    memory
        The foam's memory of earlier loads, from :func:`fit_memory`. The centre of the contact is
        then that of the image without it. Force and pressure keep it. None: nothing is removed.
    period
        Time between two readings, s; needed with a memory.

    Raises
    ------
    InputError
        If calibration and array have different numbers of tactels, the Hough transform or a memory
        is requested for an array without a grid, or a memory without a period.
    """

    def __init__(
        self,
        calibration: Calibration,
        array: TactileArray,
        options: FeatureOptions | None = None,
        memory: FoamMemory | None = None,
        period: float = 0.0,
    ) -> None:
        if memory is not None and (array.grid is None or not 0.0 < period < np.inf):
            raise InputError(f"a memory needs an even grid and a period > 0 s, got {period}")
        self._memory = None if memory is None else MemoryFilter(memory, doubt=0.0)
        self._period = period
        self._options = options or FeatureOptions()
        count = len(array.positions)
        if len(calibration.rest) != count:
            raise InputError(
                f"the calibration must have {count} tactels like the array, got "
                f"{len(calibration.rest)}"
            )
        if self._options.orientation == "hough" and array.grid is None:
            raise InputError("the Hough transform needs an array with an even grid; use moments")
        self._array = array
        self._shape = (count,)
        self._buffers = Buffers(
            pressures=np.zeros(count),
            states=np.zeros(count, np.uint8),
            members=np.empty(count, np.int32),
            values=np.empty(VALUE_COUNT),
            previous=np.full(3, np.nan),
        )
        self._values = self._buffers.values
        thresholds = calibration.threshold(self._options.sigmas)
        self._arguments = (
            calibration.curves,
            calibration.limits,
            thresholds,
            array.links,
            array.geometry,
            kernel_rule(self._options),
            tuple(self._buffers),
        )

    def read(self, raw: NDArray[np.uint16]) -> ContactFeatures:
        """Compute the features of raw readings, (N,) uint16.

        Raises
        ------
        InputError
            If there is not one uint16 reading per tactel.
        """
        if raw.shape != self._shape or raw.dtype != np.uint16:
            raise InputError(
                f"raw readings must be {self._shape[0]} uint16, got {raw.shape} {raw.dtype}"
            )
        size = read_features(raw, *self._arguments)
        features = unpack(self._values)
        if size and self._options.orientation == "hough":
            members = self._buffers.members[:size]
            features = with_hough(features, self.image, members)
        if self._memory is not None:
            image = self._memory.correct(self._buffers.pressures, self._period, self.saturated)
            members = self._buffers.members[:size]
            if image[members].sum() > 0.0:
                centre = image[members] @ self._array.positions[members] / image[members].sum()
                features = replace(features, centre=centre)
        return features

    @property
    def image(self) -> TactileImage:
        """The last pressures, with dead tactels interpolated; all 0 before the first reading."""
        return TactileImage(self._buffers.pressures.copy(), self._array)

    @property
    def saturated(self) -> NDArray[np.bool_]:
        """Mask (N,) of the tactels that were saturated in the last reading."""
        return self._buffers.states == SATURATED

    def reset(self) -> None:
        """Clear the centre of the last contact. The next contact is then the largest region."""
        self._buffers.previous[:] = np.nan
