"""Tests of segmentation options (stride, threads, range, size) and of empty frames."""

import numpy as np
import pytest
from synthetic_solids import Ball, Box, Plate, solid_frame

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, SegmentationOptions, segment
from eyehand.perception.segmentation.frame_noise import MIN_NOISE

SOLIDS = [
    Box(-0.14, 0.62, (0.1, 0.1, 0.12), yaw=0.6),
    Ball(0.03, 0.75, 0.06, 0.06),
    Box(0.17, 0.6, (0.09, 0.09, 0.09), yaw=1.0),
]
LARGE = CameraIntrinsics(520.0, 520.0, 319.5, 239.5, 640, 480)
SMALL = CameraIntrinsics(40.0, 40.0, 15.5, 11.5, 32, 24)


def min_overlap(labels, truth):
    """Return the smallest IoU of a true object with the object that covers it most."""
    scores = []
    for k in range(1, truth.max() + 1):
        true_mask = truth == k
        mask = labels == np.bincount(labels[true_mask]).argmax()
        scores.append((true_mask & mask).sum() / (true_mask | mask).sum())
    return min(scores)


@pytest.mark.parametrize("stride", [1, 2, 3])
def test_strides_give_same_objects_at_full_size(stride):
    frame, truth = solid_frame(SOLIDS, camera=LARGE)
    segmentation = segment(frame, SegmentationOptions(stride=stride))
    assert segmentation.labels.shape == frame.depth.shape
    assert segmentation.count == 3
    assert min_overlap(segmentation.labels, truth) > 0.94
    assert not segmentation.labels[~frame.valid].any()
    assert ("upsample" in segmentation.timings) == (stride > 1)
    assert segmentation.support is not None
    assert segmentation.support.offset == pytest.approx(0.6, abs=1e-3)


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_give_same_objects(threads):
    rng = np.random.default_rng(3)
    frame, _ = solid_frame(SOLIDS)
    noise = 0.001 * rng.normal(size=frame.depth.shape) * frame.depth**2
    frame = DepthFrame(np.where(frame.valid, frame.depth + noise, 0.0), frame.intrinsics)
    single, several = segment(frame), segment(frame, SegmentationOptions(threads=threads))
    assert single.count == 3
    assert single.noise == several.noise
    # Running sums start at each band. Their rounding can move single pixels at an outline.
    assert np.mean(single.labels != several.labels) < 1e-3


def test_wall_is_no_object_and_max_range_limits_candidates():
    wall = Box(0.0, 1.2, (3.0, 0.1, 2.0))
    frame, truth = solid_frame([*SOLIDS, wall])
    segmentation = segment(frame)
    assert segmentation.count == 3
    assert not segmentation.labels[truth == 4].any()
    assert segment(frame, SegmentationOptions(max_range=0.4)).count == 0


def test_region_larger_than_max_extent_is_dropped():
    frame, truth = solid_frame(SOLIDS)
    assert segment(frame, SegmentationOptions(max_extent=0.1)).count == 0
    small = segment(frame, SegmentationOptions(max_extent=0.17))
    assert small.count == 1
    assert set(np.unique(truth[small.labels > 0])) == {2}


def test_objects_on_table_and_shelf_are_segmented():
    table, shelf = Plate((-0.4, 0.4), (0.3, 0.8)), Plate((-0.5, 0.5), (0.95, 1.5), 0.25)
    frame, truth = solid_frame(
        [Box(0.0, 0.6, (0.1, 0.1, 0.1)), Ball(-0.2, 1.1, 0.32, 0.07)], (table, shelf)
    )
    segmentation = segment(frame)
    assert segmentation.count == 2
    assert min_overlap(segmentation.labels, truth) > 0.85
    assert segmentation.support is not None
    assert segmentation.support.offset == pytest.approx(0.6, abs=1e-3)


def test_empty_table_skips_later_stages():
    frame, _ = solid_frame([])
    segmentation = segment(frame)
    assert segmentation.count == 0
    assert segmentation.labels.shape == frame.depth.shape
    stages = ["image", "noise", "support", "containers", "unknown", "candidates"]
    assert list(segmentation.timings) == stages
    assert segmentation.boxes() == {}


def test_frame_without_readings_is_rejected():
    with pytest.raises(InputError, match="no reading"):
        segment(DepthFrame(np.zeros((24, 32), np.float32), SMALL))


@pytest.mark.parametrize("pixel", [(0, 0), (12, 18), (23, 31)])
def test_single_reading_is_no_object(pixel):
    depth = np.zeros((24, 32), np.float32)
    depth[pixel] = 1.0
    segmentation = segment(DepthFrame(depth, SMALL))
    assert segmentation.count == 0
    assert segmentation.support is None
    assert segmentation.noise == MIN_NOISE


def test_single_pixel_frame_has_no_object():
    camera = CameraIntrinsics(40.0, 40.0, 0.0, 0.0, 1, 1)
    for stride in (1, 3):
        segmentation = segment(
            DepthFrame(np.ones((1, 1), np.float32), camera), SegmentationOptions(stride=stride)
        )
        assert segmentation.labels.tolist() == [[0]]


def test_stride_beyond_image_size_is_accepted():
    depth = np.ones((24, 32), np.float32)
    segmentation = segment(DepthFrame(depth, SMALL), SegmentationOptions(stride=100))
    assert segmentation.labels.shape == (24, 32)
    assert segmentation.count == 0


def test_input_frame_is_not_modified():
    frame, _ = solid_frame(SOLIDS)
    before = frame.depth.copy()
    segment(frame, SegmentationOptions(stride=2, threads=2))
    assert np.array_equal(frame.depth, before)


def test_wide_frames_are_reduced():
    camera = CameraIntrinsics(1050.0, 1050.0, 640.0, 360.0, 1280, 720)
    frame, truth = solid_frame([Ball(0.0, 0.7, 0.05, 0.05)], (Plate(),), camera)
    segmentation = segment(frame)
    assert "upsample" in segmentation.timings
    assert segmentation.labels.shape == truth.shape
    both = np.count_nonzero((segmentation.labels > 0) & (truth > 0))
    assert 2 * both / (np.count_nonzero(segmentation.labels) + np.count_nonzero(truth)) > 0.97
