"""Tests of joining floating regions to the region that they touch."""

import numpy as np
import pytest
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES, Ball, Box, Plate, exact_image, solid_frame

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation import join_floating as module
from eyehand.perception.segmentation.join_floating import downwards, join_floating
from eyehand.perception.segmentation.local_planes import fit_local_planes
from eyehand.perception.segmentation.regions import ABOVE, BELOW, LEFT, RIGHT

OPTIONS = SegmentationOptions().scaled(320)
TABLE = SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT)
POT = Ball(0.0, 0.7, 0.08, 0.08)


def join(*solids):
    """Return the labels of exact solids before and after the join."""
    frame, labels = solid_frame(list(solids), (Plate(),))
    image = exact_image(frame)
    return labels, join_floating(labels, image, fit_local_planes(image, OPTIONS), TABLE)


@pytest.mark.parametrize("side", [-1, 1])
def test_knob_joins_pot(side):
    labels, whole = join(POT, Box(side * 0.09, 0.7, (0.05, 0.03, 0.02), base=0.08))
    assert np.array_equal(whole, np.minimum(labels, 1))


@pytest.mark.parametrize(
    "other",
    [
        Box(0.09, 0.7, (0.05, 0.03, 0.09)),
        Box(-0.09, 0.7, (0.05, 0.03, 0.03)),
        # The ball hides its own contact with the table.
        Ball(0.1, 0.7, 0.04, 0.04),
        # An object on top is supported by the object below.
        Ball(0.0, 0.7, 0.175, 0.015),
    ],
)
def test_supported_object_stays_separate(other):
    labels, same = join(POT, other)
    assert labels.max() == 2
    assert np.array_equal(same, labels)


def test_floating_object_without_contact_stays_separate():
    labels, same = join(POT, Box(0.16, 0.7, (0.05, 0.03, 0.02), base=0.08))
    assert np.array_equal(same, labels)


@pytest.mark.parametrize(("limit", "value"), [("MAX_SIZE_SHARE", 0.1), ("MAX_AREA", 0.001)])
def test_large_piece_stays_separate(monkeypatch, limit, value):
    solids = POT, Box(0.095, 0.7, (0.05, 0.03, 0.05), base=0.08)
    assert join(*solids)[1].max() == 1
    monkeypatch.setattr(module, limit, value)
    labels, same = join(*solids)
    assert np.array_equal(same, labels)


def test_fewer_than_two_regions_stay_unchanged():
    labels, same = join(POT)
    assert np.array_equal(same, labels)
    assert not join()[1].any()


@pytest.mark.parametrize(
    ("up", "direction"),
    [
        (TABLE_AXES[2], BELOW),
        ([0.0, 1.0, 0.0], ABOVE),
        ([0.8, 0.0, -0.6], LEFT),
        ([-0.8, 0.1, -0.6], RIGHT),
        # For a view from straight above no image direction leads down: BELOW is the default.
        ([0.0, 0.0, -1.0], BELOW),
    ],
)
def test_downwards_is_opposite_to_support_normal(up, direction):
    assert downwards(SupportPlane(np.array(up), CAMERA_HEIGHT)) == direction
