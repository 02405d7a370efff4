"""Kernels in bands of rows give what one call on the whole image gives."""

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import image_of

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation.local_planes import fit_local_planes
from eyehand.perception.segmentation.row_bands import MIN_ROWS, run_in_row_bands


def row_sums(reach):
    """Kernel: every row's sum with the rows around it, and the row itself."""

    def kernel(image, other):
        padded = np.pad(image, ((reach, reach), (0, 0)))
        around = [padded[k : k + image.shape[0]] for k in range(2 * reach + 1)]
        return np.sum(around, axis=0), other[:, 0]

    return kernel


@given(
    rows=st.integers(1, 5 * MIN_ROWS),
    threads=st.integers(1, 5),
    reach=st.integers(0, 7),
    seed=st.integers(0, 100),
)
@settings(max_examples=30)
def test_bands_equal_one_call(rows, threads, reach, seed):
    images = tuple(np.random.default_rng(seed).integers(0, 1000, (2, rows, 3)))
    expected = row_sums(reach)(*images)
    for mine, other in zip(
        run_in_row_bands(row_sums(reach), images, reach, threads), expected, strict=True
    ):
        assert np.array_equal(mine, other)


@pytest.mark.parametrize(
    ("rows", "threads", "bands"),
    [(2 * MIN_ROWS - 1, 4, 1), (2 * MIN_ROWS, 4, 2), (3 * MIN_ROWS, 2, 2), (3 * MIN_ROWS, 9, 3)],
)
def test_there_are_no_more_bands_than_threads_and_none_too_thin(rows, threads, bands):
    calls = []

    def kernel(image):
        calls.append((threading.current_thread(), len(image)))
        return (image,)

    run_in_row_bands(kernel, (np.zeros((rows, 2)),), 1, threads)
    assert len(calls) == bands
    assert len({thread for thread, _ in calls} - {threading.main_thread()}) <= bands - 1
    # Each has its share and one row of overlap on every inner side.
    assert sum(length for _, length in calls) == rows + 2 * (bands - 1)


@pytest.mark.parametrize("threads", [2, 3])
def test_local_planes_do_not_depend_on_the_number_of_threads(threads):
    rng = np.random.default_rng(5)
    q = rng.uniform(0.9, 1.1, (3 * MIN_ROWS + 7, 40)).astype(np.float32)
    q[:, 20:] += 0.4
    q[rng.random(q.shape) < 0.1] = 0.0
    image = image_of(q)._replace(noise=0.01)
    one = fit_local_planes(image, SegmentationOptions())
    several = fit_local_planes(image, SegmentationOptions(threads=threads))
    for mine, other in zip(several[:4], one[:4], strict=True):
        assert np.allclose(mine, other, atol=1e-5)


def test_an_error_in_a_band_reaches_the_caller():
    def kernel(image):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_in_row_bands(kernel, (np.zeros((2 * MIN_ROWS, 2)),), 0, 2)
