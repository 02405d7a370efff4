"""Test that methods run in turns on each frame and that the fastest round counts."""

import time

import numpy as np
import pytest

from eyehand.apps.bench import Method
from eyehand.apps.segmentation.comparison import FIGURES, compare_segmentations
from eyehand.apps.segmentation.dataset import FrameSource, LabelledFrame
from eyehand.perception import CameraIntrinsics, DepthFrame

TRUTH = np.zeros((40, 60), np.int32)
TRUTH[5:25, 5:25] = 1
TRUTH[5:25, 30:50] = 2


def source(number: int) -> FrameSource:
    """Return a flat frame whose depth encodes its number. One pixel has no reading."""
    depth = np.full(TRUTH.shape, 1.0 + number, np.float32)
    depth[10, 10] = 0
    frame = DepthFrame(depth, CameraIntrinsics(50.0, 50.0, 30.0, 20.0, 60, 40))
    return FrameSource(f"frame {number}", "all", lambda: LabelledFrame(frame, TRUTH))


def test_all_methods_run_on_a_frame_before_the_next_frame():
    calls = []

    def method(name: str, labels: np.ndarray) -> Method:
        def run(frame: DepthFrame) -> np.ndarray:
            calls.append((int(frame.depth[0, 0]), name))
            return labels

        return Method("test", name, run)

    half = np.where(TRUTH == 1, 1, 0).astype(np.int32)
    results = compare_segmentations(
        [method("all", TRUTH), method("half", half)], [source(0), source(1)], rounds=2
    )
    round_names = ["all", "half"]
    # A first round on the first frame warms up.
    assert calls == [(1, name) for name in 3 * round_names] + [
        (2, name) for name in 2 * round_names
    ]
    complete, partial = results
    assert complete.figures == dict.fromkeys(FIGURES, 100.0)
    assert partial.figures["overlap_f_pct"] == pytest.approx(66.6, abs=0.2)
    assert partial.figures["found_pct"] == 50.0


def test_fastest_round_counts():
    waits = iter([0.2, 0.05, 0.01, 0.03])

    def run(frame: DepthFrame) -> np.ndarray:
        time.sleep(next(waits))
        return TRUTH

    (result,) = compare_segmentations([Method("test", "sleeping", run)], [source(0)], rounds=3)
    assert 10 <= result.median_ms < 30
    assert result.median_cpu_ms < 10
