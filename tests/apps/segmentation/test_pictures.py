"""Pictures of scored frames: files, colours and labels."""

import cv2
import numpy as np

from eyehand.apps.segmentation.pictures import (
    ScoredFrame,
    outlined,
    verdict,
    write_frame_picture,
    write_sheet,
)
from eyehand.apps.segmentation.score import score_segmentation
from eyehand.perception import CameraIntrinsics, DepthFrame


def scored_frame(*, empty: bool = False) -> ScoredFrame:
    """Return a frame with one object found, one missed and a false segment, or an empty one."""
    truth = np.zeros((48, 64), np.int32)
    predicted = truth.copy()
    if not empty:
        truth[10:20, 10:20], truth[30:40, 10:20] = 1, 2
        predicted[10:20, 10:20], predicted[30:40, 40:50] = 4, 9
    depth = np.linspace(0.8, 1.2, 48 * 64, dtype=np.float32).reshape(48, 64)
    frame = DepthFrame(depth, CameraIntrinsics(60.0, 60.0, 31.5, 23.5, 64, 48))
    return ScoredFrame("frame 1", frame, truth, predicted, score_segmentation(predicted, truth))


def test_verdict_names_every_mistake():
    assert verdict(scored_frame().score) == (
        "F 50.0 %, boundary F 50.0 %, 1 of 2 found in 2 segments: 1 missed, 1 false"
    )
    assert verdict(scored_frame(empty=True).score).endswith("0 of 0 found in 0 segments")


def test_writes_picture_and_sheet(tmp_path):
    write_frame_picture(tmp_path / "one.png", scored_frame())
    picture = cv2.imread(str(tmp_path / "one.png"))
    assert picture is not None
    assert picture.shape[1] > 1500
    assert picture.std() > 10
    write_sheet(tmp_path / "sheet.png", [scored_frame(), scored_frame(), scored_frame(empty=True)])
    sheet = cv2.imread(str(tmp_path / "sheet.png"))
    assert sheet is not None
    assert sheet.shape[0] > 500


def test_tints_only_the_object():
    grey = np.full((480, 640, 3), 100, np.uint8)
    labels = np.zeros((480, 640), np.int32)
    labels[100:200, 100:200] = 5
    picture = outlined(grey, labels, {5: np.array([255, 0, 0], np.uint8)})
    assert picture.shape == (960, 1280, 3)
    red, green, _ = picture[300, 300].astype(int)
    assert red > green + 50
    assert np.ptp(picture[700, 900]) == 0
