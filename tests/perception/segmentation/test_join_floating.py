"""What hangs on nothing joins what it touches; what stands, however small, does not."""

import numpy as np
import pytest
from solids import EYE, TABLE_AXES, Ball, Box, Plate, exact_image, solid_frame

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation import join_floating as module
from eyehand.perception.segmentation.join_floating import downwards, join_floating
from eyehand.perception.segmentation.local_planes import fit_local_planes
from eyehand.perception.segmentation.regions import ABOVE, BELOW, LEFT, RIGHT

OPTIONS = SegmentationOptions().scaled(320)
TABLE = SupportPlane(TABLE_AXES[2], EYE)
POT = Ball(0.0, 0.7, 0.08, 0.08)


def joined(*solids):
    """Labels of exact solids before and after."""
    frame, labels = solid_frame(list(solids), (Plate(),))
    image = exact_image(frame)
    return labels, join_floating(labels, image, fit_local_planes(image, OPTIONS), TABLE)


@pytest.mark.parametrize("side", [-1, 1])
def test_a_knob_beside_a_pot_is_the_pots(side):
    labels, whole = joined(POT, Box(side * 0.09, 0.7, (0.05, 0.03, 0.02), base=0.08))
    assert np.array_equal(whole, np.minimum(labels, 1))


@pytest.mark.parametrize(
    "other",
    [
        Box(0.09, 0.7, (0.05, 0.03, 0.09)),
        Box(-0.09, 0.7, (0.05, 0.03, 0.03)),
        # A ball's own belly hides its foot.
        Ball(0.1, 0.7, 0.04, 0.04),
        # What lies on top is carried by what it lies on.
        Ball(0.0, 0.7, 0.175, 0.015),
    ],
)
def test_what_stands_beside_a_pot_is_itself(other):
    labels, same = joined(POT, other)
    assert labels.max() == 2
    assert np.array_equal(same, labels)


def test_what_hangs_without_touching_is_itself():
    labels, same = joined(POT, Box(0.16, 0.7, (0.05, 0.03, 0.02), base=0.08))
    assert np.array_equal(same, labels)


@pytest.mark.parametrize(("limit", "value"), [("MAX_SIZE_SHARE", 0.1), ("MAX_AREA", 0.001)])
def test_keeps_large_piece(monkeypatch, limit, value):
    solids = POT, Box(0.115, 0.7, (0.1, 0.03, 0.05), base=0.08)
    assert joined(*solids)[1].max() == 1
    monkeypatch.setattr(module, limit, value)
    labels, same = joined(*solids)
    assert np.array_equal(same, labels)


def test_one_region_or_none_is_left_alone():
    labels, same = joined(POT)
    assert np.array_equal(same, labels)
    assert not joined()[1].any()


@pytest.mark.parametrize(
    ("up", "direction"),
    [
        (TABLE_AXES[2], BELOW),
        ([0.0, 1.0, 0.0], ABOVE),
        ([0.8, 0.0, -0.6], LEFT),
        ([-0.8, 0.1, -0.6], RIGHT),
        # Straight from above no direction leads down: any will do, here the usual one.
        ([0.0, 0.0, -1.0], BELOW),
    ],
)
def test_down_is_where_the_supports_normal_does_not_point(up, direction):
    assert downwards(SupportPlane(np.array(up), EYE)) == direction
