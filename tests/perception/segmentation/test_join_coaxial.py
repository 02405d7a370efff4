"""Tests of joining necks to the bodies below them."""

import numpy as np
import pytest
from synthetic_solids import Ball, Box, exact_image, solid_frame

from eyehand.perception import CameraIntrinsics
from eyehand.perception.segmentation import SegmentationOptions
from eyehand.perception.segmentation.ambiguity import COAXIAL
from eyehand.perception.segmentation.join_coaxial import _is_neck, _Region, join_coaxial
from eyehand.perception.segmentation.local_planes import fit_local_planes
from eyehand.perception.segmentation.result import SupportPlane

CAMERA = CameraIntrinsics(600.0, 600.0, 319.5, 239.5, 640, 480)
TABLE = SupportPlane(np.array([0.0, -0.8, -0.6]), 0.6, 0.002)
BODY = Ball(0.0, 0.65, 0.06, 0.06)


def join(*solids):
    """Return the number of objects after the join, and the uncertain pairs."""
    frame, truth = solid_frame(solids, camera=CAMERA)
    image = exact_image(frame)
    planes = fit_local_planes(image, SegmentationOptions())
    joined, uncertain = join_coaxial(truth, image, planes, TABLE)
    assert np.array_equal(joined > 0, truth > 0)
    return joined.max(), uncertain


@pytest.mark.parametrize(
    ("upper", "objects"),
    [
        (Ball(0.0, 0.65, 0.13, 0.025), 1),
        (Ball(0.0, 0.65, 0.16, 0.045), 2),
    ],
)
def test_narrow_part_on_a_sloping_shoulder_is_joined_and_a_wide_one_reported(upper, objects):
    count, uncertain = join(BODY, upper)
    assert count == objects
    assert [one.reason for one in uncertain] == [COAXIAL] * (objects - 1)


@pytest.mark.parametrize(
    "solids",
    [
        (BODY, Ball(0.03, 0.63, 0.13, 0.025)),
        (BODY, Ball(0.12, 0.65, 0.025, 0.025)),
        (Box(0.0, 0.65, (0.1, 0.1, 0.1), yaw=0.6), Ball(0.0, 0.65, 0.125, 0.025)),
        (Box(0.0, 0.65, (0.1, 0.1, 0.1)), Box(0.0, 0.65, (0.04, 0.04, 0.05), base=0.1)),
    ],
)
def test_parts_without_a_common_axis_stay_as_they_are(solids):
    assert join(*solids) == (2, [])


@pytest.mark.parametrize(("slope", "joined"), [(0.0, False), (0.6, True)])
def test_flat_ring_around_the_upper_part_is_no_shoulder(slope, joined):
    def ring(low, high, height):
        radius, angle = np.meshgrid(np.linspace(low, high, 20), np.linspace(0.0, 3.0, 20))
        plan = (radius * [np.cos(angle), np.sin(angle)]).reshape(2, -1).T
        level = height - slope * np.maximum(radius.ravel() - 0.012, 0.0)
        return _Region(level, plan, plan[:0], plan[:0])

    neck, body = ring(0.0, 0.012, 0.2), ring(0.012, 0.035, 0.15)
    assert _is_neck(neck, body, np.zeros(2)) == joined
