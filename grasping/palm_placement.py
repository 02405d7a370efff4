"""How deep an object comes into the hand: near enough to hold, the tips clear of the table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .grasp_geometry import Grip
    from .hand_model import HandModel
    from .prototypes import Prototype


@dataclass(frozen=True)
class GraspDepths:
    """Where the object is in the hand at the grasp; lengths in m."""

    palm_gap: float = 0.003
    """Distance of the palm from what it wraps: nearer wraps better, and touches sooner."""
    roots: float = 0.058
    """Free width between the roots of fingers and thumb: a wider flat face meets them before it
    meets the palm."""
    root_gap: float = 0.85
    """Further distance of the palm per m by which such a face is wider."""
    table_gap: float = 0.004
    """Height that tips keep above what the object stands on: lower holds plates, and touches the
    table when the table is not where it was seen."""
    edge_gap: float = 0.008
    """Height that the lower edge of the hand keeps above it when it comes from the side."""
    tip_depth: float = 0.025
    """How far tips reach below the near face of what they pinch, at least where they can."""
    tip_beyond: float = 0.010
    """How far the ends of the tips pass the object's middle: their pads are behind their ends."""
    closing_slack: float = 0.010
    """By how much fingers close past the object's width while their reach still counts: covers
    errors of the width."""
    height_tolerance: float = 0.15
    """Share of the height by which the hand may hold a tall object off its middle."""
    length_tolerance: float = 0.10
    """Share of the length by which the hand may hold a long object off its middle."""
    most_tolerance: float = 0.015
    """No tolerance along the object is more than this, m."""
    ball_tilt: float = 0.26
    """Angle from which a ball may be approached off its top, rad: more leaves the arm more freedom,
    and lets the tips hang lower or hold less deep."""


@dataclass(frozen=True)
class Stance:
    """Where the palm is at the grasp."""

    standoff: float
    """Distance from the object's centre against the palm's direction, m."""
    cone: float
    """Largest angle of the hand's way from the grip's palm direction, rad."""
    low: float
    """Least place of the palm along the object (up from the side, the row from above), from the
    centre, m."""
    high: float
    """Largest."""


def stance(
    grip: Grip,
    prototype: Prototype,
    opening: float,
    hand: HandModel,
    depths: GraspDepths | None = None,
) -> Stance:
    """Place the palm for a grip: as near as the prototype wants, the tips clear of the table."""
    depths = depths or GraspDepths()
    near = grip.half_depth + depths.palm_gap
    if grip.flat:
        near += depths.root_gap * max(grip.width - depths.roots, 0.0)
    if grip.approach == "side":
        return _beside(grip, prototype, opening, hand, depths, near)
    slack = _tolerance(grip.length, depths.length_tolerance, depths)
    reach = closing_reach(hand, grip.width, opening, depths)
    # Below the centre, counted down: how far the tips may go, and how far they should.
    most = min(reach - near, grip.rise - depths.table_gap)
    if grip.freedom == "any_side":
        return _over_ball(grip, opening, hand, depths, reach, most)
    tips = most if prototype == "power" else min(most, _wanted_depth(grip, depths))
    return Stance(reach - tips, 0.0, -slack, slack)


def closing_reach(
    hand: HandModel, width: float, opening: float, depths: GraspDepths | None = None
) -> float:
    """Farthest reach of the tips from the palm while they close from an opening onto a width, m."""
    depths = depths or GraspDepths()
    low = max(width - depths.closing_slack, float(hand.openings[0]))
    between = hand.reaches[(hand.openings >= low) & (hand.openings <= opening)]
    return max(hand.reach(low), hand.reach(opening), *between.tolist())


def row_width(hand: HandModel, prototype: Prototype) -> float:
    """Outer width along the row of what a prototype closes, m."""
    return hand.middle_row if prototype == "pincer" else hand.row


def _over_ball(
    grip: Grip, opening: float, hand: HandModel, depths: GraspDepths, reach: float, most: float
) -> Stance:
    """Tilt as far as keeps the outer tips off the table, and hold no less deep than needed."""
    half = 0.5 * hand.spread(opening)
    room = grip.rise - depths.table_gap
    least = min(depths.tip_beyond, most)
    # Of least cos + half sin = room, the tilt at which the lower tips meet the table.
    size = float(np.hypot(least, half))
    ratio = room / size
    tilt = np.pi if ratio >= 1.0 else float(np.arcsin(max(ratio, 0.0)) - np.arctan2(least, half))
    tilt = float(np.clip(tilt, 0.0, depths.ball_tilt))
    deepest = (room - half * np.sin(tilt)) / np.cos(tilt)
    return Stance(reach - min(most, max(deepest, least)), tilt, 0.0, 0.0)


def _beside(
    grip: Grip,
    prototype: Prototype,
    opening: float,
    hand: HandModel,
    depths: GraspDepths,
    near: float,
) -> Stance:
    slack = _tolerance(grip.height, depths.height_tolerance, depths)
    lowest = 0.5 * row_width(hand, prototype) + depths.edge_gap - grip.rise
    low = max(-slack, lowest)
    standoff = near
    if prototype != "power":
        reach = closing_reach(hand, grip.width, opening, depths)
        standoff = max(near, reach - _wanted_depth(grip, depths))
    return Stance(standoff, np.pi, low, max(low, slack))


def _wanted_depth(grip: Grip, depths: GraspDepths) -> float:
    """How far tips should pass the object's centre, m: its near face is half a depth before it."""
    return max(depths.tip_beyond, depths.tip_depth - grip.half_depth)


def _tolerance(extent: float, share: float, depths: GraspDepths) -> float:
    return min(share * extent, depths.most_tolerance)
