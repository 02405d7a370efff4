"""Contacts on the fingertips, and on which face they are."""

from __future__ import annotations

from eyehand.tactile import ContactFeatures, contact_features

from .hand_messages import HandReading
from .hand_model import HandModel
from .hand_names import TIP

PRESSURE_THRESHOLD = 200.0
"""Pressure above which a tactel counts as touched, Pa; 5 mN on a tactel of 5 x 5 mm."""
FACE_SHARE = 0.5
"""Minimum share of a tip's force on its tactels for a contact on the gripping face. Otherwise the
contact is on the end or the back of the tip."""


def fingertip_contacts(reading: HandReading) -> tuple[ContactFeatures, ...]:
    """Return the contact on each fingertip, the thumb last; empty without tactile sensors."""
    return tuple(contact_features(image, PRESSURE_THRESHOLD) for image in reading.tips)


def off_face_contacts(reading: HandReading, hand: HandModel, min_force: float) -> tuple[str, ...]:
    """Return the names of the fingers with a contact beside the gripping face of their tip.

    Only contacts of at least ``min_force``, N, count. A contact on a tip without tactile sensor
    always counts.
    """
    forces = dict(zip(hand.pads, reading.forces.tolist(), strict=True))
    images = dict(zip(hand.fingers, reading.tips, strict=False))
    fingers = []
    for finger in hand.fingers:
        force = forces.get(f"{finger}_{TIP}", 0.0)
        if force < min_force:
            continue
        image = images.get(finger)
        on_face = contact_features(image, PRESSURE_THRESHOLD).force if image is not None else 0.0
        if on_face < FACE_SHARE * force:
            fingers.append(finger)
    return tuple(fingers)
