"""Tests of selecting the regions that stand on a support."""

import numpy as np
import pytest
from synthetic_solids import (
    CAMERA,
    CAMERA_HEIGHT,
    TABLE_AXES,
    Ball,
    Box,
    Plate,
    exact_image,
    solid_frame,
)

from eyehand.perception import DepthFrame
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.label_pixels import pixels_by_label
from eyehand.perception.segmentation.select_objects import (
    BORDER,
    SAMPLES,
    count_inner,
    depth_in_hull,
    sample_region,
    select_objects,
)
from eyehand.perception.segmentation.support_extent import Support

MAX_EXTENT = 0.8
TABLE_ORIGIN = -CAMERA_HEIGHT * TABLE_AXES[2]
"""Origin of the table frame, in the camera frame."""


def support(x, y, z=0.0) -> Support:
    """Return a horizontal support with a rectangular hull."""
    corners = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    hull = (corners + TABLE_ORIGIN @ TABLE_AXES[:2].T).astype(np.float32)
    return Support(SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT - z), hull, TABLE_AXES[:2], 0.7)


WIDE_SUPPORT = support((-0.3, 0.3), (0.4, 1.0))


def select(solids, supports, min_size=40, max_extent=MAX_EXTENT):
    frame, labels = solid_frame(solids, (Plate(),))
    selected = select_objects(labels, exact_image(frame), supports, min_size, max_extent)
    return labels, selected


def test_regions_are_numbered_by_size():
    labels, selected = select(
        [Ball(-0.1, 0.7, 0.03, 0.03), Ball(0.1, 0.7, 0.06, 0.06)], [WIDE_SUPPORT]
    )
    assert np.array_equal(selected, np.array([0, 2, 1])[labels])


def test_region_beyond_hull_is_dropped():
    solids = [Ball(-0.1, 0.7, 0.05, 0.05), Ball(0.2, 0.7, 0.04, 0.04)]
    labels, selected = select(solids, [support((-0.3, 0.1), (0.4, 1.0))])
    assert np.array_equal(selected, np.where(labels == 1, 1, 0))


@pytest.mark.parametrize(("beyond", "kept"), [(0.008, True), (0.02, False)])
def test_foot_may_exceed_hull_by_margin(beyond, kept):
    ball = Ball(0.2, 0.7, 0.04, 0.04)
    frame, labels = solid_frame([ball], (Plate(),))
    hull_edge = float(np.median(frame.points()[labels == 1][:, 0])) - beyond
    hull = [support((-0.3, hull_edge), (0.4, 1.0))]
    assert select([ball], hull)[1].any() == kept


def test_region_over_any_support_is_kept():
    solids = [Ball(-0.1, 0.7, 0.05, 0.05), Ball(0.2, 0.7, 0.04, 0.04)]
    halves = [support((-0.3, 0.0), (0.4, 1.0)), support((0.05, 0.3), (0.4, 1.0), -0.3)]
    labels, selected = select(solids, halves)
    assert np.array_equal(selected, labels)


def test_without_support_only_size_limits_apply():
    wall, fragment = Box(0.0, 1.2, (2.0, 0.1, 0.5)), Ball(0.2, 0.6, 0.01, 0.01)
    solids = [Ball(0.0, 0.6, 0.05, 0.05), wall, fragment]
    labels, selected = select(solids, [], min_size=100)
    assert 0 < np.count_nonzero(labels == 3) < 100
    assert np.array_equal(selected, np.where(labels == 1, 1, 0))
    labels, selected = select(solids, [], min_size=1, max_extent=3.0)
    assert np.array_equal(selected, np.array([0, 2, 1, 3])[labels])


def test_few_outliers_do_not_change_extent():
    frame, labels = solid_frame([Ball(0.0, 0.7, 0.06, 0.06)], (Plate(),))
    depth = frame.depth.copy()
    rows, columns = np.nonzero(labels)
    depth[rows[::100], columns[::100]] = 3.0
    image = exact_image(DepthFrame(depth, frame.intrinsics))
    assert select_objects(labels, image, [], 40, MAX_EXTENT).any()
    depth[rows[::10], columns[::10]] = 3.0
    image = exact_image(DepthFrame(depth, frame.intrinsics))
    assert not select_objects(labels, image, [], 40, MAX_EXTENT).any()


def test_region_at_image_border_is_kept_beyond_hull():
    # Both centres lie about 10 cm beyond the hull. The lower image border cuts one ball.
    whole, cut = Ball(0.2, 0.7, 0.04, 0.04), Ball(0.0, 0.33, 0.05, 0.05)
    labels, selected = select([whole, cut], [support((-0.3, 0.1), (0.4, 1.0))])
    assert (labels[-1] == 2).any()
    assert np.array_equal(selected, np.where(labels == 2, 1, 0))


def test_cut_region_beside_a_hull_whose_surroundings_are_visible_is_dropped():
    # It hangs 15 cm above the table, and the image shows the place below it.
    ball = Ball(-0.46, 0.7, 0.2, 0.05)
    labels, selected = select([ball], [support((-0.36, 0.3), (0.4, 1.0))])
    assert (labels[:, 0] == 1).any()
    assert not selected.any()


def test_what_stands_on_the_floor_around_a_table_is_no_object():
    solids = [Ball(-0.1, 0.7, 0.04, 0.04), Ball(0.3, 0.7, -0.26, 0.04)]
    table, floor = support((-0.2, 0.1), (0.5, 0.8)), support((-0.6, 0.6), (0.3, 1.1), -0.3)
    board = support((-0.2, 0.4), (0.5, 0.8), -0.3)
    frame, labels = solid_frame(solids, (Plate((-0.2, 0.1), (0.5, 0.8)), Plate(z=-0.3)))
    assert (labels == 2).any()
    for lower, kept in ((floor, False), (board, True)):
        selected = select_objects(labels, exact_image(frame), [table, lower], 40, MAX_EXTENT)
        assert selected[labels == 1].all()
        assert selected[labels == 2].all() == kept
    alone = np.where(labels == 2, 2, 0).astype(np.int32)
    assert select_objects(alone, exact_image(frame), [table, floor], 40, MAX_EXTENT).any()


def test_object_on_a_board_whose_edge_alone_is_visible_is_kept():
    edge, ball = Box(0.0, 0.6, (0.5, 0.02, 0.02), base=0.28), Ball(-0.1, 0.7, 0.34, 0.04)
    low = support((-0.3, 0.3), (0.2, 0.55))
    labels, selected = select([edge, ball], [low])
    assert np.array_equal(selected > 0, labels == 2)
    assert not select([ball], [low])[1].any()


def test_region_through_a_board_is_no_object():
    side, box = Box(0.0, 0.6, (0.1, 0.1, 0.5)), Box(0.2, 0.6, (0.06, 0.06, 0.15))
    board = support((-0.3, 0.3), (0.4, 1.0), 0.25)
    labels, selected = select([side, box], [board, WIDE_SUPPORT])
    assert np.array_equal(selected > 0, labels == 2)
    assert select([side], [WIDE_SUPPORT])[1].any()


def test_wall_of_a_container_is_no_object():
    floor = support((-0.2, 0.2), (0.5, 0.9))
    wall, ball = Box(0.215, 0.7, (0.02, 0.4, 0.1)), Ball(0.0, 0.7, 0.04, 0.04)
    frame, labels = solid_frame([wall, ball], (Plate(),))
    image = exact_image(frame)
    kept = select_objects(labels, image, [floor._replace(foot_margin=0.01)], 40, MAX_EXTENT)
    assert np.array_equal(kept > 0, labels == 2)
    assert np.count_nonzero(select_objects(labels, image, [WIDE_SUPPORT], 40, MAX_EXTENT)) > 0


def test_long_region_cut_by_the_image_is_no_object():
    robot = Box(0.0, 0.3, (0.3, 0.2, 0.1))
    frame, labels = solid_frame([robot], (Plate(),))
    assert (labels[-1] == 1).any()
    wide = support((-1.0, 1.0), (-0.5, 2.0))
    assert not select_objects(labels, exact_image(frame), [wide], 40, MAX_EXTENT).any()


@pytest.mark.parametrize("cut", [True, False])
def test_ends_of_a_region_that_the_image_cuts_off_count(cut):
    # A tail of few readings is the end of the region.
    foot, tail = Ball(0.0, 0.33, 0.06, 0.06), Box(0.0, 0.7, (0.012, 0.3, 0.012))
    frame, labels = solid_frame([foot, tail], (Plate(),))
    region = (labels > 0).astype(np.int32)
    assert region[-1].any()
    if not cut:
        region[-BORDER:] = 0
    points = frame.points()[region > 0]
    wide, narrow = (
        float(np.linalg.norm(np.ptp(np.quantile(points, [share, 1 - share], axis=0), axis=0)))
        for share in (0.01, 0.02)
    )
    assert wide > narrow + 0.01
    kept = select_objects(region, exact_image(frame), [WIDE_SUPPORT], 40, (wide + narrow) / 2)
    assert kept.any() != cut


def test_empty_labels_stay_empty():
    labels = np.zeros((240, 320), np.int32)
    image = exact_image(DepthFrame(np.ones(labels.shape, np.float32), CAMERA))
    assert not select_objects(labels, image, [WIDE_SUPPORT], 40, MAX_EXTENT).any()


def test_samples_of_a_region_equal_numpy():
    frame, labels = solid_frame([Ball(0.0, 0.33, 0.05, 0.05)], (Plate(),))
    image = exact_image(frame)
    order, starts = pixels_by_label(labels, 1)
    points, cut = sample_region(order[starts[1] : starts[2]], image.disparity, image.pinhole)
    rows, columns = np.nonzero(labels == 1)
    step = len(rows) // SAMPLES
    assert step > 1
    assert np.allclose(points, image.points(rows[::step], columns[::step]))
    bottom = rows >= labels.shape[0] - BORDER
    assert bottom.any()
    assert np.allclose(cut, image.points(rows[bottom], columns[bottom]))


@pytest.mark.parametrize("turn", [1, -1])
def test_depth_in_hull_of_rectangle(turn):
    hull = np.array([[0, 0], [0.4, 0], [0.4, 0.2], [0, 0.2]], np.float32)[::turn]
    points = np.random.default_rng(0).uniform(-0.1, 0.5, (50, 2))
    x, y = points.T
    expected = np.minimum.reduce([x, 0.4 - x, y, 0.2 - y])
    assert np.allclose(depth_in_hull(points, np.ascontiguousarray(hull)), expected, atol=1e-6)


def test_region_as_low_as_waves_is_dropped():
    plate = Box(0.0, 0.7, (0.1, 0.1, 0.006))
    frame, labels = solid_frame([plate], (Plate(),))
    image = exact_image(frame)
    for wave, kept in ((0.001, True), (0.004, False)):
        waving = WIDE_SUPPORT._replace(wave=wave / 0.7**2)
        assert select_objects(labels, image, [waving], 40, MAX_EXTENT).any() == kept


def test_leg_that_reaches_higher_support_is_no_object():
    leg, box = Box(0.0, 0.6, (0.04, 0.04, 0.29)), Box(0.15, 0.6, (0.04, 0.04, 0.1))
    board = support((-0.3, 0.3), (0.4, 1.0), 0.3)
    labels, selected = select([leg, box], [board, WIDE_SUPPORT])
    assert not selected[labels == 1].any()
    assert selected[labels == 2].any()


def test_region_high_above_its_support_is_no_object():
    hanging, high = Ball(0.0, 0.7, 0.04, 0.5), Ball(0.0, 0.7, 0.04, 0.2)
    for ball, kept in ((hanging, False), (high, True)):
        _, selected = select([ball], [support((-0.5, 0.5), (0.2, 1.5))])
        assert selected.any() == kept


def test_object_on_hidden_corner_of_its_support_is_kept():
    box = Box(0.34, 0.6, (0.1, 0.1, 0.1))
    for z, kept in ((0.0, True), (-0.05, False)):
        _, selected = select([box], [support((-0.3, 0.27), (0.4, 1.0), z)])
        assert selected.any() == kept


def test_large_frame_is_no_object():
    bars = [Box(x, 0.7, (0.02, 0.02, 0.3)) for x in (-0.2, 0.2)]
    beam = Box(0.0, 0.7, (0.42, 0.02, 0.02), base=0.3)
    frame, labels = solid_frame([*bars, beam], (Plate(),))
    image = exact_image(frame)
    joined = (labels > 0).astype(np.int32)
    assert not select_objects(joined, image, [WIDE_SUPPORT], 40, MAX_EXTENT).any()
    separate = select_objects(labels, image, [WIDE_SUPPORT], 40, MAX_EXTENT)
    assert np.array_equal(separate > 0, joined > 0)


def test_inner_pixels_equal_numpy():
    labels = np.random.default_rng(0).integers(1, 3, (9, 11)).astype(np.int32)
    flat = labels.ravel()
    pixels = np.flatnonzero(flat == 2).astype(np.int32)
    same = np.ones(len(pixels), bool)
    for step in (-11, -1, 1, 11):
        same &= flat[np.clip(pixels + step, 0, flat.size - 1)] == 2
    assert count_inner(pixels, labels) == np.count_nonzero(same) > 0
