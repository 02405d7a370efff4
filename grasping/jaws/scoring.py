"""Probability that a grasp succeeds: a product of terms, calibrated on executed grasps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit, ndtr, ndtri

from ..hands.jaw_closing import PAD_RADIUS_SHARE

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from ..hands import ParallelHand
    from .options import JawOptions
    from .scored import ScoredCandidates
    from .surface_model import ObjectSurface

WIDTH_RESERVE = 0.001
"""Expected error of the width, m: the objects of staged scenes are wider by that in the mean."""
MIN_WIDTH_SIGMA = 0.002
"""Minimum standard deviation of a width, m."""
TILT_SIGMA = np.radians(10.0)
"""Standard deviation of the angle between pad and surface, rad."""
CLEARANCE_SIGMA = 0.003
"""Standard deviation of the distance of measured points from the hand without calibration error,
m."""
TOUCH_ALLOWANCE = 0.002
"""Penetration at which a contact is as likely as not, m. Averaged points lie inside thin edges."""
OVERLAP_MIDDLE, OVERLAP_SCALE = 0.008, 0.0025
"""Overlap of pads and object along the approach at which half the grasps hold, and the width of the
transition, m."""
SAMPLE_SPACING = 0.006
"""Distance between two points of a surface, m. The overlap is longer by about as much."""
UPRIGHT = 0.9
"""Probability that an overhanging side that was not seen is upright instead."""
SEEN_TERMS = np.array([0.80, 0.93, 1.0])
"""Term of the number of sides in contact that were measured."""
DENSITY = 500.0
"""Likely mass over volume of an unknown object, kg/m³."""
LIKELY_FORCE = 20.0
"""Closing force of each jaw that is assumed where the hand can do more, N."""
MIN_CAPACITY = 1e-9
"""Torque in N m below which a contact counts as frictionless."""
LEVER_SCALE = 0.08
"""Distance of the centre of mass from the closing axis that costs 40 %, m. It matters for objects
that are heavier than they look."""
GRAVITY = 9.81
SUCCESS_ODDS = 6.0
"""Odds of success over those of the product of the terms. The terms are not independent: what
lowers one lowers others. Fitted to 1305 grasps of the development objects that were not too heavy,
in four kinds of scenes: the best values of the single kinds are 5 to 10."""
REJECTED_TERM, DOUBTFUL_TERM, BRIDGED_TERM = 0.6, 0.95, 0.05
"""Terms of an object whose solid the fit rejected, of one whose solid is doubtful, and of the first
where fewer than `MIN_READINGS` lie between the pads: a rejected solid can bridge a gap."""
MIN_READINGS, BESIDE_PAD = 2, 0.006
"""Averaged readings below which it may do so, and distance inside a pad up to which they count, m.
On development objects 18 of 44 bad grasps have fewer, and 6 of 152 good ones; on fresh objects of
the same kinds 29 of 68, and 5 of 161."""
INDEPENDENT = ("depth_error", "existence")
"""The terms that are independent of the others: one large error of the scale moves the whole scene,
and a bump of noise is no object, whatever else speaks for its grasp."""


def success_probability(terms: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the probability of success of grasps (n,) from their terms, (n,) each."""
    product = np.prod([term for name, term in terms.items() if name not in INDEPENDENT], axis=0)
    together = SUCCESS_ODDS * product / (1.0 + (SUCCESS_ODDS - 1.0) * product)
    for name in INDEPENDENT:
        together = together * terms.get(name, 1.0)
    return together


@dataclass(frozen=True, eq=False)
class ContactTable:
    """Contacts of the candidates, from the columns of :func:`.contact_kernels.contacts`."""

    width: NDArray[np.float64]
    """Distance between the pads at contact, (n,), m."""
    cosine: NDArray[np.float64]
    """Cosine between closing axis and best normal at both pads, (n, 2)."""
    seen: NDArray[np.float64]
    """Whether each side was measured, (n, 2), 1 or 0."""
    overlap: NDArray[np.float64]
    """Length along the approach in which both pads touch, (n,), m."""
    middle: NDArray[np.float64]
    """Middle of the contact, (n, 3), m."""


def contact_terms(
    contact: ContactTable,
    closing: NDArray[np.float64],
    centre: NDArray[np.float64],
    volume: NDArray[np.float64],
    width_sigma: NDArray[np.float64],
    up: NDArray[np.float64],
    hand: ParallelHand,
    options: JawOptions,
) -> dict[str, NDArray[np.float64]]:
    """Return the terms that depend on the grasped object alone, each (n,) in [0, 1].

    Parameters
    ----------
    contact
        Contacts.
    closing
        Closing axes, (n, 3).
    centre, volume
        Centre of mass (n, 3), m, and volume (n,), m³, of each candidate's object.
    width_sigma
        Standard deviation of its width, (n,), m.
    up
        Unit direction up, (3,).
    hand, options
        Hand and options.
    """
    angle = np.arccos(np.clip(contact.cosine, -1.0, 1.0))
    cone = np.arctan(options.friction)
    friction = ndtr((cone - angle) / TILT_SIGMA).prod(axis=1)
    sigma = np.hypot(width_sigma, MIN_WIDTH_SIGMA)
    width = ndtr((hand.stroke - contact.width - WIDTH_RESERVE) / sigma)
    thickness = ndtr((contact.width - hand.min_opening - MIN_WIDTH_SIGMA) / sigma)
    length = contact.overlap + SAMPLE_SPACING
    overlap = expit((length - OVERLAP_MIDDLE) / OVERLAP_SCALE)
    return {
        "friction": friction,
        "width": width,
        "thickness": thickness,
        "overlap": overlap,
        "torque": _torque(contact, closing, centre, volume, up, hand, options),
        "seen": SEEN_TERMS[contact.seen.sum(axis=1).astype(int)],
    }


def _torque(
    contact: ContactTable,
    closing: NDArray[np.float64],
    centre: NDArray[np.float64],
    volume: NDArray[np.float64],
    up: NDArray[np.float64],
    hand: ParallelHand,
    options: JawOptions,
) -> NDArray[np.float64]:
    """Return the probability that the object turns neither about the closing axis nor across it.

    Across it, the pressure moves to one end of the contact. That happens at the rim of a vessel.
    """
    offset = centre - contact.middle
    lever = np.abs(np.einsum("ij,ij->i", np.cross(offset, up), closing))
    level = closing - (closing @ up)[:, None] * up
    across = np.abs(np.einsum("ij,ij->i", offset, level))
    force = min(LIKELY_FORCE, hand.force[1])
    radius = PAD_RADIUS_SHARE * min(hand.pad_width, hand.pad_height)
    # Without friction the contact resists no torque, and the quotient below must stay finite.
    capacity = max(2.0 * options.friction * force * radius, MIN_CAPACITY)
    bending = across / (force * (contact.overlap + SAMPLE_SPACING))
    load = DENSITY * volume * GRAVITY * np.hypot(lever / capacity, bending)
    return expit((1.0 - load) / 0.25) * np.exp(-0.5 * (lever / LEVER_SCALE) ** 2)


def rejected_terms(
    scored: ScoredCandidates, surface: ObjectSurface, hand: ParallelHand
) -> NDArray[np.float64]:
    """Return the terms of candidates of an object whose solid the fit rejected, (n,)."""
    term = np.full(len(scored.candidates), REJECTED_TERM)
    readings = surface.points[: surface.measured]
    poses = zip(scored.candidates.tip, scored.candidates.rotation, strict=True)
    for number, (tip, rotation) in enumerate(poses):
        x, y, z = ((readings - tip) @ rotation).T
        between = np.abs(x) <= 0.5 * scored.contact.width[number] + BESIDE_PAD
        between &= (np.abs(y) <= 0.5 * hand.pad_width) & (z <= 0.0) & (z >= -hand.pad_height)
        if np.count_nonzero(between) < MIN_READINGS:
            term[number] = BRIDGED_TERM
    return term


def overhang_term(
    contact: ContactTable,
    closing: NDArray[np.float64],
    up: NDArray[np.float64],
    options: JawOptions,
) -> NDArray[np.float64]:
    """Return the probability that sides that face down and were not seen hold the object, (n,).

    The hidden side of an object that stands alone is rather upright.
    """
    sine = np.outer(closing @ up, [-1.0, 1.0])
    overhangs = (sine > 0.0) & (contact.seen == 0.0)
    angle = np.arcsin(np.clip(sine, 0.0, 1.0))
    holds = ndtr((np.arctan(options.friction) - angle) / TILT_SIGMA)
    return np.where(overhangs, 1.0 - UPRIGHT * (1.0 - holds), 1.0).prod(axis=1)


def clearance_terms(
    clearance: NDArray[np.float64], options: JawOptions
) -> dict[str, NDArray[np.float64]]:
    """Return the probability that the hand touches neither the object early, nor others, (n,).

    Parameters
    ----------
    clearance
        Clearance from the own object and from others, (n, 2), m.
    options
        Options; the calibration error counts.
    """
    free = ndtr((clearance + TOUCH_ALLOWANCE) / _clearance_sigma(options))
    return {"own_clearance": free[:, 0], "clearance": free[:, 1]}


def clearance_for(probability: NDArray[np.float64], options: JawOptions) -> NDArray[np.float64]:
    """Return the clearance with a probability (n,) of touching nothing, (n,), m."""
    return _clearance_sigma(options) * ndtri(probability) - TOUCH_ALLOWANCE


def _clearance_sigma(options: JawOptions) -> float:
    return float(np.hypot(CLEARANCE_SIGMA, options.calibration_error))
