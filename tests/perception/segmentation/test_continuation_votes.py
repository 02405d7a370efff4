"""Tests of the votes on surfaces that continue behind a nearer object."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import random_planes
from synthetic_solids import Box, exact_image, solid_frame

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation.continuation_votes import (
    AGREEING,
    REACHING,
    ContinuationLimits,
    continuation_limits,
    continuation_votes,
)
from eyehand.perception.segmentation.local_planes import fit_local_planes

OPTIONS = SegmentationOptions().scaled(320)
IMAGE_DIRECTIONS = [(dv, du) for dv in (-1, 0, 1) for du in (-1, 0, 1) if (dv, du) != (0, 0)]
REACH, INSET = 12, 2
MIN_STEP, TOLERANCE, GROWTH, MAX_SLOPE = (np.float32(x) for x in (0.01, 0.03, 0.001, 0.004))
FOCAL, MAX_NORMAL_CHANGE, MAX_DENT = 20.0, np.float32(0.5), np.float32(0.05)


def find_continuation(labels, q, planes, v, u, dv, du):
    """Walk from (v, u) behind an occluding region.

    Return the label on its far side and whether this region continues the plane, or None.
    """

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
        q_here, b = at(q, step), at(labels, step)
        if q_here <= 0:
            continue
        excess = q_here - start - slope * step
        if excess > max(float(TOLERANCE) + float(GROWTH) * (step + INSET), float(MIN_STEP)):
            if b == 0:
                return None
            continue
        distance = step + INSET
        if b in (0, a) or step < 3 or not inside(distance):
            return None
        if at(labels, distance) != b or at(planes.value, distance) <= 0:
            return None
        value = float(at(planes.value, distance))
        ends.append(np.array([at(image, distance) for image in planes[1:3]]))
        back = float(ends[1][0]) * du + float(ends[1][1]) * dv
        allowed = float(TOLERANCE) + float(GROWTH) * (distance + INSET)
        max_change = min(float(MAX_SLOPE), float(MAX_NORMAL_CHANGE) * value / FOCAL)
        return b, (
            abs(value - start - slope * distance) <= allowed
            and abs(value - back * distance - start) <= allowed
            and bool(np.all(np.abs(ends[1] - ends[0]) <= max_change))
            and back - slope <= float(MAX_DENT) * value / FOCAL
        )
    return None


def reference(labels, q, planes, count):
    """Count the votes pixel by pixel.

    A pixel votes once for each label that it reaches. It votes once more when that region continues
    its plane in any direction.
    """
    votes = np.zeros((count + 1, count + 1, 2), int)
    for v, u in np.argwhere(labels > 0):
        continuations = [
            find_continuation(labels, q, planes, v, u, *direction) for direction in IMAGE_DIRECTIONS
        ]
        for b in {hit[0] for hit in continuations if hit}:
            votes[labels[v, u], b] += 1, any(hit == (b, True) for hit in continuations)
    return votes


@given(seed=st.integers(0, 10_000), missing=st.sampled_from([0.05, 0.3]))
@settings(max_examples=12)
def test_votes_equal_walk_from_every_pixel(seed, missing):
    labels, q, planes = random_planes(seed, 24, 24, count=4, missing=missing)
    # Region 1 is nearer than the others: most directions lead behind it.
    q[labels == 1] += np.float32(0.3)
    limits = ContinuationLimits(
        REACH, INSET, MIN_STEP, TOLERANCE, GROWTH, MAX_SLOPE, FOCAL, MAX_NORMAL_CHANGE, MAX_DENT
    )
    result = continuation_votes(labels, q, planes, 4, limits)
    assert np.array_equal(result, reference(labels, q, planes, 4))


def agreement(labels, frame):
    """Return the agreeing pixels of every pair of regions, and those that reach the other one."""
    image = exact_image(frame)
    count, limits = int(labels.max()), continuation_limits(image, OPTIONS.window)
    planes = fit_local_planes(image, OPTIONS)
    votes = continuation_votes(labels, image.disparity, planes, count, limits)
    votes = votes + votes.transpose(1, 0, 2)
    return votes[..., AGREEING], votes[..., REACHING]


def test_box_behind_bar_continues():
    bar = Box(0.0, 0.6, (0.06, 0.06, 0.35))
    frame, labels = solid_frame([Box(0.0, 0.8, (0.3, 0.08, 0.15)), bar])
    right = np.arange(labels.shape[1]) > labels.shape[1] // 2
    agreeing, reaching = agreement(
        np.where((labels == 1) & right, 3, labels).astype(np.int32), frame
    )
    assert agreeing[1, 3] > 20
    assert agreeing[1, 3] > 0.5 * reaching[1, 3]


@pytest.mark.parametrize(
    "solids",
    [
        # Different depths; different heights and opposite yaw.
        [Box(-0.08, 0.8, (0.1, 0.08, 0.15)), Box(0.08, 0.95, (0.1, 0.08, 0.15))],
        [Box(-0.08, 0.8, (0.1, 0.1, 0.18), yaw=0.5), Box(0.08, 0.8, (0.1, 0.1, 0.1), yaw=-0.5)],
    ],
)
def test_two_solids_behind_third_do_not_continue(solids):
    frame, labels = solid_frame([*solids, Box(0.0, 0.6, (0.1, 0.06, 0.35))])
    agreeing, reaching = agreement(labels, frame)
    assert agreeing[1, 2] <= 0.2 * max(reaching[1, 2], 1)
