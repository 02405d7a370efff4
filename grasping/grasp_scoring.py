"""Score a prototype for a grasp geometry: rejections and score terms."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .fit_uncertainty import MAX_STD
from .pad_contacts import touching_fingers
from .prototypes import (
    CROWDED_PINCER_LENGTH,
    CROWDED_PINCER_WIDTH,
    EASY_FINGER_GAP,
    FINGER_GAP,
    FINGERTIP_HEIGHT,
    FINGERTIP_HOLD,
    MAX_OPENING,
    MIN_CLEARANCE,
    PINCER_LENGTH,
    PINCER_MASS,
    PINCER_WIDTH,
    PRECISION_MASS,
    PRECISION_WIDTH,
    PUSH_DEPTH,
    SIDE_POWER_HEIGHT,
    SIDE_POWER_SLENDERNESS,
    SIDE_POWER_WIDTH,
    TOP_POWER_HEIGHT,
    TOP_POWER_WIDTH,
    GraspPurpose,
    Prototype,
)

if TYPE_CHECKING:
    from eyehand.perception import Superquadric

    from .grasp_geometry import GraspGeometry
    from .hand_clearance import NeighbourPoints
    from .hands import HandModel
    from .palm_placement import PalmPlacement

PURPOSE_PREFERENCE: dict[GraspPurpose, dict[Prototype, float]] = {
    "lift": {"power": 0.6, "precision": 1.0, "pincer": 0.6},
    "move": {"power": 1.0, "precision": 0.6, "pincer": 0.8},
    "hand-over": {"power": 0.7, "precision": 0.7, "pincer": 0.9},
    "use": {"power": 1.0, "precision": 0.55, "pincer": 0.6},
}
"""Weight of each prototype for the purpose of a grasp. Lifting prefers the prototype that fails
least: the row of fingertips against the thumb. A power grasp may press an object with upright sides
out of the hand, and a pincer presses with one finger only. Moving prefers the whole hand. A
hand-over prefers a free part of the object."""
SIDE_PRECISION_WEIGHT = 0.6
"""Weight of a precision grasp from the side, where the pads carry the weight tangentially."""
LONG_SIDE_WEIGHT = 0.9
"""Weight of closing along the longer side, which leaves less clearance."""
SLENDERNESS_RANGE, TOPPLE_WEIGHT = (3.0, 6.0), 0.7
"""Ratios of height to width from which an object may topple and surely topples when touched, and
the weight of the latter."""
PALM_DISTANCE_RANGE, NO_PALM_WEIGHT = (0.010, 0.040), 0.85
"""Palm distances up to which a power grasp encloses the object and from which on only the fingers
hold it, m, and the weight of the latter."""
MAX_PALM_GAP = 0.020
"""Maximum distance of the palm from a flat-sided object in a power grasp from the top, m. The outer
joints draw an object by 9 mm, and the palm search by at most 12 mm. Beyond that, the palm never
touches the object, and tightening fingers let go of its vertical sides."""
FLAT_SIDED = ("box", "superquadric")
"""Kinds whose sides may be vertical planes. Around other kinds, the row of fingers closes."""
MIN_POWER_FINGERS = 2
"""Minimum number of fingers that touch the object in a power grasp. All of them pull: those that
pass beside a thin object turn it out of the hand."""
GOOD_HOLD, SHALLOW_WEIGHT = 0.015, 0.6
"""Overlap of fingertips and object above which more has no effect, m, and the weight of none."""
UNCERTAIN_WEIGHT = 0.7
"""Weight of a grasp at the maximum uncertainty of the width."""
WIDE_PINCER_WEIGHT = 0.25
"""Weight of a pincer on an object that is too wide for it. Every other grasp goes first."""
PUSH_WEIGHT = 0.3
"""Weight of a grasp that pushes a neighbour by the maximum depth."""
CROWDED_WEIGHT = 0.5
"""Weight of a grasp with the minimum distance to a neighbour."""
MAX_OFFSET_SHARE = 0.35
"""Maximum palm offset from the object's middle in a side grasp, as a share of its height."""


class GraspContext(NamedTuple):
    """Data that all grasps of one object share."""

    hand: HandModel
    """The hand."""
    solid: Superquadric
    """The object's solid."""
    label: int
    """Label of the object."""
    neighbours: NeighbourPoints
    """Surface points of the neighbours, and of the other parts of the object."""
    mass: float
    """Likely mass, kg."""
    visible: float
    """Visible share of the object's outline, in [0, 1]."""
    narrowest: float
    """Minimum horizontal width of the object, m."""
    purpose: GraspPurpose
    """Purpose of the grasp."""


@dataclass(frozen=True)
class GraspEvaluation:
    """Evaluation of one prototype for one grasp geometry."""

    refusal: str
    """Reason why the grasp is impossible; empty if it is possible."""
    terms: dict[str, float]
    """Score terms, each in [0, 1]."""
    fingers: int = 0
    """Number of fingers without the thumb that touch the object; 0 for a refusal."""

    @property
    def total(self) -> float:
        """Product of the terms; 0 for an impossible grasp."""
        return 0.0 if self.refusal else math.prod(self.terms.values())


def evaluate_grasp(
    prototype: Prototype,
    geometry: GraspGeometry,
    placement: PalmPlacement,
    context: GraspContext,
    *,
    wide_pincer: bool = False,
) -> GraspEvaluation:
    """Evaluate a grasp by size, weight, table, uncertainty and purpose, without neighbours.

    Parameters
    ----------
    prototype, geometry, placement
        The grasp.
    context
        Hand, object and purpose.
    wide_pincer
        Whether a pincer may hold an object that is too wide for it, for want of room.
    """
    evaluate = {"power": _power, "precision": _precision, "pincer": _pincer}
    if wide_pincer:
        evaluate["pincer"] = _wide_pincer
    size = evaluate[prototype](geometry, context.mass)
    refusal = size.refusal or _too_wide(geometry, context.hand)
    refusal = refusal or _misses(geometry, placement, context.hand)
    fingers = 0
    if not refusal:
        touching = touching_fingers(context.solid, prototype, geometry, placement, context.hand)
        fingers = int(touching.sum())
        refusal = _too_few(prototype, fingers, len(touching))
    if prototype == "power" and geometry.approach == "top" and geometry.kind in FLAT_SIDED:
        refusal = refusal or _palm_misses(placement.standoff - geometry.half_depth)
    terms = {
        **size.terms,
        "purpose": PURPOSE_PREFERENCE[context.purpose][prototype],
        "certainty": _interpolate(geometry.width_std, (0.0, MAX_STD), UNCERTAIN_WEIGHT)
        * (0.5 + 0.5 * context.visible),
        "stands": _interpolate(
            geometry.height / context.narrowest, SLENDERNESS_RANGE, TOPPLE_WEIGHT
        ),
    }
    if geometry.freedom == "none" and geometry.width > context.narrowest * 1.05:
        terms["side"] = LONG_SIDE_WEIGHT
    if prototype == "power":
        distance = placement.standoff - geometry.half_depth
        terms["palm"] = _interpolate(distance, PALM_DISTANCE_RANGE, NO_PALM_WEIGHT)
    elif geometry.approach == "top":
        missing = GOOD_HOLD - _hold(geometry, placement, context.hand)
        terms["hold"] = _interpolate(missing, (0.0, GOOD_HOLD), SHALLOW_WEIGHT)
    return GraspEvaluation(refusal, terms, fingers)


def clearance_term(gap: float) -> float:
    """Return the score term of the distance to neighbours, m; a negative one pushes them."""
    if gap < FINGER_GAP:
        return _interpolate(FINGER_GAP - gap, (0.0, FINGER_GAP + PUSH_DEPTH), PUSH_WEIGHT)
    return _interpolate(EASY_FINGER_GAP - gap, (0.0, EASY_FINGER_GAP - FINGER_GAP), CROWDED_WEIGHT)


def _pincer(
    geometry: GraspGeometry,
    mass: float,
    max_width: float = PINCER_WIDTH,
    max_length: float = PINCER_LENGTH,
) -> GraspEvaluation:
    refusal = (
        _above("width", geometry.width, max_width)
        or _above("length", geometry.length, max_length)
        or _below("height", geometry.height, FINGERTIP_HEIGHT)
        or _too_heavy(mass, PINCER_MASS)
    )
    width = _centred(geometry.width, 0.0, max_width)
    return GraspEvaluation(refusal, {"width": width, "weight": _ease(mass, PINCER_MASS)})


def _wide_pincer(geometry: GraspGeometry, mass: float) -> GraspEvaluation:
    pincer = _pincer(geometry, mass, CROWDED_PINCER_WIDTH, CROWDED_PINCER_LENGTH)
    return GraspEvaluation(pincer.refusal, {**pincer.terms, "width": WIDE_PINCER_WEIGHT})


def _power(geometry: GraspGeometry, mass: float) -> GraspEvaluation:
    del mass  # The whole hand holds every object of a suitable size.
    side = geometry.approach == "side"
    low, high = SIDE_POWER_WIDTH if side else TOP_POWER_WIDTH
    min_height = SIDE_POWER_HEIGHT if side else TOP_POWER_HEIGHT
    slenderness = geometry.height / geometry.width
    refusal = _below("height", geometry.height, min_height)
    if side and slenderness < SIDE_POWER_SLENDERNESS:
        refusal = refusal or f"height/width {slenderness:.2f} < {SIDE_POWER_SLENDERNESS}"
    refusal = (
        refusal or _below("width", geometry.width, low) or _above("width", geometry.width, high)
    )
    terms = {
        "width": _centred(geometry.width, low, high),
        "height": _ease(min_height, geometry.height),
    }
    return GraspEvaluation(refusal, terms)


def _precision(geometry: GraspGeometry, mass: float) -> GraspEvaluation:
    side = geometry.approach == "side"
    refusal = (
        _above("width", geometry.width, PRECISION_WIDTH)
        or _below("height", geometry.height, SIDE_POWER_HEIGHT if side else FINGERTIP_HEIGHT)
        or _too_heavy(mass, PRECISION_MASS)
    )
    terms = {
        "width": _centred(geometry.width, 0.0, PRECISION_WIDTH),
        "weight": _ease(mass, PRECISION_MASS),
        "approach": SIDE_PRECISION_WEIGHT if side else 1.0,
    }
    return GraspEvaluation(refusal, terms)


def _too_wide(geometry: GraspGeometry, hand: HandModel) -> str:
    limit = min(hand.max_opening, MAX_OPENING) - MIN_CLEARANCE
    return _above("width with its uncertainty", geometry.width + geometry.width_std, limit)


def _misses(geometry: GraspGeometry, placement: PalmPlacement, hand: HandModel) -> str:
    """Return the reason why the placed hand misses the object; empty if it does not."""
    if geometry.approach == "side":
        if placement.low > MAX_OFFSET_SHARE * geometry.height:
            return (
                f"the palm must be {placement.low * 1e3:.0f} mm above the middle "
                f"of {geometry.height * 1e3:.0f} mm to clear the table"
            )
        return ""
    hold = _hold(geometry, placement, hand)
    if hold < FINGERTIP_HOLD:
        return (
            f"the fingertips would hold {max(hold, 0.0) * 1e3:.0f} mm of the object above the table"
        )
    return ""


def _too_few(prototype: Prototype, fingers: int, count: int) -> str:
    """Return the reason why too few of `count` fingers touch the object; empty if enough do."""
    wanted = min(MIN_POWER_FINGERS, count) if prototype == "power" else 1
    if fingers >= wanted:
        return ""
    return f"{fingers} of {count} fingers would touch the object, at least {wanted} must"


def _palm_misses(gap: float) -> str:
    if gap <= MAX_PALM_GAP:
        return ""
    return f"the palm would stay {gap * 1e3:.0f} mm above the object"


def _hold(geometry: GraspGeometry, placement: PalmPlacement, hand: HandModel) -> float:
    """Return the reach of the closed fingertips beyond the object's near face, m."""
    return hand.reach(geometry.width) - (placement.standoff - geometry.half_depth)


def _centred(value: float, low: float, high: float) -> float:
    """Return 1 in the middle of a range and 0.5 at its ends, which tolerate smaller errors."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return float(max(1.0 - 0.5 * abs(value - middle) / half, 0.0))


def _ease(load: float, limit: float) -> float:
    """Return 1 far below a limit and 0.5 at it."""
    return float(max(1.0 - 0.5 * load / limit, 0.0))


def _interpolate(value: float, span: tuple[float, float], end: float) -> float:
    """Interpolate linearly from 1 at the start of a span to ``end`` at its end."""
    return float(np.interp(value, span, (1.0, end)))


def _above(name: str, value: float, limit: float) -> str:
    return f"{name} {value * 1e3:.0f} mm > {limit * 1e3:.0f} mm" if value > limit else ""


def _below(name: str, value: float, limit: float) -> str:
    return f"{name} {value * 1e3:.0f} mm < {limit * 1e3:.0f} mm" if value < limit else ""


def _too_heavy(mass: float, limit: float) -> str:
    return f"mass {mass:.2f} kg > {limit} kg" if mass > limit else ""
