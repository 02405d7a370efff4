"""Test of connected parts: they equal those of scipy."""

from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from eyehand.perception.segmentation.connected_parts import connected_parts, measure_parts


@pytest.mark.parametrize("diagonal", [False, True])
@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 1.0])
def test_parts_equal_scipy(share, diagonal):
    mask = np.random.default_rng(0).random((23, 37)) < share
    parts = connected_parts(mask.astype(np.uint8), diagonal=diagonal)
    structure = ndimage.generate_binary_structure(2, 2 if diagonal else 1)
    found: Any = ndimage.label(mask, structure)
    expected, count = found
    assert len(parts.sizes) == count + 1
    assert np.array_equal(parts.labels > 0, mask)
    for label, box in enumerate(ndimage.find_objects(parts.labels), start=1):
        assert len(np.unique(expected[parts.labels == label])) == 1
        assert parts.sizes[label] == np.count_nonzero(parts.labels == label)
        rows, columns = box
        assert parts.boxes[label].tolist() == [rows.start, columns.start, rows.stop, columns.stop]
    assert parts.sizes[0] == np.count_nonzero(~mask)


def test_negative_labels_are_no_parts():
    labels = np.array([[-5, -5, 1], [2, -1, 1]], dtype=np.int32)
    sizes, boxes = measure_parts(labels, 3)
    assert sizes.tolist() == [0, 2, 1]
    assert boxes[1:].tolist() == [[0, 2, 2, 3], [1, 0, 2, 1]]
