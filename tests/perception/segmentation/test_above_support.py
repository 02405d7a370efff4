"""Candidates: the compiled marking equals NumPy's, and each limit holds at its own boundary."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solids import CAMERA, EYE, TABLE_AXES, Ball, Box, Plate, exact_image, heights, solid_frame

from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.above_support import (
    BLOCK,
    MIN_HEIGHT,
    OVERHANG,
    SUPPORT_SIGMAS,
    above_support,
    candidate_window,
    count_blocks,
)
from eyehand.perception.segmentation.support_plane import Support

MAX_RANGE, MIN_PATCH = 4.0, 40
SMALL = CameraIntrinsics(20.0, 21.0, 8.0, 7.0, 17, 14)


def support(x, y, z=0.0, tolerance=0.0) -> Support:
    """A level support with a rectangular hull, in table coordinates."""
    corners = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    hull = corners - EYE * (TABLE_AXES[:2] @ TABLE_AXES[2])
    plane = SupportPlane(TABLE_AXES[2], EYE - z, tolerance)
    return Support(plane, hull.astype(np.float32), TABLE_AXES[:2], 0.7)


def reference(frame, supports, max_range):
    """Whole images at once: higher supports shade what lies in or under them from lower ones."""
    points = frame.intrinsics.rays() * frame.depth[..., None].astype(float)
    near = frame.valid & (frame.depth <= max_range)
    above, below = np.zeros((2, *frame.depth.shape), bool)
    for one in sorted(supports, key=lambda one: one.plane.offset):
        band = SUPPORT_SIGMAS * one.plane.tolerance * (points[..., 2] / one.depth) ** 2
        band = np.maximum(band, MIN_HEIGHT)
        plan = points @ one.axes.T
        low, high = one.hull.min(axis=0), one.hull.max(axis=0)
        inside = near & ~below & np.all(plan >= low - OVERHANG, axis=-1)
        inside &= np.all(plan <= high + OVERHANG, axis=-1)
        higher = one.plane.height(points) > band
        above |= inside & higher
        below |= inside & ~higher & ~above
    return above


@given(
    seed=st.integers(0, 10_000),
    count=st.integers(1, 3),
    max_range=st.sampled_from([0.9, 4.0]),
)
@settings(max_examples=20)
def test_marks_equal_numpys(seed, count, max_range):
    rng = np.random.default_rng(seed)
    frame, _ = solid_frame([], (Plate(),), SMALL)
    depth = np.where(rng.random((14, 17)) < 0.9, rng.uniform(0.4, 1.3, (14, 17)), 0.0)
    frame = DepthFrame(depth.astype(np.float32), SMALL)
    supports = [
        support(
            np.sort(rng.uniform(-0.5, 0.5, 2)),
            np.sort(rng.uniform(0.2, 1.4, 2)),
            rng.uniform(-0.4, 0.3),
            rng.choice([0.0, 0.01]),
        )
        for _ in range(count)
    ]
    assert np.array_equal(
        above_support(exact_image(frame), supports, max_range),
        reference(frame, supports, max_range),
    )


@given(seed=st.integers(0, 10_000), rows=st.integers(1, 20), columns=st.integers(1, 20))
@settings(max_examples=15)
def test_blocks_are_counted_as_sums(seed, rows, columns):
    mask = np.random.default_rng(seed).random((rows, columns)) < 0.4
    down, across = -(-rows // BLOCK), -(-columns // BLOCK)
    padded = np.zeros((down * BLOCK, across * BLOCK), int)
    padded[:rows, :columns] = mask
    expected = padded.reshape(down, BLOCK, across, BLOCK).sum(axis=(1, 3))
    assert np.array_equal(count_blocks(mask, down, across, BLOCK), expected)


def test_what_stands_on_the_table_is_above_it():
    frame, labels = solid_frame([Box(0.0, 0.6, (0.1, 0.1, 0.1))])
    above = above_support(exact_image(frame), [support((-1, 1), (0, 2))], MAX_RANGE)
    height = heights(frame)
    assert np.array_equal(above, (labels == 1) & (height > MIN_HEIGHT))


@pytest.mark.parametrize(("tolerance", "seen"), [(0.0, True), (0.005, False)])
def test_what_is_flatter_than_the_tables_waves_is_not_seen(tolerance, seen):
    frame, labels = solid_frame([Box(0.0, 0.6, (0.2, 0.2, 0.01))])
    above = above_support(
        exact_image(frame), [support((-1, 1), (0, 2), tolerance=tolerance)], MAX_RANGE
    )
    assert above[labels == 1].any() == seen


@pytest.mark.parametrize(("x", "seen"), [(0.29, True), (0.31, False)])
def test_an_object_may_reach_over_the_edge_by_an_overhang(x, seen):
    frame, labels = solid_frame([Box(x, 0.6, (0.001, 0.1, 0.1))])
    above = above_support(exact_image(frame), [support((-0.15, 0.15), (0, 2))], MAX_RANGE)
    assert above[labels == 1].any() == seen


def test_farther_than_the_reach_is_nothing():
    frame, _ = solid_frame([Ball(0.0, 0.6, 0.05, 0.05), Ball(0.1, 1.5, 0.1, 0.1)])
    for supports in ([], [support((-1, 1), (0, 3))]):
        above = above_support(exact_image(frame), supports, 1.0)
        assert above.any()
        assert frame.depth[above].max() <= 1.0
        assert frame.depth[above_support(exact_image(frame), supports, MAX_RANGE)].max() > 1.0


def test_without_a_support_every_reading_within_reach_is_a_candidate():
    frame, _ = solid_frame([Ball(0.0, 0.6, 0.05, 0.05)], ())
    assert np.array_equal(above_support(exact_image(frame), [], MAX_RANGE), frame.valid)


def test_a_table_and_its_legs_are_no_objects_on_the_floor():
    top = Plate((-0.3, 0.3), (0.6, 1.1))
    leg = Box(0.2, 0.65, (0.04, 0.04, 0.6), base=-0.65)
    frame, labels = solid_frame([Ball(0.0, 0.85, 0.05, 0.05), leg], (top, Plate(z=-0.7)))
    supports = [support((-2, 2), (-1, 4), -0.7), support(*top[:2])]
    assert (labels == 2).any()
    above = above_support(exact_image(frame), supports, MAX_RANGE)
    assert not above[labels != 1].any()
    assert above[labels == 1].mean() > 0.95


def test_the_window_holds_all_candidates_and_little_more():
    above = np.zeros((240, 320), bool)
    above[80:100, 150:200] = above[120:140, 60:80] = True
    rows, columns = candidate_window(above, MIN_PATCH) or (slice(0), slice(0))
    assert above[rows, columns].sum() == above.sum()
    assert (rows.start, rows.stop, columns.start, columns.stop) == (64, 160, 40, 216)


@pytest.mark.parametrize("size", [(1, 1), (5, 7), (240, 320), (241, 323)])
def test_a_window_never_leaves_the_image(size):
    above = np.ones(size, bool)
    window = candidate_window(above, 1)
    if above.sum() < 6:
        assert window is None
    else:
        assert window == (slice(0, size[0]), slice(0, size[1]))


def test_without_candidates_worth_a_look_there_is_no_window():
    above = np.zeros((240, 320), bool)
    assert candidate_window(above, MIN_PATCH) is None
    # Single pixels are noise; a block of 6 x 6 is smaller than any patch.
    above[::16, ::16] = True
    assert candidate_window(above, MIN_PATCH) is None
    above[0:6, 0:6] = True
    assert candidate_window(above, MIN_PATCH) is None
    above[0:7, 0:7] = True
    assert candidate_window(above, MIN_PATCH) is not None


def test_the_window_looks_at_what_the_camera_saw():
    frame, labels = solid_frame([Ball(0.1, 0.6, 0.05, 0.05)])
    above = above_support(exact_image(frame), [support((-1, 1), (0, 2))], MAX_RANGE)
    window = candidate_window(above, MIN_PATCH)
    assert window is not None
    part = CAMERA.cropped(*window)
    assert np.allclose(part.rays(), CAMERA.rays()[window])
    assert labels[window].sum() == labels.sum()
