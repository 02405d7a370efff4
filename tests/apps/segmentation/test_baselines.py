"""Every peer on a scene that it must get right, and on an empty table."""

import numpy as np
import pytest

from eyehand.apps.segmentation.baselines import PEERS, Peer
from eyehand.apps.segmentation.score import score_segmentation
from eyehand.data_synth.render import StagedObject, StagedScene, staged_frame
from eyehand.data_synth.scenes import ball

BALLS = StagedScene(
    (StagedObject(ball(0.05), (-0.1, 0.0, 0.0)), StagedObject(ball(0.06), (0.1, 0.02, 0.0)))
)


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
def test_two_separate_balls_are_two_objects(peer: Peer):
    frame, truth = staged_frame(BALLS)
    labels = peer.run(frame, peer.settings[len(peer.settings) // 2])
    assert labels.shape == frame.depth.shape
    assert labels.dtype == np.int32
    score = score_segmentation(labels, truth)
    assert score.predicted_count == score.truth_count == 2
    assert score.f > 0.95


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
def test_an_empty_table_has_no_objects(peer: Peer):
    frame, _ = staged_frame(StagedScene(()))
    assert not peer.run(frame, peer.settings[0]).any()


def test_every_peer_says_why_it_is_there():
    for peer in PEERS:
        assert peer.why
        assert "\n" not in peer.why
        assert len(set(peer.settings)) == len(peer.settings) >= 3
