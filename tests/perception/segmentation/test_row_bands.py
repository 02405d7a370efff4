"""Tests of running kernels in row bands: the result equals one call on the whole image."""

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import image_of

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation.local_planes import (
    MIN_ROWS,
    fit_local_planes,
    run_in_row_bands,
)


def row_sums(reach):
    """Return a kernel that sums every row with the rows within `reach`."""

    def kernel(image, column_source):
        padded = np.pad(image, ((reach, reach), (0, 0)))
        around = [padded[k : k + image.shape[0]] for k in range(2 * reach + 1)]
        return np.sum(around, axis=0), column_source[:, 0]

    return kernel


@given(
    rows=st.integers(1, 5 * MIN_ROWS),
    threads=st.integers(1, 5),
    reach=st.integers(0, 7),
    seed=st.integers(0, 100),
)
@settings(max_examples=30)
def test_bands_equal_single_call(rows, threads, reach, seed):
    images = tuple(np.random.default_rng(seed).integers(0, 1000, (2, rows, 3)))
    expected = row_sums(reach)(*images)
    for result, expected_image in zip(
        run_in_row_bands(row_sums(reach), images, reach, threads), expected, strict=True
    ):
        assert np.array_equal(result, expected_image)


@pytest.mark.parametrize(
    ("rows", "threads", "bands"),
    [(2 * MIN_ROWS - 1, 4, 1), (2 * MIN_ROWS, 4, 2), (3 * MIN_ROWS, 2, 2), (3 * MIN_ROWS, 9, 3)],
)
def test_band_count_is_limited_by_threads_and_min_rows(rows, threads, bands):
    calls = []

    def kernel(image):
        calls.append((threading.current_thread(), len(image)))
        return (image,)

    run_in_row_bands(kernel, (np.zeros((rows, 2)),), 1, threads)
    assert len(calls) == bands
    assert len({thread for thread, _ in calls} - {threading.main_thread()}) <= bands - 1
    # Each band has its share and one row of overlap at every inner edge.
    assert sum(length for _, length in calls) == rows + 2 * (bands - 1)


@pytest.mark.parametrize("threads", [2, 3])
def test_local_planes_do_not_depend_on_threads(threads):
    rng = np.random.default_rng(5)
    q = rng.uniform(0.9, 1.1, (3 * MIN_ROWS + 7, 40)).astype(np.float32)
    q[:, 20:] += 0.4
    q[rng.random(q.shape) < 0.1] = 0.0
    image = image_of(q)._replace(noise=0.01)
    single = fit_local_planes(image, SegmentationOptions())
    several = fit_local_planes(image, SegmentationOptions(threads=threads))
    for result, expected_image in zip(several[:4], single[:4], strict=True):
        assert np.allclose(result, expected_image, atol=1e-5)


def test_error_in_band_reaches_caller():
    def kernel(image):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_in_row_bands(kernel, (np.zeros((2 * MIN_ROWS, 2)),), 0, 2)
