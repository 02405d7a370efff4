"""Heights at which a hand clears the walls and the content of the tray."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from eyehand.grasping import load_hand
from eyehand.grasping.hands.nominal_hand import nominal_hand
from eyehand.grasping.tray import Tray
from eyehand.grasping.tray_clearance import (
    CELL,
    OVER_MARGIN,
    POINT_STEP,
    SIDE_MARGIN,
    clear_heights,
    lowest_points,
    opening_boxes,
    tray_columns,
)
from eyehand.grasping.tray_plan import TrayItem

TRAY = Tray(np.array([0.4, -0.1, 0.01]), (0.3, 0.3), 0.06)
DOWN = np.diag([1.0, -1.0, -1.0])
CAN = TrayItem(TRAY.centre[:2] + np.array([0.05, 0.0]), 0.03, 0.04)
GRIPPER = load_hand("panda")


@pytest.mark.parametrize(
    ("x", "height"),
    [(0.0, 0.0), (0.05, 0.04), (0.085, 0.04), (0.1, 0.0), (0.145, 0.06), (0.2, 0.0), (0.9, 0.0)],
)
def test_columns_hold_content_and_walls_grown_by_a_margin(x, height):
    columns = tray_columns(TRAY, [CAN])
    assert columns.heights(TRAY.centre[:2] + np.array([x, 0.0])) == height


def jaw_height(x: float, turn: float) -> float:
    """Return the lowest height of the fingertips of a gripper that points down at a place."""
    boxes = opening_boxes(GRIPPER, "precision", 0.04)
    axes = Rotation.from_euler("z", turn).as_matrix() @ DOWN
    points = lowest_points(boxes, axes, np.zeros(3))
    places = TRAY.centre[:2] + np.array([[x, 0.0]])
    return float(clear_heights(tray_columns(TRAY, [CAN]), points, places)[0])


def test_jaws_that_open_beside_an_object_fit_if_they_open_along_it():
    """The centre between the pads is 60 mm from the middle of a can with a radius of 30 mm."""
    room = 0.06 - CAN.radius - SIDE_MARGIN
    assert 0.5 * GRIPPER.pad_width < room < 0.5 * GRIPPER.stroke
    assert jaw_height(-0.01, 0.5 * np.pi) == pytest.approx(OVER_MARGIN)
    assert jaw_height(-0.01, 0.0) == pytest.approx(CAN.top + OVER_MARGIN)


def test_points_cover_the_lower_side_of_every_box():
    boxes = np.array([[[-0.02, -0.03, 0.0], [0.02, 0.03, 0.1]]])
    points = lowest_points(boxes, DOWN, np.array([0.0, 0.0, 0.1]))
    np.testing.assert_allclose(points[:, 2].min(), 0.0, atol=1e-12)
    for x in np.linspace(-0.02, 0.02, 9):
        near = np.abs(points[:, :2] - (x, 0.0)).max(axis=1) <= 0.5 * POINT_STEP + CELL
        assert points[near, 2].min() == pytest.approx(0.0, abs=1e-12)


def test_opening_jaws_sweep_everything_between_the_held_and_the_open_width():
    boxes = opening_boxes(GRIPPER, "precision", 0.02)
    for width in np.linspace(0.02, GRIPPER.stroke, 30):
        middle = GRIPPER.jaw_boxes(width).mean(axis=1)
        inside = (boxes[:, 0] <= middle[:, None]) & (middle[:, None] <= boxes[:, 1])
        assert inside.all(axis=2).any(axis=1).all()


def test_open_fingers_are_wider_than_the_held_object():
    hand = nominal_hand()
    boxes = opening_boxes(hand, "precision", 0.04)
    assert boxes[:, 1, 0].max() >= 0.5 * hand.max_opening
