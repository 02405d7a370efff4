"""Outcomes of each phase of a pick, with a fake robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.data_synth.scenes import TabletopObject
from eyehand.grasping import grasp_phases
from eyehand.grasping import pick as pick_phases
from eyehand.grasping.cell import Cell
from eyehand.grasping.clearing import ClearOptions, clear_table
from eyehand.grasping.hands.finger_control import FingerControl
from eyehand.grasping.pick_state import PhaseFailure, PickState
from eyehand.grasping.report import PickReport
from eyehand.grasping.tray import Tray
from eyehand.perception import Superquadric

from .fake_robot import PERIOD, FakeRobot

TRAY = Tray(np.array([0.0, -0.45, 0.006]), (0.25, 0.3), 0.05)
VIEW = np.array([0.0, 0.5, 0.9])


def box(x=0.05, size=(0.02, 0.02, 0.03), name="box_1"):
    pose = RigidTransform.from_translation([x, 0.0, size[2]])
    shape = Superquadric(np.array(size), (0.1, 0.1), pose, "box")
    return TabletopObject(name, shape, 0.1, (0.8, 0.2, 0.2))


def run(robot, *scenes, **options):
    """Clear a table that shows these objects, one list per observation; the last list repeats."""
    shown = [list(objects) for objects in scenes]

    def perceive(_frame):
        objects = shown.pop(0) if len(shown) > 1 else shown[0]
        return ground_truth_scene(objects, VIEW)

    cell = Cell(robot, perceive, TRAY)
    robot.palm_height = lambda q: cell.palm_pose().translation[2]
    return clear_table(cell, options=ClearOptions(**options)), cell


def first_pick(robot, *scenes) -> PickReport:
    report, _ = run(robot, *scenes, failures=1)
    return report.picks[0]


def test_held_object_is_lifted_and_placed_in_tray():
    report, _ = run(FakeRobot(), [box()], [])
    (pick,) = report.picks
    assert pick.outcome == "placed"
    assert pick
    assert [record.phase for record in pick.phases] == [
        "pre-grasp", "approach", "contact", "close", "grip", "lift", "check", "place",
    ]  # fmt: skip
    assert all(record.outcome == "done" for record in pick.phases)
    assert report.stop_reason == "clear"
    assert report.placed == 1
    assert pick.forces.shape == (len(pick.times), 5)
    assert np.isfinite(pick.forces).all()
    assert pick.plan.rows < 6
    assert 0 < pick.seconds < 10


@pytest.mark.parametrize("period", [0.004, 0.008, 0.02])
def test_clock_in_milliseconds_is_a_fault_of_the_first_pick(period, monkeypatch):
    """The time limit of the first motion is over after one, two or three steps."""
    robot = FakeRobot()
    robot.period, read = period, robot.read
    unit = 1e3 * period / PERIOD
    monkeypatch.setattr(robot, "read", lambda: replace(read(), time=unit * robot.time))

    pick = first_pick(robot, [box()])

    assert pick.outcome == "fault", pick
    assert "write the times in s" in pick.reason


def test_closing_without_object_is_empty_close():
    pick = first_pick(FakeRobot(object_width=None), [box()])
    assert pick.outcome == "empty_close"
    assert pick.phases[-1].phase == "close"


def test_missed_object_found_elsewhere_has_moved_away():
    pick = first_pick(FakeRobot(object_width=None), [box()], [box(x=-0.1)])
    assert pick.outcome == "moved_away"
    assert "no longer at its place" in pick.reason


def test_loss_during_lift_is_slipped_and_later_is_lost():
    good = first_pick(FakeRobot(), [box()], [])
    times = {record.phase: record for record in good.phases}
    lifting = FakeRobot(lost_at=times["lift"].start + 0.1)
    assert first_pick(lifting, [box()], []).outcome == "slipped"
    carrying = FakeRobot(lost_at=times["place"].start + 0.2)
    assert first_pick(carrying, [box()], []).outcome == "lost"


def test_hand_that_does_not_let_go_after_a_failed_phase_ends_clearing(monkeypatch):
    stalled = PhaseFailure("hand_stalled", "the hand does not let go")
    monkeypatch.setattr(PickState, "release", lambda *_: stalled)
    robot = FakeRobot(object_width=None)
    report, cell = run(robot, [box()])
    (pick,) = report.picks
    assert (pick.outcome, pick.phases[-1].phase) == ("hand_stalled", "close")
    assert "does not let go" in report.stop_reason
    assert np.linalg.norm(robot.q - cell.home) > 0.1, "the arm stays"


def stall(monkeypatch, times):
    """Let the hand stall in the first closings."""
    close_once, stalls = grasp_phases._close_once, iter(range(times))  # pyright: ignore[reportPrivateUsage]
    failure = PhaseFailure("hand_stalled", "the hand stopped at 79 mm")

    def stalled(cell, state):
        return close_once(cell, state) if next(stalls, None) is None else (failure, 0.0)

    monkeypatch.setattr(grasp_phases, "_close_once", stalled)


@pytest.mark.parametrize(("stalls", "outcomes"), [(1, ["hand_stalled", "placed"]), (2, [])])
def test_hand_that_opens_after_a_stalled_closing_tries_again_once(monkeypatch, stalls, outcomes):
    stall(monkeypatch, stalls)
    scenes = ([box()], [box()], []) if outcomes else ([box()],)
    report, _ = run(FakeRobot(), *scenes, failures=3)
    assert [pick.outcome for pick in report.picks] == (outcomes or ["hand_stalled"] * 2)
    assert report.stop_reason.startswith("clear" if outcomes else "the hand does not follow")


def test_hand_that_stays_narrow_after_a_stalled_closing_ends_clearing(monkeypatch):
    stall(monkeypatch, 1)
    monkeypatch.setattr(FingerControl, "width", lambda *_: 0.03)
    report, _ = run(FakeRobot(), [box()], failures=3)
    assert [pick.outcome for pick in report.picks] == ["hand_stalled"]
    assert report.stop_reason.startswith("the hand does not follow")


def test_jaws_that_keep_the_object_over_the_tray_are_waited_for_once(monkeypatch):
    """A second wait for the same jaws took 4.5 s more."""
    releases = []

    def release(*_):
        releases.append(True)
        return PhaseFailure("hand_stalled", "the hand does not let go")

    monkeypatch.setattr(PickState, "release", release)
    pick = first_pick(FakeRobot(), [box()])
    assert (pick.outcome, pick.phases[-1].phase) == ("hand_stalled", "place")
    assert len(releases) == 1


def test_early_thumb_contact_shifts_hand_once_then_fails():
    assert first_pick(FakeRobot(thumb_contacts=1), [box()], []).outcome == "placed"
    stubborn = first_pick(FakeRobot(thumb_contacts=99), [box()])
    assert stubborn.outcome == "no_contact"
    assert "thumb" in stubborn.reason


class BrushingRobot(FakeRobot):
    """The middle fingertip brushes something for one cycle, high above the object."""

    lowest = np.inf
    brush_height = 0.0

    def pad_forces(self, reading):
        """Return the force on every pad, (P,), N."""
        touch = super().pad_forces(reading)
        height = self.palm_height(self.q)
        if self.lowest > self.brush_height > height:
            touch[[pad == "middle_distal" for pad in self.hand.pads]] = 1.0
        self.lowest = min(self.lowest, height)
        return touch


def test_brief_touch_above_the_object_does_not_end_the_approach():
    undisturbed, brushing = BrushingRobot(), BrushingRobot()
    assert first_pick(undisturbed, [box()], []).outcome == "placed"
    brushing.brush_height = undisturbed.lowest + 0.06
    assert first_pick(brushing, [box()], []).outcome == "placed"
    assert brushing.lowest == pytest.approx(undisturbed.lowest, abs=0.002)


def test_approach_ends_at_the_planned_height():
    robot = BrushingRobot()
    plan = first_pick(robot, [box()], []).plan
    assert plan.approach == "top"
    assert plan.geometry is not None
    # Fingertips some mm higher squeeze low round objects out.
    assert robot.lowest == pytest.approx(plan.geometry.centre[2] + plan.standoff, abs=0.002)


def test_robot_fault_stops_clearing_with_reason():
    robot = FakeRobot(fault_at=1.0)
    report, _ = run(robot, [box()])
    assert report.picks[0].outcome == "fault"
    assert report.stop_reason == "the arm has lost its power"
    assert report.remaining == ("object 1: not tried",)
    assert robot.time < 1.1


def test_failed_object_is_tried_with_another_grasp_then_skipped():
    report, cell = run(FakeRobot(object_width=None), [box()], failures=9)
    assert len(report.picks) == cell.options.max_attempts
    first_plan, second_plan = (pick.plan for pick in report.picks)
    assert first_plan.name != second_plan.name or not np.allclose(
        np.abs(first_plan.closing @ second_plan.closing), 1.0
    )
    assert report.stop_reason == "no remaining object can be grasped"
    assert "skipped after 2 attempts" in report.remaining[0]


def test_two_failures_in_row_stop_clearing():
    boxes = [box(), box(-0.1, name="box_2"), box(0.15, name="box_3")]
    report, _ = run(FakeRobot(object_width=None), boxes)
    assert len(report.picks) == 2
    assert report.stop_reason == "2 picks failed in a row"


def test_empty_table_is_clear():
    report, _ = run(FakeRobot(), [])
    assert report.stop_reason == "clear"
    assert report.picks == ()


@pytest.mark.parametrize("size", [(0.08, 0.08, 0.08), (0.2, 0.2, 0.02)])
def test_object_wider_than_hand_remains_with_reason(size):
    report, _ = run(FakeRobot(), [box(size=size)])
    assert report.picks == ()
    assert report.remaining
    assert "mm" in report.remaining[0]


def test_grip_narrower_than_object_is_slipped():
    failed = first_pick(FakeRobot(object_width=0.008), [box()], [])
    assert failed.outcome == "slipped"
    assert "apart on an object of 40 mm" in failed.reason


class StickyRobot(FakeRobot):
    """The held object sticks to the thumb of the open hand until the arm reversed several times."""

    reversals = 0
    reversals_to_release = 4
    grasped = False

    def pad_forces(self, reading):
        """Return the force on every pad, (P,), N."""
        touch = super().pad_forces(reading)
        self.grasped = self.grasped or bool(touch.any())
        if self.grasped and not touch.any() and self.reversals < self.reversals_to_release:
            touch[[pad == "thumb_distal" for pad in self.hand.pads]] = 0.3
        return touch

    def step(self, velocity, command=None):
        """Move by one period without lag."""
        if self.grasped and self.opening() > (self.object_width or 0.0):
            self.reversals += bool(np.dot(velocity, self.speed) < 0.0)
        return super().step(velocity, command)


def test_object_sticking_to_open_hand_is_shaken_off_over_tray():
    assert first_pick(StickyRobot(), [box()], []).outcome == "placed"
    stuck = StickyRobot()
    stuck.reversals_to_release = 10_000
    failed = first_pick(stuck, [box()], [])
    assert failed.outcome == "place_failed"
    assert "hangs on thumb_distal" in failed.reason


@pytest.mark.parametrize(("phase", "moved_off"), [("pre-grasp", False), ("approach", True)])
def test_hand_on_its_way_is_not_moved_off(phase, moved_off, monkeypatch):
    """That motion ignores obstacles: an arm that was late at the pre-grasp hit the table."""
    calls = []
    late = ((phase, lambda *_: PhaseFailure("stuck", "not reached after 9 s")),)
    monkeypatch.setattr(pick_phases, "PHASES", late)
    monkeypatch.setattr(PickState, "release", lambda *_: calls.append(phase))
    assert first_pick(FakeRobot(), [box()], []).outcome == "stuck"
    assert bool(calls) == moved_off
