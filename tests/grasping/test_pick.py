"""Each phase of a pick ends in its named outcome, on a robot without physics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.data_synth.scenes import TabletopObject
from eyehand.grasping.cell import Cell
from eyehand.grasping.clearing import ClearOptions, clear_table
from eyehand.grasping.report import PickReport
from eyehand.grasping.tray import Tray
from eyehand.perception import Superquadric

from .fake_robot import FakeRobot

TRAY = Tray(np.array([0.0, -0.45, 0.006]), (0.25, 0.3), 0.05)
VIEW = np.array([0.0, 0.5, 0.9])


def box(x=0.05, size=(0.02, 0.02, 0.03), name="box_1"):
    pose = RigidTransform.from_translation([x, 0.0, size[2]])
    shape = Superquadric(np.array(size), (0.1, 0.1), pose, "box")
    return TabletopObject(name, shape, 0.1, (0.8, 0.2, 0.2))


def run(robot, *scenes, **options):
    """Clear a table that shows these objects, look by look; the last look again and again."""
    shown = [list(objects) for objects in scenes]

    def see(_frame):
        objects = shown.pop(0) if len(shown) > 1 else shown[0]
        return ground_truth_scene(objects, VIEW)

    cell = Cell(robot, see, TRAY)
    robot.palm_height = lambda q: cell.palm_pose().translation[2]
    return clear_table(cell, options=ClearOptions(**options)), cell


def first(robot, *scenes) -> PickReport:
    report, _ = run(robot, *scenes, failures=1)
    return report.picks[0]


def test_what_is_held_is_lifted_and_put_into_the_tray():
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


def test_a_hand_that_closes_on_nothing_says_so():
    pick = first(FakeRobot(holds=None), [box()])
    assert pick.outcome == "empty_close"
    assert pick.phases[-1].phase == "close"


def test_an_object_gone_at_the_next_look_has_moved_away():
    pick = first(FakeRobot(holds=None), [box()], [box(x=-0.1)])
    assert pick.outcome == "moved_away"
    assert "no longer at its place" in pick.reason


def test_what_slips_in_the_lift_is_told_from_what_is_lost_later():
    good = first(FakeRobot(), [box()], [])
    times = {record.phase: record for record in good.phases}
    lifting = FakeRobot(drops_at=times["lift"].start + 0.1)
    assert first(lifting, [box()], []).outcome == "slipped"
    carrying = FakeRobot(drops_at=times["place"].start + 0.2)
    assert first(carrying, [box()], []).outcome == "lost"


def test_a_thumb_that_meets_something_too_early_moves_the_hand_beside_it():
    assert first(FakeRobot(bumps=1), [box()], []).outcome == "placed"
    stubborn = first(FakeRobot(bumps=99), [box()])
    assert stubborn.outcome == "no_contact"
    assert "thumb" in stubborn.reason


def test_a_fault_ends_everything_and_is_told():
    robot = FakeRobot(breaks_at=1.0)
    report, _ = run(robot, [box()])
    assert report.picks[0].outcome == "fault"
    assert report.stop_reason == "the arm has lost its power"
    assert robot.time < 1.1


def test_a_failed_object_is_tried_another_way_then_left_alone():
    report, cell = run(FakeRobot(holds=None), [box()], failures=9)
    assert len(report.picks) == cell.options.max_attempts
    first_plan, second_plan = (pick.plan for pick in report.picks)
    assert first_plan.name != second_plan.name or not np.allclose(
        np.abs(first_plan.closing @ second_plan.closing), 1.0
    )
    assert report.stop_reason == "no remaining object can be grasped"
    assert "skipped after 2 attempts" in report.remaining[0]


def test_two_failures_in_a_row_end_a_trial():
    boxes = [box(), box(-0.1, name="box_2"), box(0.15, name="box_3")]
    report, _ = run(FakeRobot(holds=None), boxes)
    assert len(report.picks) == 2
    assert report.stop_reason == "2 picks failed in a row"


def test_an_empty_table_is_clear():
    report, _ = run(FakeRobot(), [])
    assert report.stop_reason == "clear"
    assert report.picks == ()


@pytest.mark.parametrize("size", [(0.08, 0.08, 0.08), (0.2, 0.2, 0.02)])
def test_what_is_wider_than_the_hand_is_left_with_the_reason(size):
    report, _ = run(FakeRobot(), [box(size=size)])
    assert report.picks == ()
    assert report.remaining
    assert "mm" in report.remaining[0]


def test_fingertips_on_each_other_hold_nothing_of_a_wide_object():
    failed = first(FakeRobot(holds=0.008), [box()], [])
    assert failed.outcome == "slipped"
    assert "apart on an object of 40 mm" in failed.reason


class StickyRobot(FakeRobot):
    """What it held hangs on the thumb of the open hand until the arm has turned round often."""

    turns = 0
    enough = 4
    grasped = False

    def felt(self, reading):
        """Give the force on every pad."""
        touch = super().felt(reading)
        self.grasped = self.grasped or bool(touch.any())
        if self.grasped and not touch.any() and self.turns < self.enough:
            touch[[pad == "thumb_distal" for pad in self.hand.pads]] = 0.3
        return touch

    def step(self, velocity, command=None):
        """Follow at once."""
        if self.grasped and self.opening() > (self.holds or 0.0):
            self.turns += bool(np.dot(velocity, self.speed) < 0.0)
        return super().step(velocity, command)


def test_what_hangs_on_the_open_hand_is_shaken_off_over_the_tray():
    assert first(StickyRobot(), [box()], []).outcome == "placed"
    stuck = StickyRobot()
    stuck.enough = 10_000
    failed = first(stuck, [box()], [])
    assert failed.outcome == "place_failed"
    assert "hangs on thumb_distal" in failed.reason
