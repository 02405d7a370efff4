"""Distance of the open hand to a neighbour, and the depth by which it would push one."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from eyehand.grasping.box_kernels import nearest_point
from eyehand.grasping.grasp_geometry import GraspGeometry
from eyehand.grasping.hand_clearance import (
    RETREAT_LENGTH,
    NeighbourPoints,
    hand_boxes,
    hand_clearance,
)
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
    boxes = hand_boxes(HAND, "power", OPENING, GRASP.width)
    distance, label = hand_clearance(GRASP, placement, boxes, neighbours)
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


def reference(points, palm, axes, boxes) -> tuple[float, int]:
    """Return what `nearest_point` computes, with arrays over points and boxes."""
    local = (points - palm) @ axes.T
    low, high = boxes[:, 0, None], boxes[:, 1, None]
    outside = np.maximum(np.maximum(low - local, local - high), 0.0)
    distance = np.linalg.norm(outside, axis=2).min(axis=0)
    nearest = int(np.argmin(distance))
    if distance[nearest] > 0.0:
        return float(distance[nearest]), nearest
    inside = np.minimum(local - low, high - local)
    across = inside[..., 0]
    across = np.where(high[..., 0] <= 0.0, local[:, 0] - low[..., 0], across)
    across = np.where(low[..., 0] >= 0.0, high[..., 0] - local[:, 0], across)
    depth = np.where((inside > 0.0).all(axis=2), np.minimum(across, inside[..., 1]), 0.0)
    depth = depth.max(axis=0)
    return -float(depth.max()), int(np.argmax(depth))


@pytest.mark.parametrize("spread", [0.03, 0.2, 1.0])
def test_kernel_equals_reference(spread):
    rng = np.random.default_rng(3)
    for prototype in ("power", "pincer"):
        boxes = hand_boxes(HAND, prototype, OPENING, 0.04)
        for _ in range(20):
            axes = Rotation.random(rng=rng).as_matrix()
            points, palm = rng.normal(0.0, spread, (9, 3)), rng.normal(0.0, 0.05, 3)
            distance, nearest = nearest_point(points, palm, axes, boxes)
            expected, index = reference(points, palm, axes, boxes)
            assert distance == pytest.approx(expected, abs=1e-12)
            assert nearest == index
