"""Estimate from the hand's readings what it holds: width, curl, and whether it holds anything."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .hand_names import PALM, PINCER_FINGER, THUMB, TIP, WRAP_DRIVES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .hand_messages import HandReading
    from .hand_model import HandModel

EMPTY_WIDTH = 0.002
"""Width up to which a hand with forces at its tips only has closed on itself, m."""
ENCLOSING_BEND = 1.0
"""Bend of the middle finger above which the hand encloses the object, rad. Such a hand closes on
itself at a larger width, `MIN_ENCLOSED_WIDTH`."""
MIN_ENCLOSED_WIDTH = 0.015
"""Minimum width of an object in a power grasp, m. Below it the tips meet first."""
CROSSED_WIDTH = -0.005
"""Width below which straight fingers have crossed the thumb and press on its inner phalanx, m."""
OWN_PALM_CURL = 2.4
"""Curl above which a finger with force at its tip only presses on the own palm, rad. An empty hand
reaches 2.8, a hand around 60 mm reaches 1.6. Longer fingers curl as far around objects that their
inner phalanges feel."""


def finger_curl(reading: HandReading, hand: HandModel) -> float:
    """Return the curl of the fingers, rad: the sum of a finger's outer joints, averaged.

    The thumb is excluded, because it opposes the fingers.
    """
    return float(np.mean([_bend(reading, hand, finger) for finger in hand.fingers[:-1]]))


def grip_width(reading: HandReading, hand: HandModel) -> float:
    """Return the distance between the pads of middle finger and thumb, m, from the excursions.

    It is accurate to a few mm while contact does not bend the outer joints. Beyond the closed hand
    it is negative.
    """
    halves = {
        name: _half_width(hand, k, reading.excursions[k])
        for k, name in enumerate(hand.drives)
        if name not in WRAP_DRIVES
    }
    thumb = halves.pop(THUMB)
    finger = halves.get(PINCER_FINGER, max(halves.values()))
    return finger + thumb


def is_holding(reading: HandReading, hand: HandModel, min_force: float = 0.2) -> bool:
    """Return whether an object is between the fingers and the thumb or the palm.

    Both sides must feel ``min_force``, N. A hand that closed on itself feels forces as well, but
    its joints show it.
    """
    forces = finger_forces(reading, hand)
    palm, inner = inner_force(reading, hand, PALM), inner_force(reading, hand)
    if forces[:-1].max() < min_force or forces[-1] + palm < min_force:
        return False
    fingers = hand.fingers[:-1]
    on_palm = {
        finger
        for finger in fingers
        if _curl(reading, hand, finger) > OWN_PALM_CURL
        and inner_force(reading, hand, finger) < min_force
    }
    if 2 * len(on_palm) > len(fingers):
        return False
    if inner - palm < min_force and forces[-1] < min_force and PINCER_FINGER in on_palm:
        return False
    encloses = _bend(reading, hand, PINCER_FINGER) > ENCLOSING_BEND
    if inner >= min_force:
        return encloses or grip_width(reading, hand) > CROSSED_WIDTH
    return grip_width(reading, hand) > (MIN_ENCLOSED_WIDTH if encloses else EMPTY_WIDTH)


def finger_forces(reading: HandReading, hand: HandModel) -> NDArray[np.float64]:
    """Return the force on each finger, (F,), N, the thumb last."""
    return np.array(
        [
            sum(f for f, pad in zip(reading.forces, hand.pads, strict=True) if pad.startswith(name))
            for name in hand.fingers
        ]
    )


def inner_force(reading: HandReading, hand: HandModel, prefix: str = "") -> float:
    """Return the force on all pads except the fingertips, N; those do not meet when empty.

    Only pads whose names begin with ``prefix`` count.
    """
    pads = zip(reading.forces, hand.pads, strict=True)
    return float(sum(f for f, pad in pads if pad.startswith(prefix) and not pad.endswith(TIP)))


def _bend(reading: HandReading, hand: HandModel, finger: str) -> float:
    """Return the sum of a finger's joint angles without the first joint, rad."""
    joints = [k for k, name in enumerate(hand.joints) if name.startswith(finger)]
    return float(reading.angles[joints[1:]].sum())


def _curl(reading: HandReading, hand: HandModel, finger: str) -> float:
    """Return the sum of a finger's joint angles, rad."""
    joints = [k for k, name in enumerate(hand.joints) if name.startswith(finger)]
    return float(reading.angles[joints].sum())


def _half_width(hand: HandModel, drive: int, excursion: float) -> float:
    """Return half the opening at a drive's excursion, extrapolated beyond the closed hand, m."""
    excursions, halves = hand.excursions[::-1, drive], hand.openings[::-1] / 2
    if excursion > excursions[-1]:
        slope = (halves[-1] - halves[-4]) / (excursions[-1] - excursions[-4])
        return float(halves[-1] + slope * (excursion - excursions[-1]))
    return float(np.interp(excursion, excursions, halves))
