"""Distance of the open hand to a neighbour, and the depth by which it would push one."""

import numpy as np
import pytest

from eyehand.grasping.grasp_geometry import GraspGeometry
from eyehand.grasping.hand_clearance import RETREAT_LENGTH, NeighbourPoints, hand_clearance
from eyehand.grasping.hands import nominal_hand
from eyehand.grasping.palm_placement import PalmPlacement

HAND = nominal_hand()
OPENING = 0.08
GRASP = GraspGeometry(
    kind="box",
    approach="top",
    freedom="none",
    closing=np.array([1.0, 0.0, 0.0]),
    palm=np.array([0.0, 0.0, -1.0]),
    finger_row=np.array([0.0, -1.0, 0.0]),
    up=np.array([0.0, 0.0, 1.0]),
    centre=np.zeros(3),
    width=0.04,
    length=0.06,
    height=0.04,
    half_depth=0.02,
    rise=0.02,
    width_std=0.0,
)
PALM_HEIGHT = 0.1
INSIDE_PALM = PALM_HEIGHT + HAND.palm_depth


def clearance(point):
    neighbours = NeighbourPoints(np.array([point], dtype=float), np.array([7]))
    placement = PalmPlacement(PALM_HEIGHT, np.pi, 0.0, 0.0)
    distance, label = hand_clearance(GRASP, "power", placement, OPENING, HAND, neighbours)
    assert label == 7
    return distance


def test_distance_to_point_beside_retreat():
    half_row = 0.5 * HAND.row_width
    assert clearance([0.0, half_row + 0.03, INSIDE_PALM]) == pytest.approx(0.03)
    behind = PALM_HEIGHT + HAND.palm_depth + RETREAT_LENGTH
    assert clearance([0.0, 0.0, behind + 0.02]) == pytest.approx(0.02)


def test_palm_pushes_to_its_nearer_side():
    half_base = 0.5 * float(HAND.outer_widths[0])
    for x in (0.4 * half_base, 0.9 * half_base):
        depth = min(half_base - x, 0.5 * HAND.row_width)
        assert clearance([x, 0.0, INSIDE_PALM]) == pytest.approx(-depth)
        assert clearance([-x, 0.0, INSIDE_PALM]) == pytest.approx(-depth)


def test_fingers_push_away_from_object():
    tip = PALM_HEIGHT - HAND.reach(OPENING) + 0.002
    outside, half_row = 0.5 * OPENING + HAND.thickness, 0.5 * HAND.row_width
    x = 0.5 * OPENING + 0.25 * HAND.thickness
    depth = min(outside - x, half_row)
    assert clearance([-x, 0.0, tip]) == pytest.approx(-depth)
