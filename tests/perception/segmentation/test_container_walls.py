"""Tests of measuring the walls around a rectangle."""

import numpy as np
import pytest

from eyehand.perception.segmentation.container_walls import measure_sides

CORNERS = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.3], [0.0, 0.3]])


@pytest.mark.parametrize(("slope", "seen"), [(0.05, True), (0.4, False)])
def test_skew_rim_of_a_side_that_the_image_cuts_off_is_no_wall(slope, seen):
    s, width = np.meshgrid(np.linspace(0.0, 0.13, 200), np.linspace(0.0, 0.01, 8))
    plan = np.column_stack([s.ravel(), (-slope * (s - 0.065) - width).ravel()])
    visible = np.zeros((4, 41), bool)
    visible[0, :13] = True
    side = measure_sides(CORNERS, plan, np.full(len(plan), 0.1), 0.0, 0.1, visible)[0]
    assert side.seen == seen


def test_side_outside_the_image_keeps_its_direction():
    visible = np.zeros((4, 41), bool)
    sides = measure_sides(CORNERS, np.zeros((0, 2)), np.zeros(0), 0.0, 0.1, visible)
    assert not any(side.seen for side in sides)
    np.testing.assert_allclose([side.along for side in sides], [[1, 0], [0, 1], [-1, 0], [0, -1]])
