"""The next look revises what a pick tells of itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.grasping.cell import Cell
from eyehand.grasping.clearing import clear_table
from eyehand.grasping.pick_state import SelectedGrasp
from eyehand.grasping.pick_verification import verify_pick
from eyehand.grasping.plan import GraspPlan
from eyehand.grasping.report import PickOutcome, PickReport

from .fake_robot import FakeRobot
from .test_pick import TRAY, VIEW, box, run


def at_the_tray():
    one = box()
    pose = RigidTransform.from_translation([0.0, -0.27, 0.03])
    return replace(one, shape=replace(one.shape, pose=pose))


@pytest.fixture(scope="module")
def plan() -> GraspPlan:
    report, _ = run(FakeRobot(), [box()], [])
    return report.picks[0].plan


def revised(plan, outcome: PickOutcome, before, after) -> PickReport:
    scene = ground_truth_scene(before, VIEW)
    report = PickReport(
        label=1, kind="box", plan=plan, outcome=outcome, reason="why", phases=(), perceive_ms=0.0,
        plan_ms=0.0, times=np.zeros(0), forces=np.zeros((0, 5)), contact_pads=0, finger_curl=0.0,
    )  # fmt: skip
    return verify_pick(
        report, SelectedGrasp(scene, scene.objects[0], plan), ground_truth_scene(after, VIEW), TRAY
    )


@pytest.mark.parametrize(
    ("outcome", "after", "says"),
    [
        ("placed", [], "placed"),
        ("placed", [box(x=0.06)], "empty_close"),
        ("placed", [at_the_tray()], "place_failed"),
        ("placed", [box(x=0.2)], "lost"),
        # Another size: it came to light behind what was picked.
        ("placed", [box(x=0.2, size=(0.03, 0.03, 0.03))], "placed"),
        ("empty_close", [box(x=0.06)], "empty_close"),
        ("empty_close", [box(x=0.2)], "moved_away"),
        ("slipped", [box(x=0.2)], "slipped"),
    ],
)
def test_what_is_seen_after_counts(plan, outcome, after, says):
    assert revised(plan, outcome, [box()], after).outcome == says


def test_the_others_are_not_taken_for_what_was_picked(plan):
    twins = [box(), box(x=0.2, name="box_2"), box(x=-0.2, name="box_3")]
    assert revised(plan, "placed", twins, twins[1:]).outcome == "placed"
    assert revised(plan, "placed", twins, twins).outcome == "empty_close"
    # Fewer than before: one was pushed aside, and the other went.
    assert revised(plan, "placed", twins, [box(x=0.25), twins[2]]).outcome == "placed"


def test_what_was_called_placed_and_still_stands_there_is_tried_again_and_told_once():
    shown, told = [[box()], [box()], []], []
    cell = Cell(
        FakeRobot(), lambda _: ground_truth_scene(shown.pop(0) if shown else [], VIEW), TRAY
    )

    def on_pick(_choice, pick):
        told.append(None if pick is None else pick.outcome)

    report = clear_table(cell, on_pick=on_pick)
    assert [pick.outcome for pick in report.picks] == ["empty_close", "placed"]
    assert told == [None, "empty_close", None, "placed"]
    assert "still at its place" in report.picks[0].reason
    assert report.placed == 1
