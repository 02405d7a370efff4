"""Regions in the air are removed, unless another region carries them."""

import numpy as np
import pytest
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES, Box, Plate, exact_image, solid_frame

from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.floating_regions import remove_floating
from eyehand.perception.segmentation.support_extent import Support

ORIGIN = -CAMERA_HEIGHT * TABLE_AXES[2]
"""Origin of the table frame, in the camera frame."""
BAR = Box(0.0, 0.7, (0.22, 0.03, 0.03), 0.25)
"""A bar in the air, below which the table is visible."""


def support(z=0.0):
    corners = np.array([[-0.3, 0.4], [0.3, 0.4], [0.3, 1.0], [-0.3, 1.0]])
    hull = (corners + ORIGIN @ TABLE_AXES[:2].T).astype(np.float32)
    return Support(SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT - z), hull, TABLE_AXES[:2], 0.7)


def removed(solids, supports):
    """Return which of the solids are removed."""
    frame, labels = solid_frame(solids, (Plate(),))
    left = remove_floating(labels.astype(np.int32), exact_image(frame), supports)
    assert set(np.unique(left)) == set(range(left.max() + 1))
    return [not left[labels == number + 1].any() for number in range(len(solids))]


@pytest.mark.parametrize(
    ("others", "gone"),
    [
        ([], True),
        ([Box(0.2, 0.7, (0.06, 0.06, 0.25))], True),
        ([Box(0.0, 0.72, (0.06, 0.06, 0.25))], False),
    ],
    ids=["alone", "beside an object", "on an object"],
)
def test_bar_in_the_air_is_removed_unless_an_object_reaches_up_to_it(others, gone):
    assert removed([BAR, *others], [support()]) == [gone, *(False for _ in others)]


def test_nothing_is_removed_in_a_shelf_or_without_a_support():
    assert removed([BAR], [support(), support(-0.35)]) == [False]
    assert removed([BAR], []) == [False]
