"""A look that tells too little ends the clearing in words, and never as a clear table."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.errors import InputError
from eyehand.grasping.cell import Cell
from eyehand.grasping.clearing import MAX_FRAMES, clear_table
from eyehand.grasping.scene_validation import MIN_UNEXPLAINED_AREA, unexplained_area, validate_scene
from eyehand.grasping.tray import Tray
from eyehand.perception import CameraIntrinsics, DepthFrame, Segmentation, SupportPlane

from .fake_robot import FakeRobot

TRAY = Tray(np.array([0.0, -0.45, 0.006]), (0.25, 0.3), 0.05)
VIEW = np.array([0.0, 0.5, 0.9])
LENS = CameraIntrinsics(50.0, 50.0, 9.5, 9.5, 20, 20)


def frame(share=1.0) -> DepthFrame:
    depth = np.ones((20, 20), np.float32)
    depth[: round(20 * (1 - share))] = 0.0
    return DepthFrame(depth, LENS)


def tilted(angle_deg: float, height: float = 0.0) -> SupportPlane:
    angle = np.radians(angle_deg)
    return SupportPlane(np.array([np.sin(angle), 0.0, np.cos(angle)]), -height)


@pytest.mark.parametrize(
    ("share", "support", "message"),
    [
        (1.0, tilted(0.0), ""),
        (0.5, tilted(0.0), ""),
        (1.0, tilted(2.5), ""),
        (1.0, tilted(0.0, 0.2), ""),
        (0.2, tilted(0.0), "20% of the pixels"),
        (1.0, None, "no level surface"),
        (1.0, tilted(3.5), "tilts by 3.5°"),
        (1.0, tilted(180.0), "tilts by 180.0°"),
        (1.0, tilted(0.0, -0.72), "0.73 m below the tray"),
        (1.0, tilted(0.0, 0.72), "0.71 m above the tray"),
    ],
)
def test_doubts_name_what_is_wrong(share, support, message):
    scene = replace(ground_truth_scene([], VIEW), support=support)
    reason = validate_scene(frame(share), scene, TRAY)
    assert message in reason
    assert bool(reason) == bool(message)


def refuse(_frame):
    raise InputError("depth is 0 everywhere")


def show_no_table(_frame):
    return replace(ground_truth_scene([], VIEW), support=None)


@pytest.mark.parametrize(
    ("see", "message"), [(refuse, "0 everywhere"), (show_no_table, "no table")]
)
def test_a_blind_look_ends_the_clearing_and_moves_nothing(see, message):
    robot = FakeRobot()
    start = robot.read().q
    report = clear_table(Cell(robot, see, TRAY))
    assert report.stop_reason.startswith("no ")
    assert message in report.stop_reason
    assert (report.picks, report.observations) == ((), 1)
    np.testing.assert_array_equal(robot.read().q, start)


def test_a_camera_that_gives_nothing_ends_the_clearing_in_words(monkeypatch):
    robot = FakeRobot()
    monkeypatch.setattr(robot, "capture", lambda: refuse(None))
    report = clear_table(Cell(robot, lambda _: ground_truth_scene([], VIEW), TRAY))
    assert report.stop_reason == "no valid depth image: depth is 0 everywhere"


def test_a_table_seen_empty_is_clear():
    report = clear_table(Cell(FakeRobot(), lambda _: ground_truth_scene([], VIEW), TRAY))
    assert report.stop_reason == "clear"


FROM_ABOVE = RigidTransform.from_components([0.0, 0.0, 1.0], Rotation.from_euler("x", np.pi))
NEAR_LENS = CameraIntrinsics(200.0, 200.0, 39.5, 39.5, 80, 80)


def looked_down_on(high: float, side: int):
    """Show a table 1 m below the camera, and on it a block of so many pixels across."""
    depth = np.ones((80, 80), np.float32)
    depth[30 : 30 + side, 30 : 30 + side] -= high
    labels = np.zeros(depth.shape, np.int32)
    scene = ground_truth_scene([], FROM_ABOVE.translation)
    scene = replace(scene, segmentation=Segmentation(labels, None, 0.0, {}))
    return DepthFrame(depth, NEAR_LENS, FROM_ABOVE), scene


def test_what_stands_on_the_table_and_is_no_object_leaves_a_doubt():
    frame, scene = looked_down_on(high=0.1, side=3)
    # 9 pixels of 4.5 x 4.5 mm.
    assert unexplained_area(frame, scene) == pytest.approx(9 * (0.9 / 200.0) ** 2, rel=1e-5)
    assert "2 cm² above it belong to no segmented object" in validate_scene(frame, scene, TRAY)


@pytest.mark.parametrize(("high", "side"), [(0.0, 0), (0.003, 8), (0.1, 2), (0.7, 8)])
def test_noise_flying_pixels_and_what_hangs_above_leave_none(high, side):
    frame, scene = looked_down_on(high, side)
    assert unexplained_area(frame, scene) <= MIN_UNEXPLAINED_AREA
    assert validate_scene(frame, scene, TRAY) == ""


def test_what_belongs_to_an_object_leaves_none():
    frame, scene = looked_down_on(0.1, 8)
    labels = (frame.depth < 0.95).astype(np.int32)
    scene = replace(scene, segmentation=replace(scene.segmentation, labels=labels))
    assert unexplained_area(frame, scene) == 0.0


def test_a_look_that_leaves_a_doubt_is_made_of_more_images(monkeypatch):
    robot, taken = FakeRobot(), []
    whole = robot.capture()

    def half() -> DepthFrame:
        taken.append(len(taken))
        depth = np.where(np.arange(32) % 3 == len(taken) % 3, whole.depth, 0.0)
        return replace(whole, depth=depth.astype(np.float32))

    monkeypatch.setattr(robot, "capture", half)
    report = clear_table(Cell(robot, lambda _: ground_truth_scene([], VIEW), TRAY))
    assert (report.stop_reason, report.observations) == ("clear", 1)
    assert len(taken) == MAX_FRAMES
