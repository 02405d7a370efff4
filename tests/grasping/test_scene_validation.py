"""A look that tells too little ends the clearing in words, and never as a clear table."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.grasp.true_scene import known_scene
from eyehand.errors import InputError
from eyehand.grasping.cell import Cell
from eyehand.grasping.clearing import LOOKS, clear_table
from eyehand.grasping.scene_validation import LEAST_SEEN, doubts, unexplained
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
    ("share", "support", "says"),
    [
        (1.0, tilted(0.0), ""),
        (0.5, tilted(0.0), ""),
        (1.0, tilted(2.5), ""),
        (1.0, tilted(0.0, 0.2), ""),
        (0.2, tilted(0.0), "20% of the image"),
        (1.0, None, "no level surface"),
        (1.0, tilted(3.5), "tilts by 3.5°"),
        (1.0, tilted(180.0), "tilts by 180.0°"),
        (1.0, tilted(0.0, -0.72), "0.73 m below the tray"),
        (1.0, tilted(0.0, 0.72), "0.71 m above the tray"),
    ],
)
def test_doubts_name_what_is_wrong(share, support, says):
    scene = replace(known_scene([], VIEW), support=support)
    told = doubts(frame(share), scene, TRAY)
    assert says in told
    assert bool(told) == bool(says)


def refuse(_frame):
    raise InputError("depth is 0 everywhere")


def show_no_table(_frame):
    return replace(known_scene([], VIEW), support=None)


@pytest.mark.parametrize(("see", "says"), [(refuse, "0 everywhere"), (show_no_table, "a table")])
def test_a_blind_look_ends_the_clearing_and_moves_nothing(see, says):
    robot = FakeRobot()
    start = robot.read().q
    report = clear_table(Cell(robot, see, TRAY))
    assert report.stopped.startswith("cannot see")
    assert says in report.stopped
    assert (report.picks, report.looks) == ((), 1)
    np.testing.assert_array_equal(robot.read().q, start)


def test_a_camera_that_gives_nothing_ends_the_clearing_in_words(monkeypatch):
    robot = FakeRobot()
    monkeypatch.setattr(robot, "look", lambda: refuse(None))
    report = clear_table(Cell(robot, lambda _: known_scene([], VIEW), TRAY))
    assert report.stopped == "cannot see: depth is 0 everywhere"


def test_a_table_seen_empty_is_clear():
    report = clear_table(Cell(FakeRobot(), lambda _: known_scene([], VIEW), TRAY))
    assert report.stopped == "clear"


FROM_ABOVE = RigidTransform.from_components([0.0, 0.0, 1.0], Rotation.from_euler("x", np.pi))
NEAR_LENS = CameraIntrinsics(200.0, 200.0, 39.5, 39.5, 80, 80)


def looked_down_on(high: float, side: int):
    """Show a table 1 m below the camera, and on it a block of so many pixels across."""
    depth = np.ones((80, 80), np.float32)
    depth[30 : 30 + side, 30 : 30 + side] -= high
    labels = np.zeros(depth.shape, np.int32)
    scene = known_scene([], FROM_ABOVE.translation)
    scene = replace(scene, segmentation=Segmentation(labels, None, 0.0, {}))
    return DepthFrame(depth, NEAR_LENS, FROM_ABOVE), scene


def test_what_stands_on_the_table_and_is_no_object_leaves_a_doubt():
    frame, scene = looked_down_on(high=0.1, side=3)
    # 9 pixels of 4.5 x 4.5 mm.
    assert unexplained(frame, scene) == pytest.approx(9 * (0.9 / 200.0) ** 2, rel=1e-5)
    assert "2 cm² above it belong to no object" in doubts(frame, scene, TRAY)


@pytest.mark.parametrize(("high", "side"), [(0.0, 0), (0.003, 8), (0.1, 2), (0.7, 8)])
def test_noise_flying_pixels_and_what_hangs_above_leave_none(high, side):
    frame, scene = looked_down_on(high, side)
    assert unexplained(frame, scene) <= LEAST_SEEN
    assert doubts(frame, scene, TRAY) == ""


def test_what_belongs_to_an_object_leaves_none():
    frame, scene = looked_down_on(0.1, 8)
    labels = (frame.depth < 0.95).astype(np.int32)
    scene = replace(scene, segmentation=replace(scene.segmentation, labels=labels))
    assert unexplained(frame, scene) == 0.0


def test_a_look_that_leaves_a_doubt_is_made_of_more_images(monkeypatch):
    robot, taken = FakeRobot(), []
    whole = robot.look()

    def half() -> DepthFrame:
        taken.append(len(taken))
        depth = np.where(np.arange(32) % 3 == len(taken) % 3, whole.depth, 0.0)
        return replace(whole, depth=depth.astype(np.float32))

    monkeypatch.setattr(robot, "look", half)
    report = clear_table(Cell(robot, lambda _: known_scene([], VIEW), TRAY))
    assert (report.stopped, report.looks) == ("clear", 1)
    assert len(taken) == LOOKS
