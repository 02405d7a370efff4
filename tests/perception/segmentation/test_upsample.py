"""Tests of upsampling labels along the depth steps of the full frame."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.perception.segmentation.upsample import upsample_labels


def reference(labels, q, stride):
    """Return the label of the coarse neighbour nearest in disparity, pixel by pixel."""
    full = np.zeros(q.shape, np.int32)
    for v, u in np.argwhere(q > 0):
        corners = [
            (k, m)
            for k in (v // stride, v // stride + 1)
            for m in (u // stride, u // stride + 1)
            if k < labels.shape[0] and m < labels.shape[1] and q[k * stride, m * stride] > 0
        ]
        if corners:
            gaps = [abs(q[k * stride, m * stride] - q[v, u]) for k, m in corners]
            full[v, u] = labels[corners[int(np.argmin(gaps))]]
    return full


@given(
    seed=st.integers(0, 10_000),
    stride=st.integers(2, 4),
    rows=st.integers(1, 14),
    columns=st.integers(1, 14),
    missing=st.sampled_from([0.0, 0.3]),
)
@settings(max_examples=25)
def test_labels_equal_reference(seed, stride, rows, columns, missing):
    rng = np.random.default_rng(seed)
    q = rng.uniform(0.5, 1.5, (rows, columns)).astype(np.float32)
    q[rng.random(q.shape) < missing] = 0.0
    labels = rng.integers(0, 4, (-(-rows // stride), -(-columns // stride))).astype(np.int32)
    full = upsample_labels(labels, q, stride)
    assert full.dtype == np.int32
    assert np.array_equal(full, reference(labels, q, stride))
    assert np.array_equal(full[::stride, ::stride], np.where(q[::stride, ::stride] > 0, labels, 0))


@pytest.mark.parametrize("stride", [2, 3, 4])
@pytest.mark.parametrize("edge", [9, 10, 11, 12])
def test_outlines_follow_depth_step(stride, edge):
    truth = np.zeros((24, 25), np.int32)
    truth[edge:, 7:20] = 1
    q = np.where(truth > 0, np.float32(1.3), np.float32(1.0))
    assert np.array_equal(upsample_labels(truth[::stride, ::stride].copy(), q, stride), truth)


def test_missing_readings_have_no_label():
    q = np.ones((8, 8), np.float32)
    q[3, 3] = 0.0
    full = upsample_labels(np.ones((4, 4), np.int32), q, 2)
    assert full[3, 3] == 0
    assert full.sum() == 63
