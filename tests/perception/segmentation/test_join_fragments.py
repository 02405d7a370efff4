"""Small pieces go to the large region that they touch, unless it lies far before them."""

import numpy as np
import pytest

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation.join_fragments import join_fragments
from eyehand.perception.segmentation.local_planes import LocalPlanes

OPTIONS = SegmentationOptions(fragment=50, fragment_share=0.05, fragment_border=0.3)


def scene(depths=(1.0, 1.0, 1.0)):
    """Labels and disparity: a block of 40 x 40 px (1), and a piece of 5 x 8 px (2) on its right."""
    labels = np.zeros((60, 60), np.int32)
    labels[10:50, 10:50] = 1
    labels[20:28, 50:55] = 2
    return labels, (1.0 / np.array(depths)[labels]).astype(np.float32)


def joined(labels, q, options=OPTIONS):
    flat = np.zeros_like(q)
    return join_fragments(labels, q, LocalPlanes(q, flat, flat, flat, 1e-3), options)


@pytest.mark.parametrize("behind", [0.0, 0.015, -0.3])
def test_a_piece_that_is_close_to_a_block_or_before_it_joins_it(behind):
    # 8 of its 26 border pixel pairs touch the block: 0.3 of its outline.
    labels, q = scene((3.0, 1.0, 1.0 + behind))
    assert np.array_equal(joined(labels, q), np.minimum(labels, 1))


def test_what_shows_far_behind_an_edge_is_another_object():
    labels, q = scene((3.0, 1.0, 1.05))
    assert np.array_equal(joined(labels, q), labels)


@pytest.mark.parametrize(
    "options",
    [
        SegmentationOptions(fragment=40, fragment_share=0.05),
        SegmentationOptions(fragment=50, fragment_share=0.02),
        SegmentationOptions(fragment=50, fragment_share=0.05, fragment_border=0.35),
    ],
)
def test_pieces_too_large_or_too_loose_stay(options):
    labels, q = scene()
    assert np.array_equal(joined(labels, q, options), labels)


def test_a_fragment_of_a_fragment_goes_all_the_way():
    labels, q = scene()
    labels[22:24, 55:56] = 3
    assert np.array_equal(joined(labels, q), np.minimum(labels, 1))


def test_an_empty_image_stays_empty():
    labels, q = scene()
    assert not joined(np.zeros_like(labels), q).any()
