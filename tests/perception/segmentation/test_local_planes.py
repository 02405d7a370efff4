"""The compiled plane fit equals plain NumPy least squares, window by window."""

import numpy as np
import pytest
from balls import CAMERA, ball_frame
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import image_of
from solids import exact_image

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
    """Least-squares plane of one window: value at its centre, slopes, rms."""
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
def test_running_sums_equal_least_squares(seed, radius, share):
    rng = np.random.default_rng(seed)
    q = rng.uniform(0.8, 1.2, (20, 24)).astype(np.float32)
    q[rng.random(q.shape) < share] = 0.0
    value, slope_u, slope_v, rms = fit_centred_windows(q, radius, 0.5)
    fitted = np.argwhere(rms >= 0)
    for v, u in fitted[:: max(len(fitted) // 20, 1)]:
        expected = reference(q, v, u, radius)
        got = value[v, u], slope_u[v, u], slope_v[v, u], rms[v, u]
        assert np.allclose(got, expected, atol=2e-5)


def test_a_plane_in_space_gives_its_normal_and_no_residual():
    frame, labels = ball_frame([])
    image = exact_image(frame)
    planes = fit_local_planes(image, SegmentationOptions())
    normals = plane_normals(planes, CAMERA)
    inner = (planes.value > 0) & (labels == 0)
    assert frame_noise(image.disparity, 9) == MIN_NOISE
    assert np.allclose(normals[inner], [0.0, -0.8, -0.6], atol=1e-3)


def test_shifted_windows_keep_a_step_sharp():
    q = np.full((40, 40), 1.0, np.float32)
    q[:, 20:] = 1.3
    planes = fit_local_planes(image_of(q), SegmentationOptions())
    assert np.allclose(planes.value, q, atol=1e-4)


def test_noise_is_measured_on_the_frame():
    rng = np.random.default_rng(0)
    q = (1.0 + rng.normal(size=(120, 160)) * 0.01).astype(np.float32)
    assert frame_noise(q, 9) == pytest.approx(0.01, rel=0.05)


def reference_windows(q, planes, radius, noise, gain):
    """The plane of the best of nine windows per pixel, all windows tried in double precision."""
    value, slope_u, slope_v, rms = (image.astype(np.float64) for image in planes)
    chosen = [image.copy() for image in (value, slope_u, slope_v)]
    for v, u in np.argwhere(q > 0):
        here = float(q[v, u])
        costs, found = [], []
        for dv in (-radius, 0, radius):
            for du in (-radius, 0, radius):
                y, x = v + dv, u + du
                if 0 <= y < q.shape[0] and 0 <= x < q.shape[1] and rms[y, x] >= 0:
                    at = value[y, x] - slope_u[y, x] * du - slope_v[y, x] * dv
                    costs.append(rms[y, x] ** 2 + (at - here) ** 2)
                    found.append((at, slope_u[y, x], slope_v[y, x]))
        centred = rms[v, u] ** 2 + (value[v, u] - here) ** 2 if rms[v, u] >= 0 else np.inf
        settled = centred < GOOD_FIT * noise**2
        if costs and not settled and min(costs) < gain**2 * centred:
            for image, new in zip(chosen, found[int(np.argmin(costs))], strict=True):
                image[v, u] = new
    return chosen


@given(
    seed=st.integers(0, 10_000),
    radius=st.integers(1, 3),
    noise=st.sampled_from([0.003, 0.02]),
    gain=st.sampled_from([0.6, 0.9]),
)
@settings(max_examples=15)
def test_the_best_of_nine_windows_is_taken(seed, radius, noise, gain):
    rng = np.random.default_rng(seed)
    q = rng.normal(1.0, 0.01, (12, 15)).astype(np.float32)
    q[:, 7:] += 0.2
    q[rng.random(q.shape) < 0.2] = 0.0
    planes = fit_centred_windows(q, radius, 0.5)
    got = select_windows(q, LocalPlanes(*planes), radius, noise, gain)
    for mine, other in zip(got, reference_windows(q, planes, radius, noise, gain), strict=True):
        assert np.allclose(mine, other, atol=1e-6)


def test_without_shifted_windows_every_plane_is_the_centred_one():
    q = np.full((20, 20), 1.0, np.float32)
    q[:, 10:] = 1.3
    planes = fit_local_planes(image_of(q), SegmentationOptions(shift_windows=False))
    for mine, other in zip(planes[:4], fit_centred_windows(q, 4, MIN_WINDOW_SHARE), strict=True):
        assert np.array_equal(mine, other)
