"""Tests of candidate pixels: equality with NumPy, and each limit at its boundary."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_solids import (
    CAMERA,
    CAMERA_HEIGHT,
    TABLE_AXES,
    Ball,
    Box,
    Plate,
    exact_image,
    heights,
    solid_frame,
)

from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.above_support import (
    BAND_WAVES,
    BLOCK,
    BOARD,
    MIN_HEIGHT,
    OVERHANG,
    SUPPORT_SIGMAS,
    above_support,
    candidate_window,
    count_blocks,
)
from eyehand.perception.segmentation.support_extent import Support

MAX_RANGE, MIN_PATCH = 4.0, 40
SMALL = CameraIntrinsics(20.0, 21.0, 8.0, 7.0, 17, 14)


def support(x, y, z=0.0, tolerance=0.0) -> Support:
    """Return a horizontal support with a rectangular hull, in the table frame."""
    corners = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    hull = corners - CAMERA_HEIGHT * (TABLE_AXES[:2] @ TABLE_AXES[2])
    plane = SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT - z, tolerance)
    return Support(plane, hull.astype(np.float32), TABLE_AXES[:2], 0.7)


def reference(frame, supports, max_range):
    """Mark candidates with NumPy, from the highest support down.

    Points in or under a higher support are candidates of a lower one if they lie within the bounds
    of both and end below the higher one.
    """
    points = frame.intrinsics.rays() * frame.depth[..., None].astype(float)
    in_range = frame.valid & (frame.depth <= max_range)
    above, below = np.zeros((2, *frame.depth.shape), bool)
    highest = np.inf
    hulls = []
    for item in sorted(supports, key=lambda item: item.plane.offset):
        band = SUPPORT_SIGMAS * item.plane.tolerance * (points[..., 2] / item.depth) ** 2
        band = np.maximum(band, BAND_WAVES * item.wave * points[..., 2] ** 2)
        band = np.maximum(band, MIN_HEIGHT)
        plan = points @ item.axes.T
        low, high = item.hull.min(axis=0), item.hull.max(axis=0)
        inside = in_range & np.all((plan >= low - OVERHANG) & (plan <= high + OVERHANG), axis=-1)
        height = item.plane.height(points)
        hulls.append(item.hull @ item.axes)
        corners = np.concatenate(hulls) @ item.axes.T
        under = np.all((plan >= corners.min(axis=0)) & (plan <= corners.max(axis=0)), axis=-1)
        under &= height <= max(item.plane.offset - highest - BOARD, 0.0)
        highest = item.plane.offset
        inside &= ~below | under
        higher = height > band
        above |= inside & higher
        below |= inside & ~higher & ~above
    return above


@given(seed=st.integers(0, 10_000), count=st.integers(1, 3), max_range=st.sampled_from([0.9, 4.0]))
@settings(max_examples=20)
def test_marks_equal_numpy(seed, count, max_range):
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
def test_block_counts_equal_numpy(seed, rows, columns):
    mask = np.random.default_rng(seed).random((rows, columns)) < 0.4
    down, across = -(-rows // BLOCK), -(-columns // BLOCK)
    padded = np.zeros((down * BLOCK, across * BLOCK), int)
    padded[:rows, :columns] = mask
    expected = padded.reshape(down, BLOCK, across, BLOCK).sum(axis=(1, 3))
    assert np.array_equal(count_blocks(mask, down, across, BLOCK), expected)


def test_object_on_table_is_above_support():
    frame, labels = solid_frame([Box(0.0, 0.6, (0.1, 0.1, 0.1))])
    above = above_support(exact_image(frame), [support((-1, 1), (0, 2))], MAX_RANGE)
    assert np.array_equal(above, (labels == 1) & (heights(frame) > MIN_HEIGHT))


@pytest.mark.parametrize(("tolerance", "detected"), [(0.0, True), (0.005, False)])
def test_object_flatter_than_plane_tolerance_is_ignored(tolerance, detected):
    frame, labels = solid_frame([Box(0.0, 0.6, (0.2, 0.2, 0.01))])
    above = above_support(
        exact_image(frame), [support((-1, 1), (0, 2), tolerance=tolerance)], MAX_RANGE
    )
    assert above[labels == 1].any() == detected


@pytest.mark.parametrize(("x", "detected"), [(0.29, True), (0.31, False)])
def test_object_may_overhang_edge(x, detected):
    frame, labels = solid_frame([Box(x, 0.6, (0.001, 0.1, 0.1))])
    above = above_support(exact_image(frame), [support((-0.15, 0.15), (0, 2))], MAX_RANGE)
    assert above[labels == 1].any() == detected


def test_pixels_beyond_max_range_are_ignored():
    frame, _ = solid_frame([Ball(0.0, 0.6, 0.05, 0.05), Ball(0.1, 1.5, 0.1, 0.1)])
    for supports in ([], [support((-1, 1), (0, 3))]):
        above = above_support(exact_image(frame), supports, 1.0)
        assert above.any()
        assert frame.depth[above].max() <= 1.0
        assert frame.depth[above_support(exact_image(frame), supports, MAX_RANGE)].max() > 1.0


def test_without_support_all_readings_in_range_are_candidates():
    frame, _ = solid_frame([Ball(0.0, 0.6, 0.05, 0.05)], ())
    assert np.array_equal(above_support(exact_image(frame), [], MAX_RANGE), frame.valid)


def test_table_is_no_object_and_hides_what_reaches_it_from_below():
    top = Plate((-0.3, 0.3), (0.6, 1.1))
    below = Box(-0.1, 0.62, (0.04, 0.04, 0.2), base=-0.7)
    beside = Box(0.45, 0.65, (0.04, 0.04, 0.65), base=-0.7)
    frame, labels = solid_frame([Ball(0.0, 0.85, 0.05, 0.05), below, beside], (top, Plate(z=-0.7)))
    supports = [support((-0.3, 0.3), (0.4, 1.1), -0.7), support(*top[:2])]
    assert (labels == 2).any()
    assert (labels == 3).any()
    above = above_support(exact_image(frame), supports, MAX_RANGE)
    assert not above[(labels == 0) | (labels == 3)].any()
    assert above[labels == 1].mean() > 0.95
    assert above[labels == 2].mean() > 0.8


def test_window_encloses_candidates_tightly():
    above = np.zeros((240, 320), bool)
    above[80:100, 150:200] = above[120:140, 60:80] = True
    rows, columns = candidate_window(above, MIN_PATCH) or (slice(0), slice(0))
    assert above[rows, columns].sum() == above.sum()
    assert (rows.start, rows.stop, columns.start, columns.stop) == (64, 160, 40, 216)


@pytest.mark.parametrize("size", [(1, 1), (5, 7), (240, 320), (241, 323)])
def test_window_stays_in_image(size):
    above = np.ones(size, bool)
    window = candidate_window(above, 1)
    if above.sum() < 6:
        assert window is None
    else:
        assert window == (slice(0, size[0]), slice(0, size[1]))


def test_few_candidates_give_no_window():
    above = np.zeros((240, 320), bool)
    assert candidate_window(above, MIN_PATCH) is None
    # Single pixels are noise. A block of 6 x 6 px is smaller than the minimum patch.
    above[::16, ::16] = True
    assert candidate_window(above, MIN_PATCH) is None
    above[0:6, 0:6] = True
    assert candidate_window(above, MIN_PATCH) is None
    above[0:7, 0:7] = True
    assert candidate_window(above, MIN_PATCH) is not None


def test_window_keeps_rays_and_objects():
    frame, labels = solid_frame([Ball(0.1, 0.6, 0.05, 0.05)])
    above = above_support(exact_image(frame), [support((-1, 1), (0, 2))], MAX_RANGE)
    window = candidate_window(above, MIN_PATCH)
    assert window is not None
    cropped = CAMERA.cropped(*window)
    assert np.allclose(cropped.rays(), CAMERA.rays()[window])
    assert labels[window].sum() == labels.sum()


def test_waves_of_support_are_no_candidates():
    plate = Box(0.0, 0.7, (0.1, 0.1, 0.005))
    frame, labels = solid_frame([plate], (Plate(),))
    flat = support((-0.3, 0.3), (0.4, 1.0))
    for wave, kept in ((0.001, True), (0.006, False)):
        above = above_support(exact_image(frame), [flat._replace(wave=wave / 0.7**2)], MAX_RANGE)
        assert above[labels == 1].any() == kept
