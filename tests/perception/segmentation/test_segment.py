"""Segmentation on exact frames: what is there is found, what is not is not."""

import doctest

import numpy as np
import pytest
from balls import CAMERA, UP, ball_frame
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

import eyehand.perception.segmentation as package
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, SegmentationOptions, segment

BALLS = [(-0.12, 0.62, 0.05), (0.0, 0.75, 0.04), (0.13, 0.6, 0.045)]


def agreement(labels, truth) -> float:
    """Smallest F of any true object with its best match."""
    scores = []
    for k in range(1, truth.max() + 1):
        mine = truth == k
        scores.append(
            max(
                2 * (mine & (labels == j)).sum() / (mine.sum() + (labels == j).sum())
                for j in range(1, labels.max() + 1)
            )
        )
    return min(scores)


def test_separate_balls_are_found_whole_and_largest_first():
    frame, truth = ball_frame(BALLS)
    found = segment(frame)
    assert found.count == 3
    assert agreement(found.labels, truth) > 0.95
    sizes = np.bincount(found.labels.ravel())[1:]
    assert np.all(np.diff(sizes) <= 0)
    assert found.labels.dtype == np.int32
    assert all(seconds >= 0 for seconds in found.timings.values())


def test_the_support_plane_is_the_table():
    frame, _ = ball_frame(BALLS)
    support = segment(frame).support
    assert support is not None
    assert support.normal @ UP > 0.9999
    assert support.offset == pytest.approx(0.6, abs=1e-3)
    points = frame.points()[frame.valid]
    assert np.median(np.abs(support.height(points))) < 1e-3


def test_an_empty_table_holds_no_object_at_any_noise():
    frame, _ = ball_frame([])
    for seed, sigma in enumerate((0.0, 0.0005, 0.001, 0.002)):
        rng = np.random.default_rng(seed)
        depth = frame.depth + rng.normal(size=frame.depth.shape) * sigma * frame.depth**2
        noisy = DepthFrame(np.where(frame.valid, depth, 0).astype(np.float32), CAMERA)
        assert segment(noisy).count == 0


def test_two_touching_balls_are_two():
    frame, truth = ball_frame([(-0.045, 0.6, 0.045), (0.045, 0.6, 0.045)])
    found = segment(frame)
    assert found.count == 2
    assert agreement(found.labels, truth) > 0.9


def test_a_ball_without_a_table_is_one_object():
    frame, truth = ball_frame([(0.0, 0.6, 0.05)], table=False)
    found = segment(frame)
    assert found.count == 1
    assert agreement(found.labels, truth) > 0.9


def test_mirroring_the_frame_mirrors_the_labels():
    frame, _ = ball_frame(BALLS)
    mirror = CameraIntrinsics(260.0, 260.0, 319 - 159.5, 119.5, 320, 240)
    mirrored = DepthFrame(np.ascontiguousarray(frame.depth[:, ::-1]), mirror)
    here, there = segment(frame).labels, segment(mirrored).labels[:, ::-1]
    assert here.max() == there.max()
    for k in range(1, here.max() + 1):
        mine, other = here == k, there == k
        assert 2 * (mine & other).sum() / (mine.sum() + other.sum()) > 0.97


def test_gravity_rejects_a_wall_that_fills_the_view():
    frame, _ = ball_frame([(0.0, 0.6, 0.05)])
    # A world whose up is the table's normal keeps the table; one turned by 90° loses it.
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
def test_random_frames_of_any_size_give_finite_results(seed, height, width, share):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.3, 2.0, (height, width)).astype(np.float32)
    depth[rng.random((height, width)) < share] = 0.0
    depth[0, 0] = 1.0
    camera = CameraIntrinsics(50.0, 50.0, width / 2, height / 2, width, height)
    found = segment(DepthFrame(depth, camera), SegmentationOptions(min_object=1))
    assert found.labels.shape == (height, width)
    assert found.labels.min() >= 0
    assert np.isfinite(found.noise)
    assert set(np.unique(found.labels)) <= set(range(found.count + 1))


@pytest.mark.parametrize(
    "bad", [{"window": 8}, {"window": 1}, {"max_range": 0.0}, {"min_object": -1}]
)
def test_impossible_options_are_refused(bad):
    with pytest.raises(InputError):
        SegmentationOptions(**bad)


def test_example_of_the_package_runs():
    assert doctest.testmod(package).failed == 0
