"""Segmentation over its dials: stride, threads, reach, size, and frames that hold nothing."""

import numpy as np
import pytest
from solids import Ball, Box, Plate, solid_frame

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, SegmentationOptions, segment
from eyehand.perception.segmentation.frame_noise import MIN_NOISE

SOLIDS = [
    Box(-0.14, 0.62, (0.1, 0.1, 0.12), yaw=0.6),
    Ball(0.03, 0.75, 0.06, 0.06),
    Box(0.17, 0.6, (0.09, 0.09, 0.09), yaw=1.0),
]
LARGE = CameraIntrinsics(520.0, 520.0, 319.5, 239.5, 640, 480)
ALONE = CameraIntrinsics(40.0, 40.0, 15.5, 11.5, 32, 24)


def least_overlap(labels, truth):
    """Smallest intersection over union of a true object with the one that covers it most."""
    scores = []
    for k in range(1, truth.max() + 1):
        mine = truth == k
        found = labels == np.bincount(labels[mine]).argmax()
        scores.append((mine & found).sum() / (mine | found).sum())
    return min(scores)


@pytest.mark.parametrize("stride", [1, 2, 3])
def test_every_stride_finds_the_same_objects_at_full_size(stride):
    frame, truth = solid_frame(SOLIDS, camera=LARGE)
    found = segment(frame, SegmentationOptions(stride=stride))
    assert found.labels.shape == frame.depth.shape
    assert found.count == 3
    assert least_overlap(found.labels, truth) > 0.94
    assert not found.labels[~frame.valid].any()
    assert ("upsample" in found.timings) == (stride > 1)
    assert found.support is not None
    assert found.support.offset == pytest.approx(0.6, abs=1e-3)


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_nothing(threads):
    rng = np.random.default_rng(3)
    frame, _ = solid_frame(SOLIDS)
    noise = 0.001 * rng.normal(size=frame.depth.shape) * frame.depth**2
    frame = DepthFrame(np.where(frame.valid, frame.depth + noise, 0.0), frame.intrinsics)
    one, several = segment(frame), segment(frame, SegmentationOptions(threads=threads))
    assert one.count == 3
    assert one.noise == several.noise
    # Sums in bands start elsewhere: their rounding may move single pixels at an outline.
    assert np.mean(one.labels != several.labels) < 1e-3


def test_a_wall_is_no_object_and_a_reach_ends_the_world():
    wall = Box(0.0, 1.2, (3.0, 0.1, 2.0))
    frame, truth = solid_frame([*SOLIDS, wall])
    found = segment(frame)
    assert found.count == 3
    assert not found.labels[truth == 4].any()
    assert segment(frame, SegmentationOptions(max_range=0.4)).count == 0


def test_what_is_larger_than_the_largest_object_is_none():
    frame, truth = solid_frame(SOLIDS)
    assert segment(frame, SegmentationOptions(max_extent=0.1)).count == 0
    small = segment(frame, SegmentationOptions(max_extent=0.17))
    assert small.count == 1
    assert set(np.unique(truth[small.labels > 0])) == {2}


def test_objects_on_a_table_and_on_a_shelf_are_found_together():
    table, shelf = Plate((-0.4, 0.4), (0.3, 0.8)), Plate((-0.5, 0.5), (0.95, 1.5), 0.25)
    frame, truth = solid_frame(
        [Box(0.0, 0.6, (0.1, 0.1, 0.1)), Ball(-0.2, 1.1, 0.32, 0.07)], (table, shelf)
    )
    found = segment(frame)
    assert found.count == 2
    assert least_overlap(found.labels, truth) > 0.85
    assert found.support is not None
    assert found.support.offset == pytest.approx(0.6, abs=1e-3)


def test_an_empty_table_has_no_candidates_and_no_later_stages():
    frame, _ = solid_frame([])
    found = segment(frame)
    assert found.count == 0
    assert found.labels.shape == frame.depth.shape
    assert list(found.timings) == ["image", "noise", "support", "candidates"]
    assert found.boxes() == {}


def test_a_frame_without_readings_is_refused_before_any_stage():
    with pytest.raises(InputError, match="no reading"):
        segment(DepthFrame(np.zeros((24, 32), np.float32), ALONE))


@pytest.mark.parametrize("at", [(0, 0), (12, 18), (23, 31)])
def test_one_reading_is_no_object(at):
    depth = np.zeros((24, 32), np.float32)
    depth[at] = 1.0
    found = segment(DepthFrame(depth, ALONE))
    assert found.count == 0
    assert found.support is None
    assert found.noise == MIN_NOISE


def test_one_pixel_is_no_object():
    camera = CameraIntrinsics(40.0, 40.0, 0.0, 0.0, 1, 1)
    for stride in (1, 3):
        found = segment(
            DepthFrame(np.ones((1, 1), np.float32), camera), SegmentationOptions(stride=stride)
        )
        assert found.labels.tolist() == [[0]]


def test_a_stride_past_the_image_leaves_one_pixel():
    depth = np.ones((24, 32), np.float32)
    found = segment(DepthFrame(depth, ALONE), SegmentationOptions(stride=100))
    assert found.labels.shape == (24, 32)
    assert found.count == 0


def test_the_frame_itself_is_not_touched():
    frame, _ = solid_frame(SOLIDS)
    before = frame.depth.copy()
    segment(frame, SegmentationOptions(stride=2, threads=2))
    assert np.array_equal(frame.depth, before)
