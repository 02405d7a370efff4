"""Self-agreement by hand, the disturbance, and the bound on synthetic scenes."""

import numpy as np
import pytest

from eyehand.apps.segmentation.self_agreement import disturbed_frame, self_agreement
from eyehand.apps.segmentation.synthetic_frames import EMPTY_FAMILIES, FAMILIES, synthetic_sources
from eyehand.perception import CameraIntrinsics, DepthFrame, segment

MIN_AGREEMENT = 0.95
"""Share of the pixels that must keep their object after the disturbance."""


def labels_of(row):
    labels = np.zeros((10, 20), np.int32)
    labels[0, : len(row)] = row
    return labels


def test_self_agreement_counts_segments_that_keep_their_partner():
    first = labels_of([1, 1, 1, 2, 2, 0])
    assert self_agreement(first, first) == 1.0
    assert self_agreement(first, labels_of([2, 2, 2, 1, 1, 0])) == 1.0
    assert self_agreement(first, labels_of([1, 1, 1, 1, 1, 0])) == pytest.approx(0.6)
    assert self_agreement(labels_of([]), labels_of([])) == 1.0


def test_disturbance_changes_few_readings_by_one_millimetre():
    frame = DepthFrame(np.ones((100, 200), np.float32), CameraIntrinsics(9, 9, 99, 49, 200, 100))
    change = np.abs(disturbed_frame(frame).depth - frame.depth)
    assert np.count_nonzero(change) == pytest.approx(100, abs=40)
    assert change.max() == pytest.approx(0.001, rel=1e-3)


@pytest.mark.parametrize("family", [family for family in FAMILIES if family not in EMPTY_FAMILIES])
def test_synthetic_scenes_keep_their_objects(family):
    for source in synthetic_sources([family], ["realistic"], frames=2, seed=40):
        frame = source.load().frame
        labels, disturbed = (segment(f).labels for f in (frame, disturbed_frame(frame)))
        assert self_agreement(labels, disturbed) >= MIN_AGREEMENT, source.name
