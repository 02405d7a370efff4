"""Travel of the hand until it touches an object or the support."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.grasping import load_hand
from eyehand.grasping.jaws.candidates import Candidates
from eyehand.grasping.jaws.free_travel import free_travel
from eyehand.grasping.jaws.grasp import APPROACH
from eyehand.grasping.jaws.point_blocks import point_blocks
from eyehand.perception import SupportPlane

PANDA = load_hand("panda")
TABLE = SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)


def travel(height: float, points: np.ndarray, beyond: float = 0.0) -> float:
    """Return the travel of a hand from above whose goal has a height, m."""
    down = np.diag([1.0, -1.0, -1.0])[None]
    goal = Candidates(
        np.ascontiguousarray(down),
        np.array([[0.0, 0.0, height]]),
        np.zeros(1, int),
        np.full(1, np.inf),
    )
    blocks = point_blocks([points], [0])
    return float(free_travel(goal, np.array([PANDA.stroke]), blocks, TABLE, PANDA, beyond)[0])


def test_nothing_stops_the_hand_above_the_table():
    assert travel(0.01, np.zeros((0, 3))) == APPROACH


def test_table_stops_the_fingertips():
    assert travel(-0.02, np.zeros((0, 3))) == pytest.approx(APPROACH - 0.02)


def test_hand_that_goes_on_stops_at_the_table():
    assert travel(0.03, np.zeros((0, 3)), beyond=0.02) == pytest.approx(APPROACH + 0.02)
    assert travel(0.01, np.zeros((0, 3)), beyond=0.02) == pytest.approx(APPROACH + 0.01)


def test_plate_stops_the_fingertips():
    grid = np.stack(np.meshgrid(np.linspace(-0.1, 0.1, 41), np.linspace(-0.05, 0.05, 21)), -1)
    plate = np.column_stack([grid.reshape(-1, 2), np.full(41 * 21, 0.03)])
    assert travel(0.02, plate) == pytest.approx(APPROACH - 0.01)
    assert travel(-0.03, plate) == -1.0


def test_post_between_the_pads_stops_the_palm():
    post = np.column_stack([np.zeros((50, 2)), np.linspace(0.0, 0.1, 50)])
    expected = APPROACH - (0.08 + max(box.high[2] for box in PANDA.palm_boxes))
    assert travel(0.02, post) == pytest.approx(expected, abs=0.003)
