"""Lines between patches: inside one convex solid none crosses free space, between two most do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import random_planes
from solids import CAMERA, Ball, Bowl, Box, Plate, heights, solid_frame

from eyehand.perception import CameraIntrinsics, SegmentationOptions
from eyehand.perception.segmentation.free_space import STEPS, crossings
from eyehand.perception.segmentation.working_image import inverse

SMALL = CameraIntrinsics(20.0, 21.0, 8.0, 7.0, 17, 14)
OPTIONS = SegmentationOptions()


def reference(patches, pairs, hollow, q, noise, camera, options):
    """Lines of every pair, one by one, with points in space and the camera's own projection."""
    rays = camera.rays()
    found = []
    for a, b in pairs:
        ends = [np.argwhere(patches == label) for label in (a, b)]
        count = 0
        for i in range(options.line_samples):
            places = (i, (i * 1009 + 7) % options.line_samples)
            one, other = (
                pixels[(2 * k + 1) * len(pixels) // (2 * options.line_samples)]
                for k, pixels in zip(places, ends, strict=True)
            )
            if q[*one] <= 0 or q[*other] <= 0:
                continue
            start, end = rays[*one] / float(q[*one]), rays[*other] / float(q[*other])
            for t in np.arange(1, STEPS) / STEPS:
                point = start + (end - start) * t
                u, v = np.rint(camera.project(point)).astype(int)
                before = 1.0 / (point[2] + options.free_depth)
                free = q[v, u] > 0 and q[v, u] + options.plane_sigmas * noise < before
                if free and not hollow[patches[v, u]]:
                    count += 1
                    break
        found.append(count)
    return np.array(found)


@given(seed=st.integers(0, 10_000), samples=st.integers(1, 60))
@settings(max_examples=12)
def test_counts_equal_those_of_every_line(seed, samples):
    patches, q, _ = random_planes(seed, count=3)
    present = [k for k in range(1, 4) if (patches == k).any()]
    pairs = np.array([(a, b) for a in present for b in present if a < b], np.int64).reshape(-1, 2)
    hollow = np.array([False, False, True, False])
    options = SegmentationOptions(line_samples=samples)
    settings = pairs, hollow, q, 1e-3, SMALL, options
    assert np.array_equal(crossings(patches, *settings), reference(patches, *settings))


def lines(solids, plates, hollow=()):
    """Share of the lines between two solids that cross free space."""
    frame, labels = solid_frame(solids, plates)
    q = inverse(frame.depth)
    flags = np.isin(np.arange(labels.max() + 1), hollow)
    crossed = crossings(labels, np.array([[1, 2]]), flags, q, 1e-3, CAMERA, OPTIONS)[0]
    return crossed / OPTIONS.line_samples


@pytest.mark.parametrize("yaw", [0.2, 0.6, 1.0])
def test_faces_of_a_box_cross_nothing(yaw):
    frame, _ = solid_frame([Box(0.0, 0.65, (0.15, 0.12, 0.15), yaw=yaw)], plates=())
    q = inverse(frame.depth)
    height = heights(frame)
    labels = np.where(frame.valid, np.where(height > 0.149, 2, 1), 0).astype(np.int32)
    pairs = np.array([[1, 2]], np.int64)
    assert crossings(labels, pairs, np.zeros(3, bool), q, 1e-3, CAMERA, OPTIONS)[0] == 0


@pytest.mark.parametrize("plates", [(), (Plate(),)])
def test_lines_between_touching_balls_cross_free_space(plates):
    balls = [Ball(-0.06, 0.65, 0.06, 0.06), Ball(0.06, 0.65, 0.06, 0.06)]
    assert lines(balls, plates) > 3 * OPTIONS.crossing_share


def test_only_what_was_seen_behind_a_gap_proves_it():
    boxes = [Box(-0.1, 0.7, (0.1, 0.1, 0.1)), Box(0.1, 0.7, (0.1, 0.1, 0.1))]
    assert lines(boxes, (Plate(),)) == 1.0
    assert lines(boxes, ()) < OPTIONS.crossing_share


def test_one_row_of_boxes_pushed_together_crosses_nothing():
    boxes = [Box(-0.05, 0.7, (0.1, 0.1, 0.1)), Box(0.05, 0.7, (0.1, 0.1, 0.1))]
    assert lines(boxes, (Plate(),)) == 0.0


def test_a_look_past_the_wall_of_a_vessel_proves_nothing():
    bowl = Bowl(0.0, 0.65, 0.12, 0.12, 0.11)
    assert lines([bowl, bowl.inside()], (Plate(),)) > 0.9
    assert lines([bowl, bowl.inside()], (Plate(),), hollow=(2,)) == 0.0
