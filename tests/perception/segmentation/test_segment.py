"""Tests of segmentation on exact frames."""

import doctest

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation
from synthetic_balls import CAMERA, UP, ball_frame
from synthetic_solids import Box, Plate, solid_frame

import eyehand.perception.segmentation as package
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, SegmentationOptions, segment

BALLS = [(-0.12, 0.62, 0.05), (0.0, 0.75, 0.04), (0.13, 0.6, 0.045)]


def min_f_score(labels, truth) -> float:
    """Return the smallest F score of a true object with its best match."""
    scores = []
    for k in range(1, truth.max() + 1):
        true_mask = truth == k
        scores.append(
            max(
                2 * (true_mask & (labels == j)).sum() / (true_mask.sum() + (labels == j).sum())
                for j in range(1, labels.max() + 1)
            )
        )
    return min(scores)


def test_separate_balls_are_segmented_largest_first():
    frame, truth = ball_frame(BALLS)
    segmentation = segment(frame)
    assert segmentation.count == 3
    assert min_f_score(segmentation.labels, truth) > 0.95
    sizes = np.bincount(segmentation.labels.ravel())[1:]
    assert np.all(np.diff(sizes) <= 0)
    assert segmentation.labels.dtype == np.int32
    assert all(seconds >= 0 for seconds in segmentation.timings.values())


@pytest.mark.parametrize("thickness", [0.003, 0.005])
def test_thin_plate_is_found_by_a_clean_camera(thickness):
    plate = Box(0.0, 0.65, (0.1, 0.08, thickness))
    frame, truth = solid_frame([plate], (Plate(),))
    noisy = frame.depth + 0.00025 * np.random.default_rng(0).normal(size=frame.depth.shape)
    depth = np.where(frame.valid, noisy, 0.0).astype(np.float32)
    labels = segment(DepthFrame(depth, frame.intrinsics)).labels
    assert labels.max() == 1
    assert min_f_score(labels, truth) > 0.9


@pytest.mark.parametrize("share", [0.4, 0.6])
def test_dark_objects_stay_whole(share):
    frame, truth = ball_frame(BALLS)
    lost = (truth > 0) & (np.random.default_rng(0).random(truth.shape) < share)
    depth = np.where(lost, np.float32(0.0), frame.depth)
    labels = segment(DepthFrame(depth, frame.intrinsics)).labels
    assert labels.max() == 3
    assert not labels[depth == 0].any()
    assert min_f_score(labels, np.where(lost, 0, truth)) > 0.9


def test_support_plane_is_table():
    frame, _ = ball_frame(BALLS)
    support = segment(frame).support
    assert support is not None
    assert support.normal @ UP > 0.9999
    assert support.offset == pytest.approx(0.6, abs=1e-3)
    points = frame.points()[frame.valid]
    assert np.median(np.abs(support.height(points))) < 1e-3


def test_empty_table_has_no_object_at_any_noise():
    frame, _ = ball_frame([])
    for seed, sigma in enumerate((0.0, 0.0005, 0.001, 0.002)):
        rng = np.random.default_rng(seed)
        depth = frame.depth + rng.normal(size=frame.depth.shape) * sigma * frame.depth**2
        noisy = DepthFrame(np.where(frame.valid, depth, 0).astype(np.float32), CAMERA)
        assert segment(noisy).count == 0


def test_touching_balls_are_two_objects():
    frame, truth = ball_frame([(-0.045, 0.6, 0.045), (0.045, 0.6, 0.045)])
    segmentation = segment(frame)
    assert segmentation.count == 2
    assert min_f_score(segmentation.labels, truth) > 0.9


def test_ball_without_table_is_one_object():
    frame, truth = ball_frame([(0.0, 0.6, 0.05)], table=False)
    segmentation = segment(frame)
    assert segmentation.count == 1
    assert min_f_score(segmentation.labels, truth) > 0.9


def test_mirrored_frame_gives_mirrored_labels():
    frame, _ = ball_frame(BALLS)
    mirror = CameraIntrinsics(260.0, 260.0, 319 - 159.5, 119.5, 320, 240)
    mirrored = DepthFrame(np.ascontiguousarray(frame.depth[:, ::-1]), mirror)
    labels, mirrored_labels = segment(frame).labels, segment(mirrored).labels[:, ::-1]
    assert labels.max() == mirrored_labels.max()
    for k in range(1, labels.max() + 1):
        mask, mirrored_mask = labels == k, mirrored_labels == k
        assert 2 * (mask & mirrored_mask).sum() / (mask.sum() + mirrored_mask.sum()) > 0.97


def test_gravity_rejects_wall_as_support():
    frame, _ = ball_frame([(0.0, 0.6, 0.05)])
    # With the world's z along the table normal the table is kept. Rotated by 90° it is lost.
    upright = Rotation.align_vectors([[0.0, 0.0, 1.0]], [UP])[0]
    kept = DepthFrame(frame.depth, CAMERA, RigidTransform.from_rotation(upright))
    lost = DepthFrame(
        frame.depth,
        CAMERA,
        RigidTransform.from_rotation(Rotation.from_euler("y", 90, degrees=True) * upright),
    )
    assert segment(kept).support is not None
    assert segment(lost).support is None


@given(
    seed=st.integers(0, 10_000),
    height=st.integers(1, 40),
    width=st.integers(1, 40),
    share=st.floats(0.0, 1.0),
)
@settings(max_examples=40)
def test_random_frames_give_finite_results(seed, height, width, share):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.3, 2.0, (height, width)).astype(np.float32)
    depth[rng.random((height, width)) < share] = 0.0
    depth[0, 0] = 1.0
    camera = CameraIntrinsics(50.0, 50.0, width / 2, height / 2, width, height)
    segmentation = segment(DepthFrame(depth, camera), SegmentationOptions(min_object=1))
    assert segmentation.labels.shape == (height, width)
    assert segmentation.labels.min() >= 0
    assert np.isfinite(segmentation.noise)
    assert set(np.unique(segmentation.labels)) <= set(range(segmentation.count + 1))


@pytest.mark.parametrize(
    "invalid", [{"window": 8}, {"window": 1}, {"max_range": 0.0}, {"min_object": -1}]
)
def test_invalid_options_are_rejected(invalid):
    with pytest.raises(InputError):
        SegmentationOptions(**invalid)


def test_package_doctest_passes():
    assert doctest.testmod(package).failed == 0
