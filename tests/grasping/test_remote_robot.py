"""Picks over a process boundary with delays, and faults that end in named outcomes."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import asdict
from functools import cache
from multiprocessing.connection import Listener
from pathlib import Path

import numpy as np
import pytest

from eyehand.control import CollisionWorld
from eyehand.data_synth.cell import GraspCell
from eyehand.data_synth.cell.robot_names import FOLDER_VARIABLE, robot_file
from eyehand.errors import InputError
from eyehand.grasping import Cell, ClearOptions, Tray, clear_table
from eyehand.grasping.tray_plan import TrayItem, content_obstacles
from eyehand.perception import perceive

from . import delayed_robot
from .delayed_robot import KEY, Faults

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "remote_robot.py"
PLACE = GraspCell()
ROBOTS = Path(__file__).resolve().parents[2].parent / "shared" / "robots"


@pytest.fixture(scope="module", autouse=True)
def robots():
    """Name the folder of the robots' files."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        if ROBOTS.is_dir():
            monkeypatch.setenv(FOLDER_VARIABLE, str(ROBOTS))
        try:
            robot_file("franka_emika_panda/panda.xml")
        except InputError as error:
            pytest.skip(str(error))
        yield


@pytest.fixture(scope="module")
def remote(robots):
    """Return a context manager that joins the drivers of a new robot, as the example shows.

    One process simulates all robots, one after the other. Its start takes longer than a pick.
    """
    with Listener(("localhost", 0), authkey=KEY) as listener:
        words = [sys.executable, delayed_robot.__file__, str(listener.address[1])]
        process = subprocess.Popen(words)

        @contextmanager
        def connect(faults: Faults):
            assert process.poll() is None, f"the robot ended with exit code {process.returncode}"
            with listener.accept() as connection:
                connection.send(asdict(faults))
                assert connection.recv() == "ready"
                make = runpy.run_path(str(EXAMPLE))["remote_robot"]
                yield make(connection, PLACE.T_world_base)

        yield connect
    process.wait(20.0)


@pytest.fixture(scope="module")
def clear(remote):
    """Return a function that clears the table with a robot that has these faults."""

    @cache
    def run(faults: Faults):
        tray = Tray(np.array(PLACE.tray_centre), PLACE.tray_size, PLACE.tray_height)
        with remote(faults) as robot:
            options = ClearOptions(failures=1, capture_over_tray=False)
            return clear_table(Cell(robot, perceive, tray), options=options)

    return run


def test_example_is_short():
    lines = [line for line in EXAMPLE.read_text().splitlines() if line.strip()]
    assert len(lines) <= 40


@pytest.mark.parametrize("effort", [True, False], ids=["width and effort", "width alone"])
def test_object_is_placed_over_a_process_boundary_with_delay_and_jitter(effort, clear):
    report = clear(Faults(effort=effort))

    assert report.picks[0].outcome == "placed", report
    assert report.cleared


def test_jaws_touch_nothing_that_stands_in_the_tray_while_they_put_an_object_down(remote):
    """Jaws opened 13 to 29 mm into objects beside the new one."""
    tray = Tray(np.array(PLACE.tray_centre), PLACE.tray_size, PLACE.tray_height)
    places = [(x, y) for x in (-0.07, 0.07) for y in (-0.1, 0.0, 0.1)]
    nearest = []
    with remote(Faults()) as robot:
        cell = Cell(robot, perceive, tray)
        cell.tray_content = [TrayItem(tray.centre[:2] + at, 0.025, 0.2) for at in places]
        content = content_obstacles(tray, cell.tray_content)
        world = CollisionWorld(cell.model(cell.hand.posture(cell.hand.max_opening)), content)

        def on_cycle(cycle):
            if cycle.phase == "place":
                nearest.append(world.proximity(cycle.reading.q).distance.min())

        cell.on_cycle = on_cycle
        report = clear_table(cell, options=ClearOptions(failures=1, capture_over_tray=False))

    assert report.picks[0].outcome == "placed", report
    assert len(cell.tray_content) == len(places) + 1
    assert min(nearest) > 0.0


def test_stalled_gripper_is_named(clear):
    report = clear(Faults(gripper_stalls=0.0))

    assert report.picks[0].outcome == "hand_stalled", report
    assert re.search(r"the hand stopped at (79|80) mm", report.picks[0].reason)


def test_arm_waits_at_its_place_for_jaws_that_do_not_let_go(clear):
    """A gripper that stops while the arm carries the object; the arm must not leave with it."""
    report = clear(Faults(gripper_stalls=4.9))

    (pick,) = report.picks
    assert pick.outcome == "hand_stalled", report
    assert "does not let go" in pick.reason
    assert pick.phases[-1].phase == "place"
    assert report.stop_reason.startswith("the hand does not follow")


@pytest.mark.parametrize("late", [0.5, 1.2])
def test_late_gripper_lets_go_before_the_arm_leaves(late, clear):
    """Placing takes at least 0.3 s longer than without the delay."""
    usual, report = clear(Faults()), clear(Faults(gripper_late=late))

    assert report.picks[0].outcome == "placed", report
    last = [one.picks[0].phases[-1] for one in (usual, report)]
    assert [phase.phase for phase in last] == ["place", "place"]
    assert last[1].end - last[1].start > last[0].end - last[0].start + 0.3


@pytest.mark.parametrize("speed", [0.008, 0.0005])
def test_slow_gripper_closes_until_it_holds_or_is_named(speed, clear):
    """The jaws of 8 mm/s need 5 s to the object; those of 0.5 mm/s do not count as moving."""
    report = clear(Faults(gripper_speed=speed))

    if speed > 0.005:
        assert all(phase.outcome == "done" for phase in report.picks[0].phases), report
        # The object may fall later. The next image must show it.
        assert len(report.picks) == 1, report
        assert bool(report.picks[0]) == report.cleared, report
    else:
        assert report.picks[0].outcome == "hand_stalled", report
        assert "the hand stopped at 7" in report.picks[0].reason


def test_arm_that_stops_is_a_fault_and_dropped_frames_are_captured_again(clear):
    report = clear(Faults(arm_stops=1.0, frames_dropped=2))

    assert report.picks[0].outcome == "fault"
    assert "the arm does not follow" in report.stop_reason


def test_arm_without_new_state_is_a_fault(clear):
    report = clear(Faults(arm_silent=1.0))

    assert report.picks[0].outcome == "fault"
    assert "no new state" in report.stop_reason


def test_camera_without_frames_ends_clearing_with_its_reason(clear):
    report = clear(Faults(frames_dropped=100))

    assert not report.picks
    assert "the camera gave no image in 3 attempts" in report.stop_reason
