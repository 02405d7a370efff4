"""Raw readings in, contact features out: what a servo calls every cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .feature_kernels import VALUES, pack_geometry, read_features
from .features import ContactFeatures, FeatureOptions, unpack, with_hough
from .image import TactileArray, TactileImage
from .region import pack_links

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .calibration import Calibration


class FeatureReader:
    """Calibrate readings, find the contact and describe it, in one compiled call.

    It remembers where the contact was, for the choice between several.

    Parameters
    ----------
    calibration
        Of the array's tactels.
    array
        Where they are.
    options
        How a contact is found and described.

    Raises
    ------
    InputError
        If calibration and array have different numbers of tactels, or Hough is asked of an array
        without a grid.
    """

    def __init__(
        self,
        calibration: Calibration,
        array: TactileArray,
        options: FeatureOptions | None = None,
    ) -> None:
        self._options = options or FeatureOptions()
        count = len(array.positions)
        if len(calibration.rest) != count:
            raise InputError(
                f"the calibration must be of {count} tactels like the array, got one of "
                f"{len(calibration.rest)}"
            )
        if self._options.orientation == "hough" and array.grid is None:
            raise InputError("the Hough transform needs an array with an even grid; use moments")
        self._array = array
        self._shape = (count,)
        self._pressures = np.zeros(count)
        self._members = np.empty(count, np.int32)
        self._values = np.empty(VALUES)
        self._previous = np.full(3, np.nan)
        self._arguments = (
            calibration.table,
            calibration.limits,
            calibration.threshold(self._options.sigmas),
            pack_links(array),
            pack_geometry(array),
            self._previous,
            self._options.hysteresis,
            self._options.min_tactels,
            self._options.rim,
            self._pressures,
            np.zeros(count, np.uint8),
            self._members,
            self._values,
        )

    def read(self, raw: NDArray[np.uint16]) -> ContactFeatures:
        """Give the features of raw readings, (N,) uint16.

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
        found = unpack(self._values)
        if size and self._options.orientation == "hough":
            found = with_hough(found, self.image, self._members[:size], self._options.hough)
        return found

    @property
    def image(self) -> TactileImage:
        """The pressures read last, dead tactels filled in; all 0 before the first reading."""
        return TactileImage(self._pressures.copy(), self._array)

    def reset(self) -> None:
        """Forget where the contact was: of several, the largest is taken again."""
        self._previous[:] = np.nan
