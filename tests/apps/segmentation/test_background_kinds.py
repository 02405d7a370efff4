"""Kinds of background under false segments."""

import numpy as np

from eyehand.apps.segmentation.scored_frames import false_kinds
from eyehand.data_synth.scenes import BACKGROUND_LEGEND

NUMBER = {kind: number for number, kind in BACKGROUND_LEGEND.items()}


def test_counts_each_false_segment_on_its_main_kind():
    truth = np.zeros((4, 12), int)
    truth[:, :3] = 1
    background = np.full(truth.shape, NUMBER["table"], np.uint8)
    background[:, 8:] = NUMBER["container_wall"]
    background[truth > 0] = 0
    predicted = np.zeros_like(truth)
    predicted[:, :4] = 7  # mostly on the object
    predicted[:, 5:7] = 2  # on the table
    predicted[:, 7:] = 9  # mostly on the wall
    found = false_kinds(predicted, truth, background)
    assert {kind for kind, count in found.items() if count} == {"table", "container_wall"}
    assert found["table"] == found["container_wall"] == 1

    ignore = np.zeros(truth.shape, bool)
    ignore[:, 5:7] = True
    assert false_kinds(predicted, truth, background, ignore)["table"] == 0


def test_frame_without_segments_has_none():
    empty = np.zeros((2, 3), int)
    assert sum(false_kinds(empty, empty, empty.astype(np.uint8)).values()) == 0
