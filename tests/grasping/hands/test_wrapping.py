"""Stages of a power grasp: draw the object to the palm, tighten, wrapped."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from eyehand.grasping.hands import GripOptions
from eyehand.grasping.hands.wrapping import DRAW_TENSION, Wrapping

DT = 0.004
GOAL = 90.0
DRIVES = ("outer", "middle", "thumb", "wrap", "thumb_wrap")
FINGERS = [0, 1]
SLACK = np.array([12.0, 12.0, 12.0, 0.0, 0.0])


@pytest.fixture
def hand():
    return SimpleNamespace(
        drives=DRIVES,
        pads=("index_distal", "thumb_distal", "palm_pad"),
        fingers=("index", "middle", "ring", "thumb"),
    )


def reading(palm):
    return SimpleNamespace(forces=np.array([3.0, 3.0, palm]))


def run(wrapping, palm, seconds, level=0.0, *, steady=True):
    for _ in range(int(seconds / DT)):
        level = min(level + 200.0 * DT, max(wrapping.limit, level))
        wrapping.step(reading(palm), level, steady, DT)
    return level


def test_object_on_palm_is_tightened_without_drawing(hand):
    wrapping = Wrapping(hand, GripOptions(), GOAL, SLACK)
    run(wrapping, 1.0, 0.02)

    assert wrapping.stage == "tighten"
    assert wrapping.bend(3) == 0.0
    run(wrapping, 1.0, 1.0, GOAL)
    assert wrapping.stage == "wrapped"


def test_object_is_drawn_until_palm_contact_then_unbent(hand):
    wrapping = Wrapping(hand, GripOptions(), GOAL, SLACK)
    level = run(wrapping, 0.0, 0.3)
    assert wrapping.stage == "draw"
    assert wrapping.limit < 0.5 * GOAL
    assert wrapping.bend(3) == wrapping.bend(4) == DRAW_TENSION
    level = run(wrapping, 2.0, 0.3, level)

    assert wrapping.stage == "tighten"
    run(wrapping, 2.0, 1.0, level)
    assert wrapping.stage == "wrapped"
    assert wrapping.bend(3) == 0.0


def test_object_that_never_reaches_palm_stays_hooked(hand):
    wrapping = Wrapping(hand, GripOptions(), GOAL, SLACK)
    level = run(wrapping, 0.0, 0.6, steady=False)
    assert wrapping.stage == "tighten"
    assert wrapping.thumb(level, FINGERS)[0] == "hold"
    run(wrapping, 0.0, 3.0, level, steady=False)

    assert wrapping.stage == "wrapped"
    assert wrapping.bend(3) == DRAW_TENSION


def test_thumb_tension_follows_sum_of_fingers_then_holds(hand):
    wrapping = Wrapping(hand, GripOptions(), GOAL, SLACK)
    run(wrapping, 1.0, 0.02)

    assert wrapping.thumb(12.0, FINGERS) == ("pull", 12.0)
    assert wrapping.thumb(30.0, FINGERS) == ("pull", 12.0 + 3 * 18.0)
    run(wrapping, 1.0, 1.0, GOAL)
    mode, tension = wrapping.thumb(GOAL, FINGERS)
    assert mode == "hold"
    assert tension > 3 * GOAL
