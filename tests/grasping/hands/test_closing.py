"""Closing the hand: waiting at first contact, raising the force, detecting an empty hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.grasping.hands import GripOptions, HandModel, HandReading
from eyehand.grasping.hands.closing import Closing, preshape_command
from eyehand.grasping.hands.grip_options import MIN_TENSION_SHARE
from eyehand.grasping.hands.hand_state import finger_curl, grip_width, is_holding

DT = 0.004
FINGERS = ("index", "middle", "ring", "thumb")


@pytest.fixture
def hand():
    openings = np.linspace(0.0, 0.12, 13)
    pull = (0.12 - openings) * 0.08
    excursions = np.column_stack([2 * pull, pull, pull, 0 * pull, 0 * pull])
    joints = tuple(f"{f}_{k}" for f in FINGERS for k in (1, 2))
    return HandModel(
        drives=("outer", "middle", "thumb", "wrap", "thumb_wrap"),
        joints=joints,
        pads=(*(f"{f}_distal" for f in FINGERS), "palm_pad"),
        fingers=FINGERS,
        openings=openings,
        reaches=np.full(13, 0.1),
        excursions=excursions,
        outer_widths=openings + 0.03,
        row_width=0.09,
        pinch_width=0.03,
        thickness=0.012,
        palm_depth=0.06,
    )


def reading(hand, excursions, forces, angles=None):
    return HandReading(
        excursions=np.asarray(excursions, dtype=float),
        tensions=np.full(5, 8.0),
        angles=np.zeros(8) if angles is None else angles,
        forces=np.asarray(forces, dtype=float),
        tips=(),
    )


def test_side_with_first_contact_holds(hand):
    closing = Closing(hand, "precision", 0.08)
    start = hand.excursions_at(0.08)
    command = closing.step(reading(hand, start, [0, 0, 0, 2, 0]), DT)

    assert command.modes[2] == "hold"
    assert command.modes[0] == command.modes[1] == "position"
    assert command.values[1] > start[1]
    assert not closing.touched


def test_contact_on_both_sides_raises_tension_to_prototype_value(hand):
    closing = Closing(hand, "precision", 0.08)
    contact = reading(hand, hand.excursions_at(0.06), [1, 1, 1, 3, 0])
    command = closing.step(contact, DT)
    assert closing.touched
    levels = []
    for _ in range(250):
        command = closing.step(contact, DT)
        levels.append(command.values[1])

    assert closing.state == "holding"
    assert (np.diff(levels) >= 0).all()
    assert levels[-1] == pytest.approx(70.0)
    assert command.modes[2] == "hold"
    assert command.values[2] >= 3 * 70.0


def test_closing_without_object_ends_empty(hand):
    closing = Closing(hand, "pincer", 0.04)
    closed = hand.excursions[0] * 1.02
    closing.step(reading(hand, closed, [0, 3, 0, 3, 0]), DT)

    assert closing.state == "empty"


def test_slipping_object_ends_empty(hand):
    closing = Closing(hand, "precision", 0.08)
    contact = reading(hand, hand.excursions_at(0.06), [1, 1, 1, 3, 0])
    for _ in range(250):
        closing.step(contact, DT)
    for _ in range(60):
        closing.step(reading(hand, hand.excursions_at(0.0), [0, 0, 0, 0, 0]), DT)

    assert closing.state == "empty"


def test_pincer_keeps_outer_fingers_open(hand):
    command = preshape_command(hand, 0.04, "pincer")
    aside = command.values[0]
    assert aside < hand.excursions_at(0.08)[0]
    closing = Closing(hand, "pincer", 0.04)
    for _ in range(20):
        command = closing.step(reading(hand, hand.excursions_at(0.04), [0, 0, 0, 0, 0]), DT)

    assert command.values[0] == aside
    assert command.values[1] > hand.excursions_at(0.04)[1]


def test_grip_width_and_finger_curl_from_reading(hand):
    contact = reading(hand, hand.excursions_at(0.05), [1, 1, 1, 3, 0], np.tile([0.2, 0.4], 4))

    assert grip_width(contact, hand) == pytest.approx(0.05, abs=1e-6)
    assert finger_curl(contact, hand) == pytest.approx(0.4)
    assert is_holding(contact, hand)


def test_finger_past_thumb_is_not_holding(hand):
    # The palm pad stands for all phalanges that are not fingertips.
    between = reading(hand, hand.excursions_at(0.02), [0, 3, 0, 0, 3])
    crossed = reading(hand, hand.excursions[0] * 1.2, [0, 3, 0, 0, 3])
    bent = np.tile([0.2, 1.4], 4)
    wrapped = reading(hand, hand.excursions[0] * 1.2, [0, 3, 0, 0, 3], bent)

    assert is_holding(between, hand)
    assert grip_width(crossed, hand) < -0.005
    assert not is_holding(crossed, hand)
    assert is_holding(wrapped, hand)


def test_fist_pressing_on_own_palm_is_not_holding(hand):
    # Index and ring finger press on the palm, the middle fingertip on the thumb's.
    fist = [7, 9, 7, 9, 15]
    excursions = hand.excursions_at(0.02)
    empty = reading(hand, excursions, fist, np.array([0.5, 2.2, -0.6, 2.2, 0.5, 2.2, 0.0, 1.3]))
    around = reading(hand, excursions, fist, np.array([0.1, 1.5, 0.1, 1.5, 0.1, 1.5, 0.0, 0.7]))
    beside = reading(hand, excursions, fist, np.array([0.5, 2.2, 0.1, 1.5, 0.1, 1.5, 0.0, 0.7]))

    assert not is_holding(empty, hand)
    assert is_holding(around, hand)
    assert is_holding(beside, hand)


def test_impact_tension_is_limited_to_grip_tension(hand):
    closing = Closing(hand, "pincer", 0.04, GripOptions(load=0.01))
    shocked = replace(
        reading(hand, hand.excursions_at(0.03), [0, 2, 0, 2, 0]), tensions=np.full(5, 55.0)
    )
    commands = [closing.step(shocked, DT) for _ in range(50)]

    middle, thumb = commands[-1].values[1:3]
    assert middle <= closing.grip_tension < 55.0
    assert thumb > middle


def test_tension_decreases_with_load_within_limits():
    full = GripOptions().finger_tension("precision", 3)
    light = GripOptions(load=0.05).finger_tension("precision", 3)

    assert light < full
    assert GripOptions(load=5.0).finger_tension("precision", 3) == full
    assert light >= MIN_TENSION_SHARE * full


def test_invalid_options_are_rejected():
    with pytest.raises(InputError, match="closing_speed"):
        GripOptions(closing_speed=0.0)
    with pytest.raises(InputError, match="prototype"):
        Closing(None, "fist", 0.05)  # pyright: ignore[reportArgumentType]
