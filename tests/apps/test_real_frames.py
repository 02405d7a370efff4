"""Real frames of several cameras are perceived with finite numbers."""

import json
from pathlib import Path

import numpy as np
import pytest

from eyehand.apps.perceived_frame import perceive_and_plan
from eyehand.apps.scene_json import scene_json
from eyehand.apps.segmentation.score import score_segmentation
from eyehand.perception import CameraIntrinsics, DepthFrame, read_frame

KINECT = CameraIntrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)
FRAMES = {
    "frames/pcl/milk_cartoon_all_small_clorox.pcd": 3,
    "frames/pcl/table_scene_mug_stereo_textured.pcd": 1,
    "frames/graspnet/depth.png": 5,
}
"""Frame → number of well separated objects that must be found at least."""


def check(frame: DepthFrame) -> int:
    found = perceive_and_plan(frame)
    text = json.dumps(scene_json(found.scene, found.plans, "test"), allow_nan=False)
    assert json.loads(text)["schema"] == "eyehand.scene/1"
    for item in found.scene.objects:
        solid = item.fit.superquadric
        if item.fit:
            assert solid is not None
            assert np.isfinite(solid.volume)
            assert solid.semi_axes.max() < 1.0
        assert 0.0 <= item.visible_share <= 1.0
    return len(found.scene.objects)


@pytest.mark.parametrize("name", FRAMES)
def test_frames_of_other_cameras_are_perceived(name, real_data):
    path = real_data / name
    camera = path.with_name("camera.json") if path.suffix == ".png" else None
    assert check(read_frame(path, camera)) >= FRAMES[name]


@pytest.mark.parametrize("first", range(5))
def test_labelled_tabletop_frames_are_segmented(first, real_data):
    scores = []
    paths = sorted((real_data / "mosd_learn").glob("*.npz"))[first::15]
    assert paths
    for path in paths:
        depth, truth = read_labelled(path)
        frame = DepthFrame(depth, KINECT)
        check(frame)
        labels = perceive_and_plan(frame).scene.segmentation.labels
        scores.append(score_segmentation(labels, np.where(frame.valid, truth, 0)).f)
    assert np.mean(scores) > 0.75


def test_top_of_a_tall_box_is_no_support(real_data):
    """Through all readings the top of this box is just large enough for a small table."""
    depth, truth = read_labelled(real_data / "mosd_learn" / "learn23.npz")
    frame = DepthFrame(depth, KINECT)
    labels = perceive_and_plan(frame).scene.segmentation.labels
    assert score_segmentation(labels, np.where(frame.valid, truth, 0)).f > 0.95


def read_labelled(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Read depth, m, and object labels; files hold 0.1 mm, ten times the label, background < 20."""
    with np.load(path) as data:
        depth = data["depth"].astype(np.float32) * np.float32(1e-4)
        label = data["label"].astype(np.int64)
    return depth, np.where(label < 20, 0, label // 10)
