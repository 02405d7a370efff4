"""The three grasp prototypes and the sizes they suit.

Cutkosky's taxonomy (Cutkosky and Howe 1990) reduced to power, precision and pincer, as the
chapter does. Limits are those of a hand with about 130 mm opening.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Prototype = Literal["power", "precision", "pincer"]
"""How the hand closes: whole hand wraps, fingertips oppose the thumb, two fingertips pinch."""

Approach = Literal["side", "top"]
"""Where the palm comes from, relative to the support plane."""

GraspPurpose = Literal["lift", "move", "hand-over", "use"]
"""What happens after the grasp."""


@dataclass(frozen=True)
class PrototypeLimits:
    """Sizes and weights that the prototypes suit; lengths in m, masses in kg."""

    pincer_width: float = 0.032
    """Widest object between two fingertips."""
    pincer_length: float = 0.060
    """Longest other horizontal extent that two fingertips hold without turning."""
    crowded_pincer: tuple[float, float] = (0.060, 0.090)
    """Width and length up to which two fingertips must do where neighbours leave no room for the
    whole row of fingers."""
    pincer_mass: float = 0.15
    """Heaviest object that two fingertips hold."""
    side_power_height: float = 0.085
    """Least height for the whole hand from the side, clear of the table."""
    side_power_slenderness: float = 1.3
    """Least height over width from the side: lower objects are reached better from above."""
    side_power_width: tuple[float, float] = (0.030, 0.085)
    """Widths that fingers and thumb close around from the side."""
    top_power_width: tuple[float, float] = (0.052, 0.098)
    """Widths that the whole hand covers from above."""
    top_power_height: float = 0.045
    """Least height for fingers to reach below the widest part from above."""
    precision_width: float = 0.115
    """Widest object between fingertips and thumb."""
    precision_mass: float = 0.8
    """Heaviest object that fingertips hold."""
    clearance: float = 0.030
    """Opening beyond the object's width in the pre-shape: 10 mm, 10 % and 10° of error pass."""
    side_clearance: float = 0.050
    """The same from the side, where the roots of the fingers come near the object."""
    tight_clearance: float = 0.010
    """The same where neighbours leave no more: less passes them, and forgives less."""
    opening: float = 0.135
    """Widest opening of the hand."""
    least_clearance: float = 0.008
    """Least opening beyond the width, half of it on either side: less touches on the way."""
    fingertip_height: float = 0.008
    """Least height for fingertips to get a hold above the support."""
    fingertip_hold: float = 0.004
    """Least overlap of tips and object along the palm's direction."""
    finger_gap: float = 0.003
    """Least free space between a neighbour and where a finger will be."""
    push_depth: float = 0.010
    """How far fingers may reach into where a neighbour stands, when it may be pushed aside: more
    clears denser piles, and comes down on top of what does not give way."""
    easy_gap: float = 0.025
    """Free space beside the fingers from which on neighbours are of no concern."""


PURPOSE_PREFERENCE: dict[GraspPurpose, dict[Prototype, float]] = {
    "lift": {"power": 1.0, "precision": 0.9, "pincer": 0.9},
    "move": {"power": 1.0, "precision": 0.85, "pincer": 0.8},
    "hand-over": {"power": 0.7, "precision": 1.0, "pincer": 0.9},
    "use": {"power": 1.0, "precision": 0.8, "pincer": 0.6},
}
"""How well each prototype serves what follows: carrying wants the whole hand, handing over wants
a part of the object left free."""
PRECISION_FALLBACK = 0.7
"""Precision holds almost everything, but less surely than what suits the size."""
SIDE_PRECISION = 0.8
"""From the side fingertips carry the weight across their pads: above is better where it is free."""
LONG_SIDE = 0.9
"""Closing along the longer side holds with less to spare, and turns less easily into line."""
SLENDER = (3.0, 6.0)
"""Height over width from which an object topples when touched, and where it surely does."""
TOPPLES = 0.7
"""Worth of a grasp of what surely topples when touched."""
PALM_AWAY = (0.010, 0.040)
"""Distances of the palm from the object, m: up to the first a power grasp wraps, from the second
on it is a squeeze of the fingers."""
SQUEEZED = 0.85
"""Worth of a power grasp without the palm."""
EASY_HOLD = 0.015
"""Overlap of tips and object from which on more does not matter, m."""
SHALLOW = 0.6
"""Worth of a hold by the very ends of the tips."""
DOUBTED = 0.7
"""Worth of a grasp across sides that nobody saw, at the largest doubt that counts."""
MAKESHIFT = 0.25
"""Worth of the width of a pinch past what suits it: any other grasp goes first."""
TIGHT = 0.9
"""Worth of an opening that forgives less."""
PUSHED = 0.3
"""Worth of a grasp whose fingers push a neighbour aside, as far as they may."""
ROOMIER = 0.5
"""Worth of a way to take hold that is only tried for want of room."""
CROWDED = 0.5
"""Worth of a grasp whose fingers just pass the neighbours."""


@dataclass(frozen=True)
class WeightEstimate:
    """Mass range of an object of unknown content."""

    density_range: tuple[float, float] = (100.0, 1300.0)
    """Densities of household goods, kg/m³: from an empty carton to a full can."""
    density: float = 600.0
    """Middle of the range, kg/m³, used to choose."""

    def mass(self, volume: float) -> tuple[float, float, float]:
        """Least, likely and largest mass, kg, of a volume in m³."""
        low, high = self.density_range
        return volume * low, volume * self.density, volume * high
