"""The score against hand-counted cases, and its invariances."""

import time

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

from eyehand.apps.segmentation.score import score_segmentation
from eyehand.errors import InputError

SHARES = ("precision", "recall", "f", "boundary_precision", "boundary_recall", "boundary_f")


@st.composite
def label_images(draw: st.DrawFn, shape: tuple[int, int] = (60, 80)) -> np.ndarray:
    """Draw up to five overlapping rectangles, some with a hole."""
    image = np.zeros(shape, np.int32)
    for label in range(1, draw(st.integers(0, 5)) + 1):
        top, left = draw(st.integers(0, 50)), draw(st.integers(0, 70))
        height, width = draw(st.integers(3, 30)), draw(st.integers(3, 40))
        image[top : top + height, left : left + width] = label
        if draw(st.booleans()):
            image[top + 2 : top + height - 2, left + 2 : left + width - 2] = 0
    return image


def test_renumbered_labels_score_one():
    truth = np.array([[0, 1, 1], [2, 2, 0]])
    score = score_segmentation(np.array([[0, 7, 7], [3, 3, 0]]), truth)
    assert [getattr(score, name) for name in SHARES] == [1.0] * 6
    assert (score.found, score.over, score.under, score.missed, score.false) == (1.0, 0, 0, 0, 0)
    assert [(match.truth, match.predicted, match.f) for match in score.matches] == [
        (1, 7, 1.0),
        (2, 3, 1.0),
    ]


def test_half_object_has_full_precision_and_half_recall():
    truth = np.ones((2, 4), int)
    truth[0] = 0
    score = score_segmentation(np.array([[0, 0, 0, 0], [1, 1, 0, 0]]), truth)
    assert (score.precision, score.recall) == (1.0, 0.5)
    assert score.f == pytest.approx(2 / 3)
    assert (score.found, score.missed) == (0.0, 1)


def test_split_object_counts_larger_part():
    score = score_segmentation(np.array([[1, 1, 1, 2]]), np.ones((1, 4), int))
    assert score.precision == score.recall == 0.75
    assert (score.predicted_count, score.over, score.under) == (2, 1, 0)
    assert (score.missed, score.false) == (0, 0)


def test_matching_maximises_sum_of_f():
    # Object 1 overlaps segment 5 most, but segment 5 is the only one on object 2.
    truth = np.array([[1] * 6 + [2] * 4])
    score = score_segmentation(np.array([[6] * 2 + [5] * 8]), truth)
    assert [(match.truth, match.predicted) for match in score.matches] == [(1, 6), (2, 5)]
    assert score.precision == score.recall == pytest.approx(0.6)
    assert (score.over, score.under) == (0, 1)


def test_merged_pair_and_fragment_are_distinguished():
    truth = np.zeros((40, 60), int)
    truth[5:15, 5:15], truth[5:15, 15:25], truth[25:35, 5:15] = 1, 2, 3
    guess = np.zeros_like(truth)
    guess[5:15, 5:25] = 1  # objects 1 and 2 as one
    guess[25:35, 5:9] = 2  # 40 % of object 3: missed
    guess[25:35, 40:50] = 3  # on no object: false
    score = score_segmentation(guess, truth)
    assert (score.over, score.under, score.missed, score.false) == (0, 1, 1, 1)
    assert score.precision == pytest.approx((100 + 40) / 340)
    assert score.recall == pytest.approx((100 + 40) / 300)
    assert score.found == 0.0


def test_boundaries_agree_only_within_tolerance():
    # A diagonal of 800 px has a tolerance of ceil(2.4) = 3 px.
    truth = np.zeros((480, 640), int)
    truth[100:200, 100:200] = 1
    for shift, expected in ((3, 1.0), (4, None)):
        guess = np.roll(truth, shift, axis=1)
        score = score_segmentation(guess, truth)
        assert score.precision == score.recall == pytest.approx(1 - shift / 100)
        if expected is None:
            # The vertical sides do not match, except for their ends. Those lie within 3 px of the
            # other contour's horizontal sides.
            horizontal, vertical = 2 * 100, 2 * 98
            assert horizontal / (horizontal + vertical) <= score.boundary_f < 0.53
        else:
            assert score.boundary_f == expected


def test_contours_of_holes_do_not_count():
    truth = np.zeros((480, 640), int)
    truth[100:200, 100:200] = 1
    guess = truth.copy()
    guess[130:170, 130:170] = 0
    score = score_segmentation(guess, truth)
    assert (score.boundary_precision, score.boundary_recall) == (1.0, 1.0)
    assert (score.precision, score.recall) == (1.0, 1 - 0.16)


def test_ignored_pixels_count_neither_as_truth_nor_prediction():
    truth, guess = np.zeros((30, 40), int), np.zeros((30, 40), int)
    truth[5:15, 5:15] = 1
    guess[5:15, 5:25] = 1
    guess[20:25, 20:25] = 2
    ignore = np.zeros(truth.shape, bool)
    ignore[:, 15:] = True
    assert score_segmentation(guess, truth).precision < 0.5
    score = score_segmentation(guess, truth, ignore)
    assert (score.f, score.boundary_f, score.predicted_count, score.false) == (1.0, 1.0, 1, 0)


def test_empty_prediction_and_empty_truth():
    nothing, something = np.zeros((2, 2), int), np.array([[0, 1], [1, 1]])
    right = score_segmentation(nothing, nothing)
    assert (right.f, right.boundary_f, right.found, right.false) == (1.0, 1.0, 1.0, 0)
    missed = score_segmentation(nothing, something)
    assert (missed.f, missed.boundary_f, missed.found, missed.missed) == (0.0, 0.0, 0.0, 1)
    false = score_segmentation(something, nothing)
    assert (false.f, false.boundary_f, false.found, false.false) == (0.0, 0.0, 0.0, 1)


def test_invalid_label_images_are_rejected():
    with pytest.raises(InputError, match="size"):
        score_segmentation(np.zeros((2, 2), int), np.zeros((2, 3), int))
    with pytest.raises(InputError, match="ignore"):
        score_segmentation(np.zeros((2, 2), int), np.zeros((2, 2), int), np.zeros((3, 2), bool))
    with pytest.raises(InputError, match="-1"):
        score_segmentation(np.full((2, 2), -1), np.zeros((2, 2), int))
    with pytest.raises(InputError, match="integers"):
        score_segmentation(np.zeros((2, 2), int), np.zeros((2, 2)))  # pyright: ignore


@given(label_images())
def test_perfect_prediction_scores_one(truth):
    score = score_segmentation(truth, truth)
    assert [getattr(score, name) for name in SHARES] == [1.0] * 6
    assert (score.found, score.over, score.under, score.missed, score.false) == (1.0, 0, 0, 0, 0)


@given(label_images(), label_images(), st.permutations(range(1, 6)))
def test_renumbering_and_mirroring_change_nothing(predicted, truth, order):
    score = score_segmentation(predicted, truth)
    # Numbers beyond the lookup table, so that both methods of renumbering are compared.
    numbers = np.array([0, *(10**6 * number for number in order)])
    assert score_segmentation(numbers[predicted], truth) == score
    assert score_segmentation(predicted, numbers[truth]) == score
    assert score_segmentation(predicted[:, ::-1], truth[:, ::-1]) == score
    assert score_segmentation(predicted[::-1], truth[::-1]) == score


@given(label_images(), label_images())
def test_swapping_truth_and_prediction_swaps_figures(predicted, truth):
    one, other = score_segmentation(predicted, truth), score_segmentation(truth, predicted)
    assert (one.precision, one.recall) == (other.recall, other.precision)
    assert (one.boundary_precision, one.boundary_recall) == (
        other.boundary_recall,
        other.boundary_precision,
    )
    assert (one.over, one.under, one.missed, one.false) == (
        other.under,
        other.over,
        other.false,
        other.missed,
    )
    assert one.f == pytest.approx(other.f, abs=1e-12)


@given(label_images(), label_images())
def test_boundary_scores_equal_reference(predicted, truth):
    """Compare with a plain reference: contour masks and exact Euclidean distances."""
    score = score_segmentation(predicted, truth)
    reach = np.ceil(0.003 * np.hypot(*truth.shape))
    guess_hits = true_hits = 0
    for match in score.matches:
        guess, true = (
            outer_contour(predicted == match.predicted),
            outer_contour(truth == match.truth),
        )
        guess_hits += np.count_nonzero(guess & (ndimage.distance_transform_edt(~true) <= reach))
        true_hits += np.count_nonzero(true & (ndimage.distance_transform_edt(~guess) <= reach))
    shares = (score.boundary_precision, score.boundary_recall)
    for image, hit, share in zip((predicted, truth), (guess_hits, true_hits), shares, strict=True):
        total = sum(outer_contour(image == label).sum() for label in range(1, image.max() + 1))
        if score.matches:
            assert share == pytest.approx(hit / total)


def outer_contour(mask: np.ndarray) -> np.ndarray:
    """Return the pixels of a mask with a 4-neighbour outside it, holes excluded."""
    edges = np.zeros_like(mask)
    count, parts = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)
    for part in range(1, count):
        padded = np.pad(parts == part, 1)
        # The outside is 4-connected to the padding around the image.
        _, rest = cv2.connectedComponents((~padded).astype(np.uint8), connectivity=4)
        outside_border = ndimage.binary_dilation(rest == rest[0, 0])
        edges |= (parts == part) & outside_border[1:-1, 1:-1]
    return edges


def test_scores_frame_within_50_ms():
    rows, columns = np.mgrid[:480, :640]
    truth = (rows // 96) * 4 + columns // 160 + 1
    truth[(rows % 96 < 10) | (columns % 160 < 10)] = 0
    predicted = np.roll(truth, 2, axis=1)
    times = []
    for _ in range(5):
        start = time.perf_counter()
        score_segmentation(predicted, truth)
        times.append(time.perf_counter() - start)
    # A quiet machine takes a fifth of this.
    assert min(times) < 0.05
