"""Border votes equal a plain count over pixel pairs, and convex neighbours become one object."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import random_planes
from solids import Ball, Box, exact_image, heights, solid_frame

from eyehand.perception import CameraIntrinsics, SegmentationOptions
from eyehand.perception.segmentation.local_planes import fit_local_planes, plane_normals
from eyehand.perception.segmentation.merge_patches import BorderLimits, border_votes, merge_patches

CAMERA = CameraIntrinsics(20.0, 21.0, 8.0, 7.0, 17, 14)
OPTIONS = SegmentationOptions().scaled(320)


def reference(patches, q, planes, camera, limits, reach):
    """Pairs and votes of all neighbours to the right and below, row by row."""
    max_step, max_crease, clear_bend = map(float, limits)
    normals = plane_normals(planes, camera).astype(float)
    value, slope_u, slope_v, q = (
        image.astype(float) for image in (planes.value, planes.slope_u, planes.slope_v, q)
    )
    pairs, votes = [], []
    for here in np.argwhere(patches > 0):
        for way in ([0, 1], [1, 0]):
            there, slope = here + way, slope_u if way[1] else slope_v
            if np.any(there >= patches.shape):
                continue
            i, j = tuple(here), tuple(there)
            a, b = patches[i], patches[j]
            if b == 0 or a == b:
                continue
            pairs.append((min(a, b), max(a, b)))
            votes.append([1.0, 0.0, 0.0, 0.0])
            if value[i] <= 0 or value[j] <= 0:
                continue
            misses = [q[j] - q[i] - slope[i], q[j] - q[i] - slope[j]]
            granted = min(abs(slope[j] - slope[i]), max_crease)
            if abs(misses[0]) + abs(misses[1]) - granted >= max_step:
                continue
            votes[-1][1] = 1.0
            before, after = here - reach * np.array(way), there + reach * np.array(way)
            if np.any(before < 0) or np.any(after >= patches.shape):
                continue
            if patches[tuple(before)] != a or patches[tuple(after)] != b:
                continue
            second = q[tuple(before)] + q[tuple(after)] - q[i] - q[j]
            rise = slope_u[j] - slope_u[i], slope_v[j] - slope_v[i]
            share = abs(slope[j] - slope[i]) / np.hypot(*rise)
            weight = min(abs(second) / clear_bend, 1.0) * share
            cosine = np.clip(normals[i] @ normals[j], -1.0, 1.0)
            votes[-1][2:] = weight, np.arccos(cosine) * weight * np.sign(second)
    return np.array(pairs).reshape(-1, 2), np.array(votes).reshape(-1, 4)


@given(seed=st.integers(0, 10_000), reach=st.integers(1, 3), count=st.integers(1, 5))
@settings(max_examples=15)
def test_votes_equal_those_of_every_pair_of_pixels(seed, reach, count):
    patches, q, planes = random_planes(seed, count=count, missing=0.05)
    limits = np.float32(0.02), np.float32(0.004), np.float32(0.003)
    pinhole = CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy
    pairs, votes = border_votes(patches, q, planes, pinhole, BorderLimits(*limits, reach))
    expected = reference(patches, q, planes, CAMERA, limits, reach)
    assert np.array_equal(pairs, expected[0])
    assert np.array_equal(votes[:, :2], expected[1][:, :2])
    assert np.allclose(votes[:, 2:], expected[1][:, 2:], atol=2e-3)


def merged(solids, parts=lambda labels, points: labels):
    """Objects that become of the parts of exact solids; `parts` cuts them."""
    frame, labels = solid_frame(solids)
    height = heights(frame)
    patches = parts(labels, np.dstack([frame.points()[..., 0], height])).astype(np.int32)
    image = exact_image(frame)
    planes = fit_local_planes(image, OPTIONS)
    objects, _ = merge_patches(patches, image, planes, OPTIONS.min_object)
    assert np.array_equal(objects > 0, patches > 0)
    return [set(np.unique(objects[patches == k])) for k in range(1, patches.max() + 1)]


@pytest.mark.parametrize("yaw", [0.0, 0.3, 0.7])
def test_the_faces_of_a_box_are_one_object(yaw):
    box = Box(0.0, 0.65, (0.15, 0.15, 0.12), yaw=yaw)
    faces = merged([box], lambda labels, at: labels * (1 + (at[..., 1] > 0.119)))
    assert len(faces) == 2
    assert faces[0] == faces[1]


def test_halves_of_a_ball_are_one_object():
    ball = Ball(0.0, 0.65, 0.1, 0.1)
    left, right = merged([ball], lambda labels, at: labels * (1 + (at[..., 0] > 0.02)))
    assert left == right


@pytest.mark.parametrize(
    "solids",
    [
        # A concave border, free space between, and a step in depth.
        [Box(0.0, 0.8, (0.3, 0.05, 0.2)), Box(0.0, 0.7, (0.3, 0.15, 0.05))],
        [Ball(-0.06, 0.65, 0.06, 0.06), Ball(0.06, 0.65, 0.06, 0.06)],
        [Box(0.0, 0.6, (0.1, 0.1, 0.15)), Box(0.05, 0.9, (0.2, 0.1, 0.2))],
    ],
)
def test_two_solids_stay_two(solids):
    one, other = merged(solids)
    assert not one & other


def test_one_patch_or_none_is_left_alone():
    frame, labels = solid_frame([Ball(0.0, 0.65, 0.1, 0.1)])
    image = exact_image(frame)
    planes = fit_local_planes(image, OPTIONS)
    for patches in (labels, np.zeros_like(labels)):
        objects, _ = merge_patches(patches, image, planes, OPTIONS.min_object)
        assert np.array_equal(objects, patches)
