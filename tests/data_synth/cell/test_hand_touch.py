"""The touch of a simulated hand through a sensor model: wait, memory, drift, gains, and shear."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from eyehand.data_synth.cell.fingertip_pads import COLUMNS, ROWS, FingertipPads, tip_array
from eyehand.data_synth.cell.hand_touch import HandTouch
from eyehand.data_synth.pad import SENSORS
from eyehand.errors import InputError
from eyehand.grasping import HandReading, load_hand
from eyehand.grasping.hands import nominal_hand

HAND = nominal_hand()
TIPS = [pad for pad in HAND.pads if pad.endswith("_distal")]
PERIOD = 0.004


class Presses(FingertipPads):
    """Fingertips that all bear one force in the middle, as the array sees it."""

    def __init__(self, force: float) -> None:
        row = np.zeros(ROWS * COLUMNS)
        row[[4, 7]] = 0.5 * force / tip_array().area
        self.images = np.tile(row, (len(TIPS), 1))

    def pressures(self, data: object, shear: float = 0.0) -> np.ndarray:
        """Return the images, (T, 12), Pa."""
        return self.images


def sense(touch: HandTouch, force: float, start: float, seconds: float) -> np.ndarray:
    """Press all tips with a force, N, and return the forces of the pads at each image."""
    zeros = np.zeros(len(HAND.drives))
    forces = np.array([force if pad in TIPS else 0.0 for pad in HAND.pads])
    exact = HandReading(zeros, zeros, np.zeros(len(HAND.joints)), forces, ())
    rows = []
    for time in start + PERIOD * np.arange(1, round(seconds / PERIOD) + 1):
        touch.sense(exact, SimpleNamespace(time=time), Presses(force))
        rows.append(touch.touched(exact).forces)
    return np.array(rows)


def test_real_pads_read_a_press_late_and_forget_it():
    touch = HandTouch(SENSORS["real"], HAND, TIPS, seed=1)
    assert not sense(touch, 0.0, 0.0, 0.2).any()
    tips = [HAND.pads.index(tip) for tip in TIPS]
    pressed = sense(touch, 5.0, 0.2, 1.0)
    assert not pressed[0].any(), "the image waits for 8 ms"
    assert np.all(abs(pressed[-1, tips] / 5.0 - 1.0) < 0.3)
    assert pressed[:, tips[0]].std() > 0.0
    # Without the filter, a tenth of the 5 N would remain.
    assert sense(touch, 0.0, 1.2, 0.1)[-1].max() < 0.1


def test_the_creep_of_a_long_grip_is_no_contact_after_it():
    touch = HandTouch(SENSORS["harsh"], HAND, TIPS, seed=4)
    sense(touch, 12.0, 0.0, 6.0)
    # Without the filter of the creep, up to 0.7 N remain after 3 s; 0.6 N end an approach.
    assert sense(touch, 0.0, 6.0, 4.0)[25:].max() < 0.3


def test_an_eased_grip_is_still_felt():
    touch = HandTouch(SENSORS["harsh"], HAND, TIPS, seed=5)
    sense(touch, 6.0, 0.0, 0.5)
    eased = sense(touch, 0.8, 0.5, 1.0)[50:, [HAND.pads.index(tip) for tip in TIPS]]
    assert eased.min() > 0.2, "a force of 0.8 N is above the memory of 6 N"


def test_the_driver_removes_drift():
    touch = HandTouch(replace(SENSORS["real"], drift=6.0), HAND, TIPS, seed=2)
    read = [sense(touch, 0.0, second, PERIOD)[-1] for second in np.arange(0.0, 240.0, 0.08)]
    # 24 counts of drift are 6 standard deviations of the noise.
    assert np.mean(np.array(read[-500:]) > 0.0) < 0.02


def test_a_force_beside_the_array_loads_the_pad_alone():
    touch = HandTouch(SENSORS["ideal"], HAND, TIPS, seed=3)
    zeros = np.zeros(len(HAND.drives))
    forces = np.full(len(HAND.pads), 2.0)
    exact = HandReading(zeros, zeros, np.zeros(len(HAND.joints)), forces, ())
    touch.sense(exact, SimpleNamespace(time=0.0), Presses(0.0))
    felt = touch.touched(exact)
    assert np.allclose(felt.forces, 2.0, rtol=0.05)
    assert not np.any([tip.pressures for tip in felt.tips])


def test_jaws_have_no_sensor_model():
    with pytest.raises(InputError, match="needs a hand with fingers"):
        HandTouch(SENSORS["real"], load_hand("panda"), (), seed=0)
