"""Estimate the state of a grasp from the hand's readings: width, curl, whether it holds an object.

The curl of a finger is the sum of its joint angles without the first joint. Its total bend is the
sum of all its joint angles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .hand_messages import AnyReading, HandReading
from .hand_model import HandModel
from .hand_names import PALM, PINCER_FINGER, THUMB, TIP, WRAP_DRIVES

EMPTY_WIDTH = 0.002
"""Maximum grip width of an empty hand with straight fingers, m. Only the fingertips of such a hand
feel a force."""
ENCLOSING_CURL = 1.0
"""Curl of the middle finger above which the hand encloses the object, rad. Such a hand is empty up
to a larger width, `MIN_ENCLOSED_WIDTH`."""
MIN_ENCLOSED_WIDTH = 0.015
"""Minimum width of an object in a power grasp, m. Thinner objects cannot be enclosed, because the
fingertips meet first."""
CROSSED_WIDTH = -0.005
"""Width below which straight fingers have crossed the thumb and press on its inner phalanx, m. See
`grip_width` for negative widths."""
OWN_PALM_BEND = 2.4
"""Total bend above which a finger presses on the palm of its own hand, rad, if only its tip feels a
force. An empty hand reaches 2.8, a hand around a 60 mm object 1.6. Long fingers also exceed it
around an object, but then their inner phalanges feel a force."""


def finger_curl(reading: HandReading, hand: HandModel) -> float:
    """Return the mean curl of the fingers without the thumb, rad."""
    return float(np.mean([_curl(reading, hand, finger) for finger in hand.fingers[:-1]]))


def grip_width(reading: HandReading, hand: HandModel) -> float:
    """Estimate the distance between the pads of middle finger and thumb from the excursions, m.

    It is accurate to a few mm while contact does not bend the outer joints. It is negative if the
    tendons are pulled farther than in the closed empty hand. In a hand without a middle finger,
    the finger with the maximum opening counts.
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
    its joint angles differ from those of a grasp.
    """
    forces = finger_forces(reading, hand)
    palm, inner = non_tip_force(reading, hand, PALM), non_tip_force(reading, hand)
    if forces[:-1].max() < min_force or forces[-1] + palm < min_force:
        return False
    fingers = hand.fingers[:-1]
    on_palm = {
        finger
        for finger in fingers
        if _total_bend(reading, hand, finger) > OWN_PALM_BEND
        and non_tip_force(reading, hand, finger) < min_force
    }
    # Most fingers press on the palm: the hand is empty.
    if 2 * len(on_palm) > len(fingers):
        return False
    # The middle finger presses on the palm. Neither the thumb nor an inner phalanx feels a force.
    if inner - palm < min_force and forces[-1] < min_force and PINCER_FINGER in on_palm:
        return False
    encloses = _curl(reading, hand, PINCER_FINGER) > ENCLOSING_CURL
    # A force on an inner phalanx or the palm needs an object, unless the fingers crossed the thumb.
    if inner >= min_force:
        return encloses or grip_width(reading, hand) > CROSSED_WIDTH
    # Only fingertips feel a force. They touch each other unless there is space between them.
    return grip_width(reading, hand) > (MIN_ENCLOSED_WIDTH if encloses else EMPTY_WIDTH)


def finger_forces(reading: HandReading, hand: HandModel) -> NDArray[np.float64]:
    """Return the force on each finger, (F,), N, the thumb last."""
    return np.array(
        [
            sum(f for f, pad in zip(reading.forces, hand.pads, strict=True) if pad.startswith(name))
            for name in hand.fingers
        ]
    )


def non_tip_force(reading: HandReading, hand: HandModel, prefix: str = "") -> float:
    """Return the force on all pads except the fingertips, N.

    These pads do not touch each other in a closed empty hand, unlike the fingertips. Only pads
    whose names begin with ``prefix`` count.
    """
    pads = zip(reading.forces, hand.pads, strict=True)
    return float(sum(f for f, pad in pads if pad.startswith(prefix) and not pad.endswith(TIP)))


def _curl(reading: HandReading, hand: HandModel, finger: str) -> float:
    """Return the sum of a finger's joint angles without the first joint, rad."""
    joints = [k for k, name in enumerate(hand.joints) if name.startswith(finger)]
    return float(reading.angles[joints[1:]].sum())


def _total_bend(reading: HandReading, hand: HandModel, finger: str) -> float:
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


def finger_reading(reading: AnyReading) -> HandReading:
    """Return the reading of a hand with fingers.

    Raises
    ------
    InputError
        If it is that of a gripper with two jaws.
    """
    if not isinstance(reading, HandReading):
        raise InputError(
            "the reading of a hand with fingers must be a HandReading, got "
            f"{type(reading).__name__}"
        )
    return reading
