"""Small pieces go to the large region that they touch, unless it lies far before them."""

import numpy as np
import pytest
from random_planes import image_of

from eyehand.perception.segmentation import join_fragments as module
from eyehand.perception.segmentation.join_fragments import join_fragments
from eyehand.perception.segmentation.local_planes import LocalPlanes


@pytest.fixture(autouse=True)
def limits(monkeypatch):
    """Set the limits for a scene of small regions."""
    monkeypatch.setattr(module, "MAX_FRAGMENT", 50)
    monkeypatch.setattr(module, "MAX_SIZE_SHARE", 0.05)


def scene(depths=(1.0, 1.0, 1.0)):
    """Labels and disparity: a block of 40 x 40 px (1), and a piece of 5 x 8 px (2) on its right."""
    labels = np.zeros((60, 60), np.int32)
    labels[10:50, 10:50] = 1
    labels[20:28, 50:55] = 2
    return labels, (1.0 / np.array(depths)[labels]).astype(np.float32)


def joined(labels, q):
    flat = np.zeros_like(q)
    return join_fragments(labels, labels, image_of(q), LocalPlanes(q, flat, flat, flat), 1)


@pytest.mark.parametrize("behind", [0.0, 0.015, -0.3])
def test_a_piece_that_is_close_to_a_block_or_before_it_joins_it(behind):
    # 8 of its 26 border pixel pairs touch the block: 0.3 of its outline.
    labels, q = scene((3.0, 1.0, 1.0 + behind))
    assert np.array_equal(joined(labels, q), np.minimum(labels, 1))


def test_what_shows_far_behind_an_edge_is_another_object():
    labels, q = scene((3.0, 1.0, 1.05))
    assert np.array_equal(joined(labels, q), labels)


@pytest.mark.parametrize(
    ("limit", "value"),
    [("MAX_FRAGMENT", 40), ("MAX_SIZE_SHARE", 0.02), ("MIN_BORDER_SHARE", 0.35)],
)
def test_keeps_large_or_loose_pieces(monkeypatch, limit, value):
    monkeypatch.setattr(module, limit, value)
    labels, q = scene()
    assert np.array_equal(joined(labels, q), labels)


def test_a_fragment_of_a_fragment_goes_all_the_way():
    labels, q = scene()
    labels[22:24, 55:56] = 3
    assert np.array_equal(joined(labels, q), np.minimum(labels, 1))


def test_an_empty_image_stays_empty():
    labels, q = scene()
    assert not joined(np.zeros_like(labels), q).any()
