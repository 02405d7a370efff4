"""The hand that sizes are judged for when no other is known."""

from __future__ import annotations

from functools import cache

import numpy as np

from .hand_model import HandModel

OPENINGS = (0.0, 0.05, 0.07, 0.10, 0.135)
"""Free widths, m."""
REACHES = (0.100, 0.103, 0.103, 0.101, 0.096)
"""Reaches of 0.1 m fingers at those widths, m: farthest when they stand straight."""


@cache
def nominal_hand() -> HandModel:
    """Give three fingers against a thumb, 0.1 m long, opening to 135 mm; its drives are made up."""
    openings = np.array(OPENINGS)
    return HandModel(
        drives=("finger", "thumb"),
        joints=(),
        pads=("finger_distal", "thumb_distal"),
        fingers=("finger", "thumb"),
        openings=openings,
        reaches=np.array(REACHES),
        excursions=np.tile((openings[-1] - openings)[:, None], 2),
        spreads=np.maximum(openings + 0.030, 0.088),
        row=0.068,
        middle_row=0.020,
        thickness=0.012,
        palm_depth=0.060,
    )
