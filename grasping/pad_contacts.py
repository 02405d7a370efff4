"""Pads that touch the solid in a grasp: a finger that passes beside the object holds nothing."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from .chord_kernels import pad_chords

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .grasp_geometry import GraspGeometry
    from .hands import HandModel
    from .palm_placement import PalmPlacement
    from .prototypes import Prototype

MIN_OVERLAP = 0.004
"""Minimum overlap of a finger's pad and the object along the row of fingers, m. Less slides off:
the position of a side is known to 2 mm."""
TIP_DEPTHS = np.array([0.005, 0.015, 0.030])
"""Distances of the tested points from the fingertips, m. They lie on the outer two pads."""
WRAP_SHARES = np.array([0.25, 0.4, 0.55, 0.7, 0.8, 0.9])
"""Depths of the tested points in a power grasp, as shares of the reach. Every phalanx may touch."""
MAX_CHORD = 0.2
"""Length of the lines on which contacts are searched, m. It exceeds the opening of every hand."""


def touching_fingers(
    solid: Superquadric,
    prototype: Prototype,
    geometry: GraspGeometry,
    placement: PalmPlacement,
    hand: HandModel,
) -> NDArray[np.bool_]:
    """Return which fingers of the row touch the solid when the hand closes, (R,)."""
    centre_at, to_solid, semi_axes, exponents, taper = _arrays(solid)
    middle = palm_position(geometry, placement)
    axes = np.array([geometry.closing, geometry.finger_row, geometry.palm])
    offsets = hand.row_offsets
    # The part of a pad that is nearest to the middle of the object meets the widest section.
    centre = float((centre_at - middle) @ geometry.finger_row)
    slack = max(0.5 * hand.pad_width - MIN_OVERLAP, 0.0)
    rows = np.minimum(np.maximum(centre, offsets - slack), offsets + slack)
    reach = hand.reach(geometry.width)
    depths = WRAP_SHARES * reach if prototype == "power" else reach - TIP_DEPTHS
    chords = pad_chords(
        rows,
        depths,
        (middle - centre_at) @ to_solid,
        axes @ to_solid,
        MAX_CHORD,
        semi_axes,
        exponents,
        taper,
    )
    return np.asarray(np.isfinite(chords[..., 0]).any(axis=1))


@lru_cache(maxsize=64)
def _arrays(solid: Superquadric) -> tuple[NDArray[np.float64], ...]:
    """Return centre, rotation, semi-axes, exponents and taper of a solid."""
    return (
        solid.centre,
        solid.rotation,
        solid.semi_axes,
        np.array(solid.exponents),
        np.array(solid.taper),
    )


def palm_position(geometry: GraspGeometry, placement: PalmPlacement) -> NDArray[np.float64]:
    """Return the position of the palm at the grasp, (3,), m, in the middle of its interval."""
    along = geometry.finger_row if geometry.approach == "top" else geometry.up
    offset = 0.5 * (placement.low + placement.high) * along
    return geometry.centre - placement.standoff * geometry.palm + offset
