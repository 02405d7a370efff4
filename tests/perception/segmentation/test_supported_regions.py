"""Only what stands over a support's hull, and is no wall, can be an object."""

import numpy as np
import pytest
from solids import CAMERA, EYE, TABLE_AXES, Ball, Box, Plate, exact_image, solid_frame

from eyehand.perception import DepthFrame
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.support_plane import Support
from eyehand.perception.segmentation.supported_regions import supported_regions

MAX_EXTENT = 0.8
FOOT = -EYE * TABLE_AXES[2]
"""The table coordinates' origin, in the camera's frame."""


def table(x, y, z=0.0) -> Support:
    """A support with a rectangular hull."""
    corners = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    hull = (corners + FOOT @ TABLE_AXES[:2].T).astype(np.float32)
    return Support(SupportPlane(TABLE_AXES[2], EYE - z), hull, TABLE_AXES[:2], 0.7)


WIDE = table((-0.3, 0.3), (0.4, 1.0))


def standing(solids, supports, min_size=40, max_extent=MAX_EXTENT):
    frame, labels = solid_frame(solids, (Plate(),))
    found = supported_regions(labels, exact_image(frame), supports, min_size, max_extent)
    return labels, found


def test_regions_are_numbered_by_size():
    labels, found = standing([Ball(-0.1, 0.7, 0.03, 0.03), Ball(0.1, 0.7, 0.06, 0.06)], [WIDE])
    assert np.array_equal(found, np.array([0, 2, 1])[labels])


def test_a_region_beyond_the_hull_goes():
    solids = [Ball(-0.1, 0.7, 0.05, 0.05), Ball(0.2, 0.7, 0.04, 0.04)]
    labels, found = standing(solids, [table((-0.3, 0.1), (0.4, 1.0))])
    assert np.array_equal(found, np.where(labels == 1, 1, 0))


@pytest.mark.parametrize(("beyond", "stays"), [(0.008, True), (0.012, False)])
def test_a_middle_may_lie_a_margin_beyond(beyond, stays):
    ball = Ball(0.2, 0.7, 0.04, 0.04)
    frame, labels = solid_frame([ball], (Plate(),))
    edge = float(np.median(frame.points()[labels == 1][:, 0])) - beyond
    hull = [table((-0.3, edge), (0.4, 1.0))]
    assert standing([ball], hull)[1].any() == stays


def test_over_any_of_several_supports_is_enough():
    solids = [Ball(-0.1, 0.7, 0.05, 0.05), Ball(0.2, 0.7, 0.04, 0.04)]
    halves = [table((-0.3, 0.0), (0.4, 1.0)), table((0.05, 0.3), (0.4, 1.0), -0.3)]
    labels, found = standing(solids, halves)
    assert np.array_equal(found, labels)


def test_without_a_support_everything_stays_but_what_is_too_large_or_too_small():
    wall, crumb = Box(0.0, 1.2, (2.0, 0.1, 0.5)), Ball(0.2, 0.6, 0.01, 0.01)
    solids = [Ball(0.0, 0.6, 0.05, 0.05), wall, crumb]
    labels, found = standing(solids, [], min_size=100)
    assert 0 < np.count_nonzero(labels == 3) < 100
    assert np.array_equal(found, np.where(labels == 1, 1, 0))
    labels, found = standing(solids, [], min_size=1, max_extent=3.0)
    assert np.array_equal(found, np.array([0, 2, 1, 3])[labels])


def test_a_few_outliers_are_no_extent():
    frame, labels = solid_frame([Ball(0.0, 0.7, 0.06, 0.06)], (Plate(),))
    depth = frame.depth.copy()
    rows, columns = np.nonzero(labels)
    depth[rows[::100], columns[::100]] = 3.0
    image = exact_image(DepthFrame(depth, frame.intrinsics))
    assert supported_regions(labels, image, [], 40, MAX_EXTENT).any()
    depth[rows[::10], columns[::10]] = 3.0
    image = exact_image(DepthFrame(depth, frame.intrinsics))
    assert not supported_regions(labels, image, [], 40, MAX_EXTENT).any()


def test_what_the_image_cuts_off_may_stand_where_the_table_was_not_seen():
    # Both middles lie some 10 cm beyond the hull; one ball is cut by the image's lower border.
    whole, cut = Ball(0.2, 0.7, 0.04, 0.04), Ball(0.0, 0.33, 0.05, 0.05)
    labels, found = standing([whole, cut], [table((-0.3, 0.1), (0.4, 1.0))])
    assert (labels[-1] == 2).any()
    assert np.array_equal(found, np.where(labels == 2, 1, 0))


def test_no_regions_give_no_regions():
    labels = np.zeros((240, 320), np.int32)
    image = exact_image(DepthFrame(np.ones(labels.shape, np.float32), CAMERA))
    assert not supported_regions(labels, image, [WIDE], 40, MAX_EXTENT).any()
