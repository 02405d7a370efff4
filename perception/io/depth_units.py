"""Conversion between integer depth in files and depth in metres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

MM_PER_M = 1000.0
"""Millimetres in a metre."""

MIN_PLAUSIBLE_DEPTH_M = 0.01
"""Minimum distance that depth cameras measure. A smaller median means a wrong unit."""


def metres_from_units(raw: NDArray[np.integer], mm_per_unit: float) -> NDArray[np.float32]:
    """Convert whole numbers of `mm_per_unit` mm to depth (H, W) float32, m. 0 stays 0.

    Raises
    ------
    InputError
        If the median reading is under `MIN_PLAUSIBLE_DEPTH_M`. The unit may have been given in
        metres instead of millimetres.
    """
    # The product is computed in float64. The result is then the float32 nearest to the true value.
    with np.errstate(over="ignore"):
        depth = (raw.astype(np.float64) * mm_per_unit / MM_PER_M).astype(np.float32)
    readings = depth[depth > 0]
    if readings.size and np.median(readings) < MIN_PLAUSIBLE_DEPTH_M:
        raise InputError(
            f"median depth is {np.median(readings) * MM_PER_M:.3g} mm at {mm_per_unit:g} mm per "
            "unit, which no camera sees: check the depth scale (millimetres, or its key's unit)"
        )
    return depth


def millimetres_from_metres(depth: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Convert depth in m to whole mm, (H, W) uint16, rounded to the nearest. 0 stays 0.

    Raises
    ------
    InputError
        If a reading does not fit 16 bits, or would round to 0 and so count as no reading.
    """
    millimetres = np.rint(depth.astype(np.float64) * MM_PER_M)
    highest = float(millimetres.max())
    if highest > np.iinfo(np.uint16).max:
        raise InputError(
            f"depth reaches {highest / MM_PER_M:.3f} m, but a 16-bit PNG in mm ends at 65.535 m: "
            "write .npz instead"
        )
    lost = int(np.count_nonzero((millimetres == 0) & (depth > 0)))
    if lost:
        raise InputError(
            f"{lost} readings are under 0.5 mm and would become 'no reading' in a PNG in mm: "
            "write .npz instead"
        )
    return millimetres.astype(np.uint16)
