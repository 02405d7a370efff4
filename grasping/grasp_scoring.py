"""How well a prototype suits a way to take hold: the rules, their refusals and score terms."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .fit_uncertainty import MOST_DOUBT
from .prototypes import (
    CROWDED,
    DOUBTED,
    EASY_HOLD,
    LONG_SIDE,
    MAKESHIFT,
    PALM_AWAY,
    PRECISION_FALLBACK,
    PURPOSE_PREFERENCE,
    PUSHED,
    SHALLOW,
    SIDE_PRECISION,
    SLENDER,
    SQUEEZED,
    TOPPLES,
)

if TYPE_CHECKING:
    from .grasp_geometry import Grip
    from .hand_model import HandModel
    from .palm_placement import Stance
    from .prototypes import GraspPurpose, Prototype, PrototypeLimits

MOST_OFF_MIDDLE = 0.35
"""Share of the height by which the palm may be off the middle from the side: more misses it."""


@dataclass(frozen=True)
class Judgement:
    """What is to be said about one prototype in one grip."""

    refusal: str
    """Why it cannot be, or an empty string."""
    terms: dict[str, float]
    """Score terms, 0-1."""

    @property
    def total(self) -> float:
        """Product of the terms; 0 when refused."""
        return 0.0 if self.refusal else float(np.prod(list(self.terms.values())))


def judge(
    prototype: Prototype,
    grip: Grip,
    stance: Stance,
    hand: HandModel,
    *,
    mass: float,
    visible: float,
    narrowest: float,
    purpose: GraspPurpose,
    limits: PrototypeLimits,
    makeshift: bool = False,
) -> Judgement:
    """Judge a prototype by sizes, weight, table, doubt and purpose; neighbours are judged apart.

    Parameters
    ----------
    prototype, grip, stance, hand
        What is judged.
    mass
        Likely mass, kg.
    visible
        Share of the object's outline that is visible, 0-1.
    narrowest
        Its smallest horizontal width, m.
    purpose, limits
        What follows, and the sizes that the prototypes suit.
    makeshift
        Whether a pincer takes what is too wide for it, as where there is room for no more.
    """
    pincer = _makeshift_pincer if makeshift else _pincer
    rules = {"power": _power, "precision": _precision, "pincer": pincer}
    fit = rules[prototype](grip, mass, limits)
    refusal = fit.refusal or _beyond_hand(grip, hand, limits)
    refusal = refusal or _misses(prototype, grip, stance, hand, limits)
    slender = grip.height / narrowest
    terms = {
        **fit.terms,
        "purpose": PURPOSE_PREFERENCE[purpose][prototype],
        "certainty": _between(grip.doubt, (0.0, MOST_DOUBT), DOUBTED) * (0.5 + 0.5 * visible),
        "stands": _between(slender, SLENDER, TOPPLES),
    }
    if grip.freedom == "none" and grip.width > narrowest * 1.05:
        terms["side"] = LONG_SIDE
    if prototype == "power":
        away = stance.standoff - grip.half_depth
        terms["palm"] = _between(away, PALM_AWAY, SQUEEZED)
    elif grip.approach == "top":
        terms["hold"] = _between(EASY_HOLD - _hold(grip, stance, hand), (0.0, EASY_HOLD), SHALLOW)
    return Judgement(refusal, terms)


def room_term(gap: float, limits: PrototypeLimits) -> float:
    """Score term of the free space beside the fingers, m; below 0 they push a neighbour."""
    if gap < limits.finger_gap:
        return _between(
            limits.finger_gap - gap, (0.0, limits.finger_gap + limits.push_depth), PUSHED
        )
    return _between(limits.easy_gap - gap, (0.0, limits.easy_gap - limits.finger_gap), CROWDED)


def _pincer(grip: Grip, mass: float, limits: PrototypeLimits) -> Judgement:
    refusal = (
        _above("width", grip.width, limits.pincer_width)
        or _above("length", grip.length, limits.pincer_length)
        or _below("height", grip.height, limits.fingertip_height)
        or _too_heavy(mass, limits.pincer_mass)
    )
    width = _margin(grip.width, 0.0, limits.pincer_width)
    return Judgement(refusal, {"width": width, "weight": _ease(mass, limits.pincer_mass)})


def _makeshift_pincer(grip: Grip, mass: float, limits: PrototypeLimits) -> Judgement:
    width, length = limits.crowded_pincer
    suits = _pincer(grip, mass, replace(limits, pincer_width=width, pincer_length=length))
    return Judgement(suits.refusal, {**suits.terms, "width": MAKESHIFT})


def _power(grip: Grip, mass: float, limits: PrototypeLimits) -> Judgement:
    side = grip.approach == "side"
    low, high = limits.side_power_width if side else limits.top_power_width
    least = limits.side_power_height if side else limits.top_power_height
    slender = grip.height / grip.width
    refusal = _below("height", grip.height, least)
    if side and slender < limits.side_power_slenderness:
        refusal = refusal or f"height/width {slender:.2f} < {limits.side_power_slenderness}"
    refusal = refusal or _below("width", grip.width, low) or _above("width", grip.width, high)
    return Judgement(
        refusal,
        {"width": _margin(grip.width, low, high), "height": _ease(least, grip.height)},
    )


def _precision(grip: Grip, mass: float, limits: PrototypeLimits) -> Judgement:
    side = grip.approach == "side"
    refusal = (
        _above("width", grip.width, limits.precision_width)
        or _below(
            "height", grip.height, limits.side_power_height if side else limits.fingertip_height
        )
        or _too_heavy(mass, limits.precision_mass)
    )
    terms = {
        "width": _margin(grip.width, 0.0, limits.precision_width),
        "weight": _ease(mass, limits.precision_mass),
        "fallback": PRECISION_FALLBACK * (SIDE_PRECISION if side else 1.0),
    }
    return Judgement(refusal, terms)


def _beyond_hand(grip: Grip, hand: HandModel, limits: PrototypeLimits) -> str:
    most = min(hand.widest, limits.opening) - limits.least_clearance
    return _above("width with its doubt", grip.width + grip.doubt, most)


def _misses(
    prototype: Prototype, grip: Grip, stance: Stance, hand: HandModel, limits: PrototypeLimits
) -> str:
    """Why the hand, at its place, would miss the object, or an empty string."""
    if grip.approach == "side":
        if stance.low > MOST_OFF_MIDDLE * grip.height:
            return (
                f"the hand must stay {stance.low * 1e3:.0f} mm above the middle "
                f"of {grip.height * 1e3:.0f} mm to clear the table"
            )
        return ""
    hold = _hold(grip, stance, hand)
    if hold < limits.fingertip_hold:
        return f"tips would hold {max(hold, 0.0) * 1e3:.0f} mm of it above the table"
    return ""


def _hold(grip: Grip, stance: Stance, hand: HandModel) -> float:
    """How far the tips reach below the object's near face, closed on it, m."""
    return hand.reach(grip.width) - (stance.standoff - grip.half_depth)


def _margin(value: float, low: float, high: float) -> float:
    """1 in the middle of a range, 0.5 at its ends: room for errors of the fit."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return float(max(1.0 - 0.5 * abs(value - middle) / half, 0.0))


def _ease(load: float, limit: float) -> float:
    """1 far below a limit, 0.5 at it."""
    return float(max(1.0 - 0.5 * load / limit, 0.0))


def _between(value: float, span: tuple[float, float], worst: float) -> float:
    """1 below a span, the worst above it, straight in between."""
    return float(np.interp(value, span, (1.0, worst)))


def _above(name: str, value: float, limit: float) -> str:
    return f"{name} {value * 1e3:.0f} mm > {limit * 1e3:.0f} mm" if value > limit else ""


def _below(name: str, value: float, limit: float) -> str:
    return f"{name} {value * 1e3:.0f} mm < {limit * 1e3:.0f} mm" if value < limit else ""


def _too_heavy(mass: float, limit: float) -> str:
    return f"mass {mass:.2f} kg > {limit} kg" if mass > limit else ""
