"""Test that the votes of a border equal a count over pixel pairs."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import random_planes

from eyehand.perception import CameraIntrinsics
from eyehand.perception.segmentation.border_votes import (
    BorderLimits,
    border_votes,
    sum_border_votes,
)
from eyehand.perception.segmentation.local_planes import plane_normals

CAMERA = CameraIntrinsics(20.0, 21.0, 8.0, 7.0, 17, 14)


def reference(patches, q, planes, camera, limits, reach):
    """Return pairs and votes of all neighbours to the right and below, in row order."""
    max_step, max_crease, clear_bend = map(float, limits)
    normals = plane_normals(planes, camera).astype(float)
    value, slope_u, slope_v, q = (
        image.astype(float) for image in (planes.value, planes.slope_u, planes.slope_v, q)
    )
    pairs, votes = [], []
    for pixel in np.argwhere(patches > 0):
        for direction in ([0, 1], [1, 0]):
            neighbour, slope = pixel + direction, slope_u if direction[1] else slope_v
            if np.any(neighbour >= patches.shape):
                continue
            i, j = tuple(pixel), tuple(neighbour)
            a, b = patches[i], patches[j]
            if b == 0 or a == b:
                continue
            pairs.append((min(a, b), max(a, b)))
            votes.append([1.0, 0.0, 0.0, 0.0])
            if value[i] <= 0 or value[j] <= 0:
                continue
            errors = [q[j] - q[i] - slope[i], q[j] - q[i] - slope[j]]
            allowance = min(abs(slope[j] - slope[i]), max_crease)
            if abs(errors[0]) + abs(errors[1]) - allowance >= max_step:
                continue
            votes[-1][1] = 1.0
            behind, beyond = (
                pixel - reach * np.array(direction),
                neighbour + reach * np.array(direction),
            )
            if np.any(behind < 0) or np.any(beyond >= patches.shape):
                continue
            if patches[tuple(behind)] != a or patches[tuple(beyond)] != b:
                continue
            second = q[tuple(behind)] + q[tuple(beyond)] - q[i] - q[j]
            rise = slope_u[j] - slope_u[i], slope_v[j] - slope_v[i]
            share = abs(slope[j] - slope[i]) / np.hypot(*rise)
            weight = min(abs(second) / clear_bend, 1.0) * share
            cosine = np.clip(normals[i] @ normals[j], -1.0, 1.0)
            votes[-1][2:] = weight, np.arccos(cosine) * weight * np.sign(second)
    return np.array(pairs).reshape(-1, 2), np.array(votes).reshape(-1, 4)


@given(seed=st.integers(0, 10_000), reach=st.integers(1, 3), count=st.integers(1, 5))
@settings(max_examples=15)
def test_border_votes_equal_count_over_pixel_pairs(seed, reach, count):
    patches, q, planes = random_planes(seed, count=count, missing=0.05)
    limits = np.float32(0.02), np.float32(0.004), np.float32(0.003)
    pinhole = CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy
    everything = np.ones(patches.max() + 1, bool)
    bounds = BorderLimits(*limits, reach)
    pairs, votes = border_votes(patches, everything, q, planes, pinhole, bounds)
    expected = reference(patches, q, planes, CAMERA, limits, reach)
    assert np.array_equal(pairs, expected[0])
    assert np.array_equal(votes[:, :2], expected[1][:, :2])
    assert np.allclose(votes[:, 2:], expected[1][:, 2:], atol=2e-3)


def test_votes_of_equal_pairs_are_summed():
    rng = np.random.default_rng(0)
    pairs = np.sort(rng.integers(1, 6, (60, 2)), axis=1)
    votes = rng.random((60, 4)).astype(np.float32)
    summed, sums = sum_border_votes(pairs, votes, 6)
    different = np.unique(pairs, axis=0)
    assert np.array_equal(summed, different)
    for pair, total in zip(different, sums, strict=True):
        assert np.allclose(total, votes[(pairs == pair).all(axis=1)].sum(axis=0))
