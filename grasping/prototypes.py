"""The three grasp prototypes, and the sizes and weights of objects that suit them.

The prototypes reduce the taxonomy of Cutkosky and Howe (1990) to power, precision and pincer, as
Haschke's chapter does. Limits hold for a hand with an opening of about 130 mm.
"""

from __future__ import annotations

from typing import Literal

Prototype = Literal["power", "precision", "pincer"]
"""Prototype of a grasp.

- power: the whole hand encloses the object.
- precision: all fingertips oppose the thumb.
- pincer: one fingertip opposes the thumb.
"""

Approach = Literal["side", "top"]
"""Direction from which the palm approaches, relative to the support plane."""

GraspPurpose = Literal["lift", "move", "hand-over", "use"]
"""Purpose of the grasp."""

PINCER_WIDTH, PINCER_LENGTH = 0.032, 0.060
"""Maximum width of an object in a pincer, and its maximum length without turning, m."""
CROWDED_PINCER_WIDTH, CROWDED_PINCER_LENGTH = 0.060, 0.090
"""The same limits where neighbours leave no room for the whole row of fingers, m."""
PINCER_MASS = 0.15
"""Maximum mass of an object in a pincer, kg."""
SIDE_POWER_HEIGHT = 0.085
"""Minimum height of an object for a side grasp with the hand clear of the table, m."""
SIDE_POWER_SLENDERNESS = 1.3
"""Minimum ratio of height to width for a side power grasp. Lower objects suit a top grasp."""
SIDE_POWER_WIDTH = (0.030, 0.085)
"""Range of widths for a side power grasp, m."""
TOP_POWER_WIDTH = (0.052, 0.098)
"""Range of widths for a top power grasp, m."""
TOP_POWER_HEIGHT = 0.045
"""Minimum height for a top power grasp, m. The fingers must reach below the widest part."""
PRECISION_WIDTH = 0.115
"""Maximum width for a precision grasp, m."""
PRECISION_MASS = 0.8
"""Maximum mass for a precision grasp, kg."""
MAX_OPENING = 0.135
"""Maximum opening of the hand that is used, m."""
CLEARANCE = 0.030
"""Opening beyond the object's width in a top pre-shape, m. It tolerates errors of 10 mm, 10 % and
10°."""
SIDE_CLEARANCE = 0.050
"""Opening beyond the object's width in a side pre-shape, m. The roots of the fingers come close to
the object there."""
TIGHT_CLEARANCE = 0.010
"""Opening beyond the object's width where neighbours leave no more room, m. It tolerates smaller
errors."""
MIN_CLEARANCE = 0.008
"""Minimum opening beyond the object's width, m, half of it on either side."""
FINGERTIP_HEIGHT = 0.008
"""Minimum height of an object for a hold with the fingertips above the support, m."""
FINGERTIP_HOLD = 0.004
"""Minimum overlap of fingertips and object along the palm's direction, m."""
FINGER_GAP = 0.003
"""Minimum distance of a finger to a neighbour, m."""
EASY_FINGER_GAP = 0.025
"""Distance of a finger to a neighbour above which the neighbour has no effect, m."""
PUSH_DEPTH = 0.010
"""Maximum depth by which fingers push a neighbour aside, m. More clears denser piles, but the
fingers come down on top of neighbours that cannot move."""
DENSITY_RANGE = (100.0, 1300.0)
"""Densities of household objects, kg/m³: from an empty carton to a full can."""
LIKELY_DENSITY = 600.0
"""Likely density, kg/m³, by which a grasp is scored."""


def mass_range(volume: float) -> tuple[float, float, float]:
    """Return the minimum, likely and maximum mass, kg, of an object of a volume in m³."""
    low, high = DENSITY_RANGE
    return volume * low, volume * LIKELY_DENSITY, volume * high
