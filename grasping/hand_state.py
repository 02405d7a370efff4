"""What is in the hand, by what the hand feels: its width, its bend, whether it is held."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .hand_names import PALM, PINCER_FINGER, THUMB, TIP, WRAPS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .hand_model import HandModel
    from .robot import HandReading

CLOSED_WIDTH = 0.002
CLOSED_BEND = 1.0
"""Where only tips feel force, a hand closed on itself shows by its width, m; one whose middle
finger is bent more than this, rad, is wrapped, and closes on itself sooner."""
CROSSED_WIDTH = -0.005
"""Straight fingers past this width, m, have gone through where anything could be, and press on the
thumb's inner phalanx."""
LEAST_WRAPPED = 0.015
"""Nothing that a power grasp is meant for is slimmer, m: there the tips meet before they touch."""
OWN_PALM_CURL = 2.4
"""A finger curled further, rad, that feels at its tip alone has it on the own palm: 2.8 empty, 1.6
around 60 mm; longer fingers curl as far around what their inner phalanges feel. Such is most of a
hand closed on nothing, or one finger while the thumb feels nothing."""


def curl(reading: HandReading, hand: HandModel) -> float:
    """How far the fingers bend around: the sum of a finger's outer joints, their mean, rad.

    The thumb does not count: it opposes.
    """
    return float(np.mean([_bend(reading, hand, finger) for finger in hand.fingers[:-1]]))


def width(reading: HandReading, hand: HandModel) -> float:
    """Free width between the middle finger's pad and the thumb's by the tendons' excursions, m.

    True to some mm as long as the outer joints are not bent by contact; below 0 beyond closed.
    """
    halves = {
        name: _half(hand, k, reading.excursions[k])
        for k, name in enumerate(hand.drives)
        if name not in WRAPS
    }
    thumb = halves.pop(THUMB)
    finger = halves.get(PINCER_FINGER, max(halves.values()))
    return finger + thumb


def held(reading: HandReading, hand: HandModel, least: float = 0.2) -> bool:
    """Whether something is between the fingers and thumb or palm: both sides feel force, in N.

    A hand closed on itself feels force too; that shows in its joints.
    """
    forces = finger_forces(reading, hand)
    against = forces[-1] + inner_force(reading, hand, PALM)
    if forces[:-1].max() < least or against < least:
        return False
    palm, inner = inner_force(reading, hand, PALM), inner_force(reading, hand)
    fingers = hand.fingers[:-1]
    on_palm = {
        one
        for one in fingers
        if _curled(reading, hand, one) > OWN_PALM_CURL and inner_force(reading, hand, one) < least
    }
    if 2 * len(on_palm) > len(fingers):
        return False
    if inner - palm < least and forces[-1] < least and PINCER_FINGER in on_palm:
        return False
    bent = _bend(reading, hand, PINCER_FINGER) > CLOSED_BEND
    if inner >= least:
        return bent or width(reading, hand) > CROSSED_WIDTH
    return width(reading, hand) > (LEAST_WRAPPED if bent else CLOSED_WIDTH)


def finger_forces(reading: HandReading, hand: HandModel) -> NDArray[np.float64]:
    """Force on each finger, the thumb last, N."""
    return np.array(
        [
            sum(f for f, pad in zip(reading.forces, hand.pads, strict=True) if pad.startswith(name))
            for name in hand.fingers
        ]
    )


def inner_force(reading: HandReading, hand: HandModel, name: str = "") -> float:
    """Force on pads that do not meet one another when the hand closes on nothing, N.

    Of all pads, or of those whose names begin so.
    """
    pads = zip(reading.forces, hand.pads, strict=True)
    return float(sum(f for f, pad in pads if pad.startswith(name) and not pad.endswith(TIP)))


def _bend(reading: HandReading, hand: HandModel, finger: str) -> float:
    """Sum of a finger's joints past the first, rad."""
    joints = [k for k, name in enumerate(hand.joints) if name.startswith(finger)]
    return float(reading.angles[joints[1:]].sum())


def _curled(reading: HandReading, hand: HandModel, finger: str) -> float:
    """Sum of all joints of a finger, rad."""
    joints = [k for k, name in enumerate(hand.joints) if name.startswith(finger)]
    return float(reading.angles[joints].sum())


def _half(hand: HandModel, drive: int, excursion: float) -> float:
    """Half the width that an excursion makes, extended straight on beyond the closed hand."""
    pulled, halves = hand.excursions[::-1, drive], hand.openings[::-1] / 2
    if excursion > pulled[-1]:
        slope = (halves[-1] - halves[-4]) / (pulled[-1] - pulled[-4])
        return float(halves[-1] + slope * (excursion - pulled[-1]))
    return float(np.interp(excursion, pulled, halves))
