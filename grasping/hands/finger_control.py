"""Commands and senses of a hand with fingers and a thumb that sense contact forces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from eyehand.tactile import ContactFeatures, contact_features

from ..prototypes import Prototype
from .closing import Closing, open_command, preshape_command
from .grip_options import GripOptions
from .hand_control import ClosingController, HeldState
from .hand_messages import AnyReading, HandCommand, HandReading
from .hand_model import HandModel
from .hand_names import TIP
from .hand_state import finger_curl, finger_reading, grip_width, is_holding

CONTACT_FORCE = 0.1
"""Force above which a pad counts as in contact with the held object, N."""

PRESSURE_THRESHOLD = 200.0
"""Pressure above which a tactel counts as touched, Pa; 5 mN on a tactel of 5 x 5 mm."""
FACE_SHARE = 0.5
"""Minimum share of a tip's force on its tactels for a contact on the gripping face. Otherwise the
contact is on the end or the back of the tip."""


@dataclass(frozen=True)
class FingerControl:
    """`HandControl` of a hand with fingers and a thumb."""

    model: HandModel
    """The hand."""

    @property
    def fingers(self) -> tuple[str, ...]:
        """Names of the fingers, the thumb last."""
        return self.model.fingers

    @property
    def max_opening(self) -> float:
        """Maximum opening, m."""
        return self.model.max_opening

    def reach(self, opening: float) -> float:
        """Return the distance of the fingertips from the palm along z at an opening, m."""
        return self.model.reach(opening)

    def half_width(self, opening: float) -> float:
        """Return half the width of the hand at an opening in m, m."""
        return 0.5 * max(self.model.outer_width(opening), self.model.row_width)

    def posture(self, opening: float, prototype: Prototype | None = None) -> NDArray[np.float64]:
        """Return the excursions (D,), m, at an opening in m, for `Robot.description`."""
        if prototype is None:
            return self.model.excursions_at(opening)
        return np.asarray(preshape_command(self.model, opening, prototype).values)

    def preshape(self, opening: float, prototype: Prototype) -> HandCommand:
        """Return the command of the pre-shape with an opening in m."""
        return preshape_command(self.model, opening, prototype)

    def opened(self) -> HandCommand:
        """Return the command that opens the hand fully."""
        return open_command(self.model)

    def closing(
        self, prototype: Prototype, opening: float, options: GripOptions
    ) -> ClosingController:
        """Return the controller that closes the hand from an opening in m."""
        return Closing(self.model, prototype, opening, options)

    def contacts(self, reading: AnyReading, min_force: float) -> tuple[str, ...]:
        """Return the names of the pads with a force above ``min_force``, N."""
        touched = finger_reading(reading).forces > min_force
        return tuple(np.array(self.model.pads)[touched].tolist())

    def touched_side(self, reading: AnyReading, min_force: float) -> float:
        """Return the touched side along x: 1 thumb, -1 fingers, 0 both or neither."""
        touched = self.contacts(reading, min_force)
        *fingers, thumb = self.model.fingers
        on_thumb = any(pad.startswith(thumb) for pad in touched)
        return float(on_thumb) - float(any(pad.startswith(tuple(fingers)) for pad in touched))

    def touches_outside(self, reading: AnyReading, min_force: float) -> bool:
        """Return whether a fingertip touches something beside its gripping face."""
        return bool(off_face_contacts(finger_reading(reading), self.model, min_force))

    def forces(self, reading: AnyReading) -> NDArray[np.float64]:
        """Return the force on each finger, then on the palm, (F + 1,), N."""
        force = np.zeros(len(self.fingers) + 1)
        np.add.at(force, self._finger_of_pad, finger_reading(reading).forces)
        return force

    def width(self, reading: AnyReading) -> float:
        """Return the distance between the pads of middle finger and thumb, m."""
        return grip_width(finger_reading(reading), self.model)

    def holds(self, reading: AnyReading) -> bool:
        """Return whether an object is between the fingers and the thumb or the palm."""
        return is_holding(finger_reading(reading), self.model)

    def held(self, reading: AnyReading) -> HeldState:
        """Return what the hand senses of the object that it holds."""
        hand = finger_reading(reading)
        pads = int((hand.forces > CONTACT_FORCE).sum())
        return HeldState(pads, finger_curl(hand, self.model), fingertip_contacts(hand))

    @cached_property
    def _finger_of_pad(self) -> NDArray[np.intp]:
        """Number of the finger of each pad, (P,); pads of the palm get ``len(fingers)``."""
        fingers = self.model.fingers
        return np.array(
            [
                next((k for k, name in enumerate(fingers) if pad.startswith(name)), len(fingers))
                for pad in self.model.pads
            ],
            dtype=np.intp,
        )


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
