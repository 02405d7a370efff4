"""Test that methods run in turns on each frame and that the fastest round counts."""

import time

import numpy as np
import pytest

from eyehand.apps.bench import Method
from eyehand.apps.segmentation.comparison import FIGURES, compare_segmentations
from eyehand.apps.segmentation.kinds import JudgedFrame, KindFrame, Score
from eyehand.perception import CameraIntrinsics, DepthFrame

TRUTH = np.zeros((40, 60), np.int32)
TRUTH[5:25, 5:25] = 1
TRUTH[5:25, 30:50] = 2


def frame_of(number: int, kind: str = "all") -> KindFrame:
    """Return a flat frame whose depth encodes its number; a score is the share of right pixels."""
    depth = np.full(TRUTH.shape, 1.0 + number, np.float32)
    frame = DepthFrame(depth, CameraIntrinsics(50.0, 50.0, 30.0, 20.0, 60, 40))
    judged = JudgedFrame(frame, lambda labels: Score(float(np.mean(labels == TRUTH)), 1), TRUTH)
    return KindFrame(f"frame {number}", kind, kind, lambda: judged)


def test_all_methods_run_on_a_frame_before_the_next_frame():
    calls = []

    def method(name: str, labels: np.ndarray) -> Method:
        def run(frame: DepthFrame) -> np.ndarray:
            calls.append((int(frame.depth[0, 0]), name))
            return labels

        return Method("test", name, run)

    half = np.where(TRUTH == 1, 1, 0).astype(np.int32)
    results = compare_segmentations(
        [method("all", TRUTH), method("half", half)], [frame_of(0), frame_of(1)], rounds=2
    )
    round_names = ["all", "half"]
    # A first round on the first frame warms up.
    assert calls == [(1, name) for name in 3 * round_names] + [
        (2, name) for name in 2 * round_names
    ]
    complete, partial = results
    assert complete.figures == dict.fromkeys(FIGURES, 100.0)
    right = 100 * np.mean(half == TRUTH)
    assert partial.figures["all_kinds_pct"] == pytest.approx(right, abs=0.01)


def test_three_worst_kinds_count():
    truths = iter([TRUTH, TRUTH, TRUTH, 0 * TRUTH, TRUTH])
    frames = [frame_of(k, kind) for k, kind in enumerate("abcd")]
    (result,) = compare_segmentations(
        [Method("test", "one wrong", lambda _: next(truths))], frames, rounds=1
    )
    wrong = np.mean(TRUTH == 0)
    assert result.figures["worst_kinds_pct"] == pytest.approx(100 * (2 + wrong) / 3, abs=0.01)
    assert result.figures["all_kinds_pct"] == pytest.approx(100 * (3 + wrong) / 4, abs=0.01)


def test_fastest_round_counts():
    waits = iter([0.2, 0.05, 0.01, 0.03])

    def run(frame: DepthFrame) -> np.ndarray:
        end = time.process_time() + next(waits)
        while time.process_time() < end:
            pass
        return TRUTH

    (result,) = compare_segmentations([Method("test", "sleeping", run)], [frame_of(0)], rounds=3)
    assert 10 <= result.median_ms < 30
    assert result.median_cpu_ms == pytest.approx(result.median_ms, rel=0.05)


def test_waiting_for_other_load_does_not_count():
    def run(frame: DepthFrame) -> np.ndarray:
        time.sleep(0.05)
        return TRUTH

    (result,) = compare_segmentations([Method("test", "waiting", run)], [frame_of(0)], rounds=1)
    assert result.median_ms < 25
