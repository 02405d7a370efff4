"""Tests of local planes: every window equals NumPy least squares."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import image_of
from synthetic_balls import CAMERA, ball_frame
from synthetic_solids import exact_image

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation.frame_noise import MIN_NOISE, frame_noise
from eyehand.perception.segmentation.local_planes import (
    GOOD_FIT,
    MIN_WINDOW_SHARE,
    LocalPlanes,
    fit_centred_windows,
    fit_local_planes,
    plane_normals,
    select_windows,
)


def reference(q, v, u, radius):
    """Fit a least-squares plane to one window; return value at the centre, slopes and RMS."""
    rows, columns = np.mgrid[v - radius : v + radius + 1, u - radius : u + radius + 1]
    inside = (rows >= 0) & (columns >= 0) & (rows < q.shape[0]) & (columns < q.shape[1])
    rows, columns = rows[inside], columns[inside]
    known = q[rows, columns] > 0
    rows, columns = rows[known], columns[known]
    A = np.column_stack([np.ones(rows.size), columns - u, rows - v])
    target = q[rows, columns].astype(np.float64)
    coefficients, *_ = np.linalg.lstsq(A, target, rcond=None)
    rms = np.sqrt(np.mean((A @ coefficients - target) ** 2))
    return *coefficients, rms


@given(seed=st.integers(0, 10_000), radius=st.integers(1, 4), share=st.floats(0.0, 0.5))
@settings(max_examples=30)
def test_centred_windows_equal_least_squares(seed, radius, share):
    rng = np.random.default_rng(seed)
    q = rng.uniform(0.8, 1.2, (20, 24)).astype(np.float32)
    q[rng.random(q.shape) < share] = 0.0
    value, slope_u, slope_v, rms = fit_centred_windows(q, radius, 0.5)
    fitted = np.argwhere(rms >= 0)
    for v, u in fitted[:: max(len(fitted) // 20, 1)]:
        expected = reference(q, v, u, radius)
        result = value[v, u], slope_u[v, u], slope_v[v, u], rms[v, u]
        assert np.allclose(result, expected, atol=2e-5)


def test_plane_in_space_gives_normal_and_no_noise():
    frame, labels = ball_frame([])
    image = exact_image(frame)
    planes = fit_local_planes(image, SegmentationOptions())
    normals = plane_normals(planes, CAMERA)
    inner = (planes.value > 0) & (labels == 0)
    assert frame_noise(image.disparity, 9) == MIN_NOISE
    assert np.allclose(normals[inner], [0.0, -0.8, -0.6], atol=1e-3)


def test_shifted_windows_keep_depth_step_sharp():
    q = np.full((40, 40), 1.0, np.float32)
    q[:, 20:] = 1.3
    planes = fit_local_planes(image_of(q), SegmentationOptions())
    assert np.allclose(planes.value, q, atol=1e-4)


def test_frame_noise_is_estimated():
    rng = np.random.default_rng(0)
    q = (1.0 + rng.normal(size=(120, 160)) * 0.01).astype(np.float32)
    assert frame_noise(q, 9) == pytest.approx(0.01, rel=0.05)


def reference_windows(q, planes, radius, noise, gain):
    """Return the plane of the best of nine windows per pixel, in double precision."""
    value, slope_u, slope_v, rms = (image.astype(np.float64) for image in planes)
    selected = [image.copy() for image in (value, slope_u, slope_v)]
    for v, u in np.argwhere(q > 0):
        q_here = float(q[v, u])
        costs, candidates = [], []
        for dv in (-radius, 0, radius):
            for du in (-radius, 0, radius):
                y, x = v + dv, u + du
                if 0 <= y < q.shape[0] and 0 <= x < q.shape[1] and rms[y, x] >= 0:
                    predicted = value[y, x] - slope_u[y, x] * du - slope_v[y, x] * dv
                    costs.append(rms[y, x] ** 2 + (predicted - q_here) ** 2)
                    candidates.append((predicted, slope_u[y, x], slope_v[y, x]))
        centred = rms[v, u] ** 2 + (value[v, u] - q_here) ** 2 if rms[v, u] >= 0 else np.inf
        centred_is_good = centred < GOOD_FIT * noise**2
        if costs and not centred_is_good and min(costs) < gain**2 * centred:
            for image, new in zip(selected, candidates[int(np.argmin(costs))], strict=True):
                image[v, u] = new
    return selected


@given(
    seed=st.integers(0, 10_000),
    radius=st.integers(1, 3),
    noise=st.sampled_from([0.003, 0.02]),
    gain=st.sampled_from([0.6, 0.9]),
)
@settings(max_examples=15)
def test_best_of_nine_windows_is_selected(seed, radius, noise, gain):
    rng = np.random.default_rng(seed)
    q = rng.normal(1.0, 0.01, (12, 15)).astype(np.float32)
    q[:, 7:] += 0.2
    q[rng.random(q.shape) < 0.2] = 0.0
    planes = fit_centred_windows(q, radius, 0.5)
    result = select_windows(q, LocalPlanes(*planes), radius, noise, gain)
    for image, expected in zip(
        result, reference_windows(q, planes, radius, noise, gain), strict=True
    ):
        assert np.allclose(image, expected, atol=1e-6)


def test_disabled_shift_gives_centred_windows():
    q = np.full((20, 20), 1.0, np.float32)
    q[:, 10:] = 1.3
    planes = fit_local_planes(image_of(q), SegmentationOptions(shift_windows=False))
    for image, expected in zip(
        planes[:4], fit_centred_windows(q, 4, MIN_WINDOW_SHARE), strict=True
    ):
        assert np.array_equal(image, expected)
