"""Contacts on the tactile face of a fingertip, and contacts beside it."""

import numpy as np
import pytest

from eyehand.data_synth.cell.fingertip_pads import tip_array
from eyehand.grasping.hands import HandReading
from eyehand.grasping.hands.finger_control import fingertip_contacts, off_face_contacts
from eyehand.tactile import TactileImage

from ..fake_robot import HAND


def reading(finger: str, force: float, on_face: float) -> HandReading:
    """Return a reading with a force on one fingertip, and a part of it on the tactels."""
    forces = np.zeros(len(HAND.pads))
    forces[HAND.pads.index(f"{finger}_distal")] = force
    array = tip_array()
    images = []
    for name in HAND.fingers:
        pressures = np.zeros(len(array.positions))
        if name == finger:
            pressures[4:8] = on_face / (4 * array.area)
        images.append(TactileImage(pressures, array))
    zeros = np.zeros(len(HAND.drives))
    return HandReading(zeros, zeros, np.zeros(len(HAND.joints)), forces, tuple(images))


@pytest.mark.parametrize("finger", HAND.fingers)
def test_contact_beside_face_is_distinguished_from_contact_on_face(finger):
    assert off_face_contacts(reading(finger, 3.0, 0.0), HAND, 0.6) == (finger,)
    assert off_face_contacts(reading(finger, 3.0, 2.9), HAND, 0.6) == ()
    assert off_face_contacts(reading(finger, 0.3, 0.0), HAND, 0.6) == ()


def test_tips_without_tactels_count_as_off_face():
    contact = reading("thumb", 3.0, 3.0)
    without_tips = HandReading(
        contact.excursions, contact.tensions, contact.angles, contact.forces, ()
    )
    assert off_face_contacts(without_tips, HAND, 0.6) == ("thumb",)
    assert fingertip_contacts(without_tips) == ()


def test_fingertip_contacts_give_force():
    contacts = fingertip_contacts(reading("thumb", 3.0, 3.0))
    assert len(contacts) == len(HAND.fingers)
    assert contacts[-1].force == pytest.approx(3.0, rel=0.01)
    assert not any(contacts[:-1])
