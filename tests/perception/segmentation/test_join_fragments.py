"""Tests of joining small fragments to the large region that they touch."""

import numpy as np
import pytest
from random_planes import image_of

from eyehand.perception.segmentation import join_fragments as module
from eyehand.perception.segmentation.join_fragments import join_fragments
from eyehand.perception.segmentation.local_planes import LocalPlanes


@pytest.fixture(autouse=True)
def limits(monkeypatch):
    """Lower the limits for a scene of small regions."""
    monkeypatch.setattr(module, "MAX_FRAGMENT", 50)
    monkeypatch.setattr(module, "MAX_SIZE_SHARE", 0.05)


def scene(depths=(1.0, 1.0, 1.0)):
    """Return labels and disparity of a 40 x 40 px block (1) with a 5 x 8 px piece (2) beside it."""
    labels = np.zeros((60, 60), np.int32)
    labels[10:50, 10:50] = 1
    labels[20:28, 50:55] = 2
    return labels, (1.0 / np.array(depths)[labels]).astype(np.float32)


def join(labels, q):
    flat = np.zeros_like(q)
    return join_fragments(labels, labels, image_of(q), LocalPlanes(q, flat, flat, flat), 1)


@pytest.mark.parametrize("behind", [0.0, 0.015, -0.3])
def test_close_piece_joins_block(behind):
    # 8 of the 26 border pixel pairs of the piece touch the block: a border share of 0.3.
    labels, q = scene((3.0, 1.0, 1.0 + behind))
    assert np.array_equal(join(labels, q), np.minimum(labels, 1))


def test_piece_far_behind_edge_stays_separate():
    labels, q = scene((3.0, 1.0, 1.05))
    assert np.array_equal(join(labels, q), labels)


@pytest.mark.parametrize(
    ("limit", "value"),
    [("MAX_FRAGMENT", 40), ("MAX_SIZE_SHARE", 0.02), ("MIN_BORDER_SHARE", 0.35)],
)
def test_large_or_loose_piece_stays_separate(monkeypatch, limit, value):
    monkeypatch.setattr(module, limit, value)
    labels, q = scene()
    assert np.array_equal(join(labels, q), labels)


def test_chained_fragments_join_block():
    labels, q = scene()
    labels[22:24, 55:56] = 3
    assert np.array_equal(join(labels, q), np.minimum(labels, 1))


def test_empty_image_stays_empty():
    labels, q = scene()
    assert not join(np.zeros_like(labels), q).any()
