"""Tests of the ambiguous objects: decisions that may be wrong are named at their objects."""

import numpy as np
import pytest
from random_planes import image_of

from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation.ambiguity import (
    FLAT,
    NEARLY,
    UncertainJoin,
    resolve_ambiguity,
)


@pytest.mark.parametrize(
    ("first", "second", "reason", "named"),
    [
        ("a", "b", NEARLY, {"a", "b"}),
        ("a", "a", NEARLY, set()),
        ("a", "none", NEARLY, set()),
        ("a", "a", FLAT, {"a"}),
        ("a", "b", FLAT, set()),
    ],
)
def test_doubts_name_the_objects_that_they_are_about(first, second, reason, named):
    labels = np.zeros((20, 30), np.int32)
    labels[2:18, 2:12], labels[2:8, 15:25] = 1, 2
    image = image_of(np.ones(labels.shape, np.float32))
    pixel = {"a": 3 * 30 + 3, "b": 3 * 30 + 20, "none": 0}
    uncertain = [UncertainJoin(pixel[first], pixel[second], reason)]
    _, ambiguous = resolve_ambiguity(labels, uncertain, image, SegmentationOptions())
    assert ambiguous == {{"a": 1, "b": 2}[name]: reason for name in named}
