"""The score against cases counted by hand."""

import numpy as np
import pytest

from eyehand.apps.evaluation.segmentation_score import score_overlap
from eyehand.errors import InputError


def test_equal_labels_under_other_numbers_score_one():
    truth = np.array([[0, 1, 1], [2, 2, 0]])
    score = score_overlap(np.array([[0, 7, 7], [3, 3, 0]]), truth)
    assert (score.precision, score.recall, score.f, score.found) == (1.0, 1.0, 1.0, 1.0)


def test_half_an_object_has_full_precision_and_half_recall():
    truth = np.ones((2, 4), int)
    truth[0] = 0
    score = score_overlap(np.array([[0, 0, 0, 0], [1, 1, 0, 0]]), truth)
    assert (score.precision, score.recall) == (1.0, 0.5)
    assert score.f == pytest.approx(2 / 3)
    assert score.found == 0.0


def test_a_split_object_counts_its_larger_part():
    score = score_overlap(np.array([[1, 1, 1, 2]]), np.ones((1, 4), int))
    assert score.precision == score.recall == 0.75
    assert score.predicted_count == 2


def test_nothing_found_and_nothing_there():
    nothing, something = np.zeros((2, 2), int), np.array([[0, 1], [1, 1]])
    assert score_overlap(nothing, nothing).f == 1.0
    assert score_overlap(nothing, something).f == 0.0
    assert score_overlap(something, nothing).f == 0.0


def test_other_sizes_are_refused():
    with pytest.raises(InputError, match="size"):
        score_overlap(np.zeros((2, 2), int), np.zeros((2, 3), int))
