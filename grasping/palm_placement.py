"""Place the palm for a grasp: close enough to hold, with the fingertips clear of the table."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from .grasp_geometry import GraspGeometry
    from .hands import HandModel
    from .prototypes import Prototype

PALM_GAP = 0.003
"""Distance between the palm and an object that it encloses, m. A smaller gap encloses better, but
touches earlier."""
FREE_ROOT_WIDTH = 0.058
"""Free width between the roots of fingers and thumb, m. A wider flat face touches the roots before
the palm."""
ROOT_GAP_SLOPE = 0.85
"""Additional palm distance per excess width of such a face."""
TABLE_GAP = 0.004
"""Height of the fingertips above the surface that the object rests on, m. Lower fingertips
hold plates, but touch the table if its estimated height is wrong."""
EDGE_GAP = 0.008
"""Height of the lower edge of the hand above that surface in a side grasp, m."""
CLOSING_SLACK = 0.010
"""Distance by which fingers close beyond the object's width, m. It covers errors of the width."""
HEIGHT_TOLERANCE = 0.15
"""Palm offset along a tall object, as a share of its height."""
LENGTH_TOLERANCE = 0.10
"""Palm offset along a long object, as a share of its length."""
MAX_TOLERANCE = 0.015
"""Maximum palm offset along an object, m."""
MAX_SPHERE_TILT = 0.26
"""Maximum tilt of the approach to a sphere from above, rad. More tilt leaves the arm more freedom,
but the fingertips hang lower or hold less deep."""


class TipDepth(NamedTuple):
    """The depth of the fingertips at an object."""

    below_face: float = 0.025
    """Depth of the fingertips below the near face of the object, m."""
    beyond_centre: float = 0.010
    """Minimum depth of the fingertips beyond the object's centre, m. The pads lie behind the
    tips."""


class PalmPlacement(NamedTuple):
    """Place of the palm relative to the object at the grasp."""

    standoff: float
    """Distance of the palm from the object's centre, against the palm's direction, m."""
    max_approach_angle: float
    """Maximum angle between the approach and the palm's nominal direction, rad. It keeps the
    fingertips off the table."""
    low: float
    """Minimum palm offset along the object from its centre, m. The direction is up in a side grasp
    and the row of fingers in a top grasp."""
    high: float
    """Maximum palm offset along the object, m."""


def place_palm(
    geometry: GraspGeometry,
    prototype: Prototype,
    opening: float,
    hand: HandModel,
    depth: TipDepth | None = None,
) -> PalmPlacement:
    """Place the palm for a grasp as close as the prototype needs.

    Parameters
    ----------
    geometry
        Directions and sizes of the grasp.
    prototype
        Prototype of the grasp.
    opening
        Opening of the hand before it closes, m.
    hand
        The hand.
    depth
        Wanted depth of the fingertips; None for the default.
    """
    depth = depth or TipDepth()
    min_standoff = geometry.half_depth + PALM_GAP
    if geometry.flat_face:
        min_standoff += ROOT_GAP_SLOPE * max(geometry.width - FREE_ROOT_WIDTH, 0.0)
    if geometry.approach == "side":
        return _beside(geometry, prototype, opening, hand, depth, min_standoff)
    slack = min(LENGTH_TOLERANCE * geometry.length, MAX_TOLERANCE)
    reach = max_closing_reach(hand, geometry.width, opening)
    # Maximum depth of the fingertips below the centre: the palm or the table limits it.
    max_depth = min(reach - min_standoff, geometry.rise - TABLE_GAP)
    if geometry.freedom == "any_tilt":
        return _over_sphere(geometry, opening, hand, depth, reach, max_depth)
    tip_depth = max_depth
    if prototype != "power":
        tip_depth = min(max_depth, _wanted_depth(geometry, depth))
    return PalmPlacement(reach - tip_depth, 0.0, -slack, slack)


def max_closing_reach(hand: HandModel, width: float, opening: float) -> float:
    """Return the maximum reach of the fingertips while they close from an opening to a width, m."""
    low = max(width - CLOSING_SLACK, float(hand.openings[0]))
    between = hand.reaches[(hand.openings >= low) & (hand.openings <= opening)]
    return max(hand.reach(low), hand.reach(opening), *between.tolist())


def _over_sphere(
    geometry: GraspGeometry,
    opening: float,
    hand: HandModel,
    depth: TipDepth,
    reach: float,
    max_depth: float,
) -> PalmPlacement:
    """Place the palm over a sphere, with the maximum tilt that keeps the fingers off the table."""
    # The outer fingers hang lowest where the hand tilts along a diagonal of its outline.
    half = 0.5 * float(np.hypot(hand.outer_width(opening), hand.row_width))
    room = geometry.rise - TABLE_GAP
    min_depth = min(depth.beyond_centre, max_depth)
    # The lower fingertips touch the table at the tilt that solves
    # min_depth * cos(tilt) + half * sin(tilt) = room.
    size = float(np.hypot(min_depth, half))
    ratio = room / size
    tilt = np.pi
    if ratio < 1.0:
        tilt = float(np.arcsin(max(ratio, 0.0)) - np.arctan2(min_depth, half))
    tilt = float(np.clip(tilt, 0.0, MAX_SPHERE_TILT))
    deepest = (room - half * np.sin(tilt)) / np.cos(tilt)
    return PalmPlacement(reach - min(max_depth, max(deepest, min_depth)), tilt, 0.0, 0.0)


def _beside(
    geometry: GraspGeometry,
    prototype: Prototype,
    opening: float,
    hand: HandModel,
    depth: TipDepth,
    min_standoff: float,
) -> PalmPlacement:
    """Place the palm beside an object, with the lower edge of the hand above the table."""
    slack = min(HEIGHT_TOLERANCE * geometry.height, MAX_TOLERANCE)
    row = hand.pinch_width if prototype == "pincer" else hand.row_width
    low = max(-slack, 0.5 * row + EDGE_GAP - geometry.rise)
    standoff = min_standoff
    if prototype != "power":
        reach = max_closing_reach(hand, geometry.width, opening)
        standoff = max(min_standoff, reach - _wanted_depth(geometry, depth))
    return PalmPlacement(standoff, np.pi, low, max(low, slack))


def _wanted_depth(geometry: GraspGeometry, depth: TipDepth) -> float:
    """Return the wanted depth of the fingertips beyond the object's centre, m."""
    return max(depth.beyond_centre, depth.below_face - geometry.half_depth)
