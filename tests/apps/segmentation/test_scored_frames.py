"""Figures of frames and groups for a known segmentation."""

import numpy as np
import pytest

from eyehand.apps.segmentation import scored_frames as scored_frames
from eyehand.apps.segmentation.dataset import FrameSource, LabelledFrame
from eyehand.apps.segmentation.scored_frames import frame_row, run_trials, summary_rows
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, Segmentation, SegmentationOptions

CAMERA = CameraIntrinsics(60.0, 60.0, 31.5, 23.5, 64, 48)


def source(name: str, group: str, missing: int = 0) -> FrameSource:
    """Return a 10 x 20 px box on a table. Its first `missing` columns have no reading."""
    depth, truth = np.ones((48, 64), np.float32), np.zeros((48, 64), np.int32)
    truth[10:20, 10:30] = 1
    depth[10:20, 10 : 10 + missing] = 0
    return FrameSource(name, group, lambda: LabelledFrame(DepthFrame(depth, CAMERA), truth))


@pytest.fixture
def finds_half(monkeypatch):
    """Replace the segmentation by one that finds the right finds_half of the box."""

    def find(frame: DepthFrame, options: SegmentationOptions) -> Segmentation:
        labels = np.zeros(frame.depth.shape, np.int32)
        labels[10:20, 20:30] = 1
        return Segmentation(labels, None, 1e-3, {"all": 0.001})

    monkeypatch.setattr(scored_frames, "segment", find)


@pytest.mark.usefixtures("finds_half")
def test_summary_has_groups_then_total():
    sources = [source("a", "one"), source("b", "two"), source("c", "one", missing=10)]
    results = list(run_trials(sources, SegmentationOptions()))
    one, two, total = summary_rows(results)
    assert [row["name"] for row in (one, two, total)] == ["one", "two", "total"]
    assert [row["frames"] for row in (one, two, total)] == [2, 1, 3]
    # Frame a: the segment covers half of the box. Frame c: only the other half has readings.
    assert one["overlap_recall_pct"] == 75.0
    assert one["overlap_f_pct"] == pytest.approx((200 / 3 + 100) / 2, abs=0.01)
    assert (one["found_pct"], two["found_pct"], one["missed"], two["missed"]) == (50.0, 0.0, 1, 1)
    assert total["objects"] == 3
    assert total["median_ms"] >= 0
    assert total["peak_mb"] >= 0


@pytest.mark.usefixtures("finds_half")
def test_counts_pixels_without_reading_on_request():
    sources = [source("c", "one", missing=10)]
    (result,) = run_trials(sources, SegmentationOptions(), ignore_invalid=False)
    assert result.score.recall == 0.5
    (row,) = summary_rows([result])
    assert row["name"] == "one"


@pytest.mark.usefixtures("finds_half")
def test_frame_row_has_stage_times():
    (result,) = run_trials([source("c", "one")], SegmentationOptions(), memory_frames=0)
    row = frame_row(result)
    assert (row["group"], row["name"], row["segments"], row["all_ms"]) == ("one", "c", 1, 1.0)
    assert row["peak_mb"] is None


def test_error_names_unreadable_frame():
    def fail() -> LabelledFrame:
        raise InputError("is damaged")

    with pytest.raises(InputError, match="frame 3: is damaged"):
        list(run_trials([FrameSource("frame 3", "one", fail)], SegmentationOptions()))
