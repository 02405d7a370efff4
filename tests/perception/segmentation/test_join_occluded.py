"""Surfaces continued behind something nearer: votes equal a plain walk, and rules hold exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import random_planes
from solids import Ball, Box, Plate, exact_image, solid_frame

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation.join_occluded import (
    ContinuationLimits,
    continuation_votes,
    join_occluded,
)
from eyehand.perception.segmentation.local_planes import fit_local_planes

OPTIONS = SegmentationOptions().scaled(320)
WAYS = [(dv, du) for dv in (-1, 0, 1) for du in (-1, 0, 1) if (dv, du) != (0, 0)]
REACH, INSET = 12, 2
MIN_STEP, TOLERANCE, GROWTH, MAX_SLOPE = (np.float32(x) for x in (0.01, 0.03, 0.001, 0.004))
FOCAL, MAX_TURN, MAX_DENT = 20.0, np.float32(0.5), np.float32(0.05)


def lands(labels, q, planes, v, u, dv, du):
    """Label behind what hides the plane's way from (v, u), and whether it continues it, or None."""

    def inside(steps):
        y, x = v + steps * dv, u + steps * du
        return 0 <= y < q.shape[0] and 0 <= x < q.shape[1]

    def at(image, steps):
        return image[v + steps * dv, u + steps * du]

    a = labels[v, u]
    if not (inside(1) and inside(-INSET)) or at(labels, 1) == a:
        return None
    if at(labels, -INSET) != a or at(planes.value, -INSET) <= 0:
        return None
    ends = [np.array([at(image, -INSET) for image in planes[1:3]])]
    slope = float(ends[0][0]) * du + float(ends[0][1]) * dv
    start = float(at(planes.value, -INSET)) + slope * INSET
    for step in range(1, REACH):
        if not inside(step):
            return None
        seen, b = at(q, step), at(labels, step)
        if seen <= 0:
            continue
        before = seen - start - slope * step
        if before > max(float(TOLERANCE) + float(GROWTH) * (step + INSET), float(MIN_STEP)):
            if b == 0:
                return None
            continue
        way = step + INSET
        if b in (0, a) or step < 3 or not inside(way):
            return None
        if at(labels, way) != b or at(planes.value, way) <= 0:
            return None
        value = float(at(planes.value, way))
        ends.append(np.array([at(image, way) for image in planes[1:3]]))
        back = float(ends[1][0]) * du + float(ends[1][1]) * dv
        allowed = float(TOLERANCE) + float(GROWTH) * (way + INSET)
        turn = min(float(MAX_SLOPE), float(MAX_TURN) * value / FOCAL)
        return b, (
            abs(value - start - slope * way) <= allowed
            and abs(value - back * way - start) <= allowed
            and bool(np.all(np.abs(ends[1] - ends[0]) <= turn))
            and back - slope <= float(MAX_DENT) * value / FOCAL
        )
    return None


def reference(labels, q, planes, count):
    """Every pixel votes once for each label that it lands on, and once more if any way agrees."""
    votes = np.zeros((count + 1, count + 1, 2), int)
    for v, u in np.argwhere(labels > 0):
        landed = [lands(labels, q, planes, v, u, *way) for way in WAYS]
        for b in {hit[0] for hit in landed if hit}:
            votes[labels[v, u], b] += 1, any(hit == (b, True) for hit in landed)
    return votes


@given(seed=st.integers(0, 10_000), missing=st.sampled_from([0.05, 0.3]))
@settings(max_examples=12)
def test_votes_equal_a_walk_from_every_pixel(seed, missing):
    labels, q, planes = random_planes(seed, 24, 24, count=4, missing=missing)
    # One region stands before the others: most ways lead behind it.
    q[labels == 1] += np.float32(0.3)
    limits = ContinuationLimits(
        REACH, INSET, MIN_STEP, TOLERANCE, GROWTH, MAX_SLOPE, FOCAL, MAX_TURN, MAX_DENT
    )
    got = continuation_votes(labels, q, planes, 4, limits)
    assert np.array_equal(got, reference(labels, q, planes, 4))


def joined(labels, frame):
    image = exact_image(frame)
    return join_occluded(labels, image, fit_local_planes(image, OPTIONS), OPTIONS.window)[0]


def objects(labels, frame):
    """Number of objects that are left of the labels."""
    return len(np.unique(joined(labels, frame))) - 1


def cut_in_two(labels):
    """Region 1 left of the image's middle, and its part right of it as region 3."""
    right = np.arange(labels.shape[1]) > labels.shape[1] // 2
    return np.where((labels == 1) & right, 3, labels).astype(np.int32)


def test_a_box_behind_a_bar_is_one():
    bar = Box(0.0, 0.6, (0.06, 0.06, 0.35))
    frame, labels = solid_frame([Box(0.0, 0.8, (0.3, 0.08, 0.15)), bar])
    parts = cut_in_two(labels)
    whole = joined(parts, frame)
    assert set(np.unique(whole[labels == 1])) == {1}
    assert set(np.unique(whole[labels == 2])) == {2}


@pytest.mark.parametrize(
    "others",
    [
        [Ball(-0.07, 0.8, 0.06, 0.06), Ball(0.07, 0.8, 0.06, 0.06)],
        # At other depths, and of other heights, turned towards each other.
        [Box(-0.08, 0.8, (0.1, 0.08, 0.15)), Box(0.08, 0.95, (0.1, 0.08, 0.15))],
        [Box(-0.08, 0.8, (0.1, 0.1, 0.18), yaw=0.5), Box(0.08, 0.8, (0.1, 0.1, 0.1), yaw=-0.5)],
    ],
)
def test_two_solids_behind_a_third_stay_two(others):
    frame, labels = solid_frame([*others, Box(0.0, 0.6, (0.1, 0.06, 0.35))])
    assert objects(labels, frame) == 3


def test_with_the_bar_away_the_gap_is_seen_and_nothing_is_joined():
    frame, labels = solid_frame([Box(x, 0.8, (0.1, 0.08, 0.15)) for x in (-0.1, 0.1)])
    assert objects(labels, frame) == 2


def test_fewer_than_two_regions_are_left_alone():
    frame, labels = solid_frame([Ball(0.0, 0.7, 0.05, 0.05)], (Plate(),))
    for alone in (labels, np.zeros_like(labels)):
        assert np.array_equal(joined(alone, frame), alone)
