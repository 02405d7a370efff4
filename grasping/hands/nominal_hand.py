"""The default hand of grasp planning."""

from __future__ import annotations

from functools import cache

import numpy as np

from .hand_model import HandModel

OPENINGS = (0.0, 0.05, 0.07, 0.10, 0.135)
"""Openings, m."""
REACHES = (0.100, 0.103, 0.103, 0.101, 0.096)
"""Reaches of fingers of 0.1 m at those openings, m; the maximum is that of straight fingers."""


@cache
def nominal_hand() -> HandModel:
    """Return a hand of three fingers and a thumb, 0.1 m long, with an opening of 135 mm.

    Its drives are placeholders.
    """
    openings = np.array(OPENINGS)
    return HandModel(
        drives=("finger", "thumb"),
        joints=(),
        pads=("finger_distal", "thumb_distal"),
        fingers=("finger", "thumb"),
        openings=openings,
        reaches=np.array(REACHES),
        excursions=np.tile((openings[-1] - openings)[:, None], 2),
        outer_widths=np.maximum(openings + 0.030, 0.088),
        row_width=0.068,
        pinch_width=0.020,
        thickness=0.012,
        palm_depth=0.060,
        finger_rows=(0.024, 0.0, -0.024),
        finger_width=0.017,
    )
