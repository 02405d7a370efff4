"""Tests of free space between patches.

Lines inside one convex solid cross no free space. Most lines between two solids do.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import NOISE, image_of, random_planes
from synthetic_solids import Ball, Bowl, Box, Plate, exact_image, heights, solid_frame

from eyehand.perception import CameraIntrinsics
from eyehand.perception.segmentation.free_space import (
    FREE_DEPTH,
    FREE_SIGMAS,
    LINE_PARTS,
    count_crossings,
    count_free_lines,
)
from eyehand.perception.segmentation.label_pixels import LINES, SHUFFLE, pixels_by_label

SMALL = CameraIntrinsics(20.0, 21.0, 8.0, 7.0, 17, 14)


def reference(patches, pairs, hollow, image, lines):
    """Count the crossing lines of every pair, line by line, with points in space."""
    q, camera = image.disparity, image.intrinsics
    rays = camera.rays()
    counts = []
    for a, b in pairs:
        ends = [np.argwhere(patches == label) for label in (a, b)]
        count = 0
        for i in range(lines):
            ranks = (i, (i * SHUFFLE + 7) % lines)
            start_pixel, end_pixel = (
                pixels[(2 * k + 1) * len(pixels) // (2 * lines)]
                for k, pixels in zip(ranks, ends, strict=True)
            )
            if q[*start_pixel] <= 0 or q[*end_pixel] <= 0:
                continue
            start, end = (
                rays[*start_pixel] / float(q[*start_pixel]),
                rays[*end_pixel] / float(q[*end_pixel]),
            )
            for t in np.arange(1, LINE_PARTS) / LINE_PARTS:
                point = start + (end - start) * t
                u, v = np.rint(camera.project(point)).astype(int)
                free_limit = 1.0 / (point[2] + FREE_DEPTH)
                free = q[v, u] > 0 and q[v, u] + FREE_SIGMAS * NOISE < free_limit
                if free and not hollow[patches[v, u]]:
                    count += 1
                    break
        counts.append(count)
    return np.array(counts)


@given(seed=st.integers(0, 10_000), lines=st.integers(1, 60))
@settings(max_examples=12)
def test_crossing_counts_equal_numpy(seed, lines):
    patches, q, _ = random_planes(seed, count=3)
    present = [k for k in range(1, 4) if (patches == k).any()]
    pairs = np.array([(a, b) for a in present for b in present if a < b], np.int64).reshape(-1, 2)
    hollow = np.array([False, False, True, False])
    image = image_of(q, SMALL)
    margin = FREE_SIGMAS * image.noise
    result = count_crossings(
        pixels_by_label(patches, 3), pairs, patches, hollow, q, image.pinhole, margin, lines
    )
    assert np.array_equal(result, reference(patches, pairs, hollow, image, lines))


def crossing_share(solids, plates, hollow=()):
    """Return the share of the lines between two solids that cross free space."""
    frame, labels = solid_frame(solids, plates)
    flags = np.isin(np.arange(labels.max() + 1), hollow)
    return count_free_lines(labels, np.array([[1, 2]]), flags, exact_image(frame))[0] / LINES


@pytest.mark.parametrize("yaw", [0.2, 0.6, 1.0])
def test_lines_between_box_faces_cross_no_free_space(yaw):
    frame, _ = solid_frame([Box(0.0, 0.65, (0.15, 0.12, 0.15), yaw=yaw)], plates=())
    height = heights(frame)
    labels = np.where(frame.valid, np.where(height > 0.149, 2, 1), 0).astype(np.int32)
    pairs = np.array([[1, 2]], np.int64)
    assert count_free_lines(labels, pairs, np.zeros(3, bool), exact_image(frame))[0] == 0


@pytest.mark.parametrize("plates", [(), (Plate(),)])
def test_lines_between_touching_balls_cross_free_space(plates):
    balls = [Ball(-0.06, 0.65, 0.06, 0.06), Ball(0.06, 0.65, 0.06, 0.06)]
    assert crossing_share(balls, plates) > 0.75


def test_only_readings_behind_gap_prove_free_space():
    boxes = [Box(-0.1, 0.7, (0.1, 0.1, 0.1)), Box(0.1, 0.7, (0.1, 0.1, 0.1))]
    assert crossing_share(boxes, (Plate(),)) == 1.0
    assert crossing_share(boxes, ()) < 0.25


def test_flush_boxes_cross_no_free_space():
    boxes = [Box(-0.05, 0.7, (0.1, 0.1, 0.1)), Box(0.05, 0.7, (0.1, 0.1, 0.1))]
    assert crossing_share(boxes, (Plate(),)) == 0.0


def test_readings_inside_vessel_prove_no_free_space():
    bowl = Bowl(0.0, 0.65, 0.12, 0.12, 0.11)
    assert crossing_share([bowl, bowl.inside()], (Plate(),)) > 0.9
    assert crossing_share([bowl, bowl.inside()], (Plate(),), hollow=(2,)) == 0.0
