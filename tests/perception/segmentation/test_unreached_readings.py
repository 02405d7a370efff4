"""Tests of the readings in front of all supports: a board seen edge-on has no plane."""

import numpy as np
import pytest

from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.support_extent import Support
from eyehand.perception.segmentation.unreached_readings import continued_share, unreached_share
from eyehand.perception.segmentation.working_image import working_image

CAMERA = CameraIntrinsics(300.0, 300.0, 160.0, 120.0, 320, 240)
HEIGHT = 0.7
"""Height of the level camera above the floor, m."""


def floor(near: float, far: float) -> Support:
    """Return a floor 2 m wide between two depths, m."""
    plane = SupportPlane(np.array([0.0, -1.0, 0.0]), HEIGHT)
    hull = np.array([[-1, near], [1, near], [1, far], [-1, far]], np.float32)
    return Support(plane, hull, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), far)


def share(depth: float, support: Support) -> float:
    """Return the unreached share of a wall at `depth` m over half of the image."""
    image = np.full((240, 320), 2.0, np.float32)
    image[60:180, :] = depth
    return unreached_share(working_image(DepthFrame(image, CAMERA), 1), [support])


def test_structure_in_front_of_a_far_floor_is_out_of_reach():
    assert share(0.8, floor(1.5, 2.5)) == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(("depth", "near"), [(1.4, 1.5), (1.6, 1.5), (0.8, 0.5)])
def test_structures_near_the_support_are_within_reach(depth, near):
    assert share(depth, floor(near, 2.5)) == 0.0


def test_no_support_has_no_reach():
    frame = DepthFrame(np.ones((240, 320), np.float32), CAMERA)
    assert unreached_share(working_image(frame, 1), []) == 0.0


@pytest.mark.parametrize(("far", "least", "most"), [(2.5, 0.0, 0.0), (1.95, 1.0, 4.0)])
def test_readings_that_continue_a_support_outside_its_outline(far, least, most):
    rows = np.arange(240)[:, None] - CAMERA.cy
    depth = np.where(rows > 30, HEIGHT * CAMERA.fy / np.maximum(rows, 1), 0.0)
    depth[depth > 2.4] = 0.0
    image = np.repeat(depth, 320, axis=1).astype(np.float32)
    image[:, :40] = image[:, -40:] = 0.0
    found = continued_share(working_image(DepthFrame(image, CAMERA), 1), floor(1.4, far))
    assert least <= found <= most
