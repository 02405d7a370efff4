"""A look that tells too little ends the clearing in words, and never as a clear table."""

from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.grasp.known_scene import known_scene
from eyehand.errors import InputError
from eyehand.grasping.cell import Cell
from eyehand.grasping.clear_table import clear_table
from eyehand.grasping.sight import doubts
from eyehand.grasping.tray import Tray
from eyehand.perception import CameraIntrinsics, DepthFrame, SupportPlane

from .made_up_robot import MadeUpRobot

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
    robot = MadeUpRobot()
    start = robot.read().q
    report = clear_table(Cell(robot, see, TRAY))
    assert report.stopped.startswith("cannot see")
    assert says in report.stopped
    assert (report.picks, report.looks) == ((), 1)
    np.testing.assert_array_equal(robot.read().q, start)


def test_a_camera_that_gives_nothing_ends_the_clearing_in_words(monkeypatch):
    robot = MadeUpRobot()
    monkeypatch.setattr(robot, "look", lambda: refuse(None))
    report = clear_table(Cell(robot, lambda _: known_scene([], VIEW), TRAY))
    assert report.stopped == "cannot see: depth is 0 everywhere"


def test_a_table_seen_empty_is_clear():
    report = clear_table(Cell(MadeUpRobot(), lambda _: known_scene([], VIEW), TRAY))
    assert report.stopped == "clear"
