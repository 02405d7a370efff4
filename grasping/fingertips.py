"""What fingertips feel: a contact on the face that holds, or a bump beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.tactile import contact_features

from .hand_names import TIP

if TYPE_CHECKING:
    from eyehand.tactile import ContactFeatures

    from .hand_model import HandModel
    from .robot import HandReading

THRESHOLD = 200.0
"""Pressure above which a tactel counts as touched, Pa: 5 mN on one of 5 x 5 mm."""
FACE_SHARE = 0.5
"""Share of a tip's force that its tactels bear where it is the holding face that touches: the rest
is on its end or back."""


def fingertip_contacts(reading: HandReading) -> tuple[ContactFeatures, ...]:
    """Describe the contact on each fingertip, the thumb last; empty for a hand without tactels."""
    return tuple(contact_features(image, THRESHOLD) for image in reading.tips)


def bumped_tips(reading: HandReading, hand: HandModel, least: float) -> tuple[str, ...]:
    """Name the fingertips that feel at least a force, N, beside the face that holds.

    A tip without tactels cannot tell, and counts as bumped.
    """
    forces = dict(zip(hand.pads, reading.forces.tolist(), strict=True))
    faces = dict(zip(hand.fingers, reading.tips, strict=False))
    bumped = []
    for finger in hand.fingers:
        force = forces.get(f"{finger}_{TIP}", 0.0)
        if force < least:
            continue
        image = faces.get(finger)
        on_face = contact_features(image, THRESHOLD).force if image is not None else 0.0
        if on_face < FACE_SHARE * force:
            bumped.append(finger)
    return tuple(bumped)
