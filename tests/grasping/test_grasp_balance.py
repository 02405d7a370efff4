"""Grasp quality as a task: the residual of the contacts, and the motion that removes it."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.control import solve_stack
from eyehand.grasping.cell import Cell
from eyehand.grasping.grasp_balance import MAX_SHIFT, balance_error, balance_tasks
from eyehand.grasping.hands import GripOptions, HandReading
from eyehand.grasping.hands.closing import Closing
from eyehand.grasping.robot import RobotReading
from eyehand.grasping.tray import Tray

from .fake_robot import HAND, PERIOD, FakeRobot

WIDTH = 0.05
ROW = HAND.row_offsets


def reading(forces=(1.0, 1.0, 1.0), turn=0.0) -> RobotReading:
    """Return fingers that touch a face turned by an angle, rad, with forces, N."""
    angles = np.zeros(len(HAND.joints))
    for row, finger in zip(ROW, HAND.fingers[:-1], strict=True):
        # Both links of a finger bend to the same angle from the palm's direction.
        first = next(k for k, name in enumerate(HAND.joints) if name.startswith(finger))
        angles[first] = -row * np.tan(turn) / HAND.reach(WIDTH)
    pads = dict(zip([f"{finger}_distal" for finger in HAND.fingers], [*forces, 3.0], strict=True))
    felt = np.array([pads.get(pad, 0.0) for pad in HAND.pads])
    hand = HandReading(HAND.excursions_at(WIDTH), np.zeros(len(HAND.drives)), angles, felt, ())
    return RobotReading(0.0, np.zeros(7), np.zeros(7), hand)


@pytest.mark.parametrize("turn", [-0.2, 0.0, 0.1])
def test_fingers_on_a_turned_face_show_its_angle(turn):
    found = balance_error(reading(turn=turn), HAND, None)
    assert found.turn == pytest.approx(turn, abs=0.02)
    assert found.shift == 0.0


def test_shift_is_from_the_middle_of_the_contacts_to_the_centre_of_mass():
    assert balance_error(reading(), HAND, 0.012).shift == pytest.approx(0.012)
    # Only the first two fingers touch. The third one does not count.
    expected = 0.012 - 0.5 * (ROW[0] + ROW[1])
    assert balance_error(reading((1.0, 1.0, 0.0)), HAND, 0.012).shift == pytest.approx(expected)
    assert balance_error(reading((0.0, 0.0, 0.0)), HAND, 0.012) == (0.0, 0.0)


def test_stack_shifts_and_turns_the_palm_and_keeps_its_depth():
    tray = Tray(np.array([0.4, -0.2, 0.0]), (0.25, 0.36), 0.07)
    cell = Cell(FakeRobot(), lambda _: pytest.fail("no image is taken"), tray)
    state, start = cell.arm_state(), cell.palm_pose()
    tasks = [task.at(state) for task in balance_tasks(start, MAX_SHIFT, 0.1)]
    twist = state.jacobian @ solve_stack(tasks).velocity
    closing, row, palm = start.rotation.as_matrix().T
    assert twist[:3] @ row > 0.01
    assert twist[3:] @ palm > 0.01
    # The tasks below the quality keep the palm from moving in other directions.
    assert twist[:3] @ closing == pytest.approx(0.0, abs=1e-6)
    assert twist[:3] @ palm == pytest.approx(0.0, abs=1e-6)


def test_thumb_follows_the_object_only_while_the_grip_is_eased():
    closing = Closing(HAND, "precision", WIDTH, GripOptions())
    for _ in range(800):
        closing.step(reading().hand, PERIOD)
    assert closing.state == "holding"
    thumb = HAND.drives.index("thumb")
    closing.ease(14.0, 18.0)
    eased = closing.step(reading().hand, PERIOD)
    assert (eased.modes[thumb], eased.values[thumb]) == ("pull", 18.0)
    closing.end_ease()
    assert closing.step(reading().hand, PERIOD).modes[thumb] == "hold"
