"""Fingertips tell the face that holds from a bump beside it."""

import numpy as np
import pytest

from eyehand.data_synth.cell.fingertip_pads import tip_array
from eyehand.grasping.fingertips import fingertip_contacts, off_face_contacts
from eyehand.grasping.robot import HandReading
from eyehand.tactile import TactileImage

from .fake_robot import HAND


def reading(finger: str, force: float, on_face: float) -> HandReading:
    """One finger's tip feels a force, a part of it on its tactels."""
    forces = np.zeros(len(HAND.pads))
    forces[HAND.pads.index(f"{finger}_distal")] = force
    array = tip_array()
    images = []
    for name in HAND.fingers:
        pressures = np.zeros(len(array.positions))
        if name == finger:
            pressures[4:8] = on_face / (4 * array.area)
        images.append(TactileImage(pressures, array))
    still = np.zeros(len(HAND.drives))
    return HandReading(still, still, np.zeros(len(HAND.joints)), forces, tuple(images))


@pytest.mark.parametrize("finger", HAND.fingers)
def test_a_bump_on_a_tips_end_is_told_from_a_contact_on_its_face(finger):
    assert off_face_contacts(reading(finger, 3.0, 0.0), HAND, 0.6) == (finger,)
    assert off_face_contacts(reading(finger, 3.0, 2.9), HAND, 0.6) == ()
    assert off_face_contacts(reading(finger, 0.3, 0.0), HAND, 0.6) == ()


def test_tips_without_tactels_cannot_tell():
    felt = reading("thumb", 3.0, 3.0)
    blind = HandReading(felt.excursions, felt.tensions, felt.angles, felt.forces, ())
    assert off_face_contacts(blind, HAND, 0.6) == ("thumb",)
    assert fingertip_contacts(blind) == ()


def test_contacts_on_faces_are_described():
    contacts = fingertip_contacts(reading("thumb", 3.0, 3.0))
    assert len(contacts) == len(HAND.fingers)
    assert contacts[-1].force == pytest.approx(3.0, rel=0.01)
    assert not any(contacts[:-1])
