"""The next scene corrects the reported outcome of a pick."""

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


def box_beside_tray():
    one = box()
    pose = RigidTransform.from_translation([0.0, -0.27, 0.03])
    return replace(one, shape=replace(one.shape, pose=pose))


@pytest.fixture(scope="module")
def plan() -> GraspPlan:
    report, _ = run(FakeRobot(), [box()], [])
    return report.picks[0].plan


def verified(plan, outcome: PickOutcome, before, after) -> PickReport:
    scene = ground_truth_scene(before, VIEW)
    report = PickReport(
        label=1, kind="box", plan=plan, outcome=outcome, reason="why", phases=(), perceive_ms=0.0,
        plan_ms=0.0, times=np.zeros(0), forces=np.zeros((0, 5)), contact_pads=0, finger_curl=0.0,
    )  # fmt: skip
    return verify_pick(
        report, SelectedGrasp(scene, scene.objects[0], plan), ground_truth_scene(after, VIEW), TRAY
    )


@pytest.mark.parametrize(
    ("outcome", "after", "expected"),
    [
        ("placed", [], "placed"),
        ("placed", [box(x=0.06)], "empty_close"),
        ("placed", [box_beside_tray()], "place_failed"),
        # The fingertips held something until the release.
        ("placed", [box(x=0.2)], "placed"),
        # Another size: an object that was hidden behind the picked one.
        ("placed", [box(x=0.2, size=(0.03, 0.03, 0.03))], "placed"),
        ("empty_close", [box(x=0.06)], "empty_close"),
        ("empty_close", [box(x=0.2)], "moved_away"),
        ("slipped", [box(x=0.2)], "slipped"),
    ],
)
def test_next_scene_determines_outcome(plan, outcome, after, expected):
    assert verified(plan, outcome, [box()], after).outcome == expected


def test_object_elsewhere_after_power_grasp_is_lost(plan):
    power = replace(plan, prototype="power")
    assert verified(power, "placed", [box()], [box(x=0.2)]).outcome == "lost"


def test_equal_objects_are_not_mistaken_for_picked_one(plan):
    twins = [box(), box(x=0.2, name="box_2"), box(x=-0.2, name="box_3")]
    assert verified(plan, "placed", twins, twins[1:]).outcome == "placed"
    assert verified(plan, "placed", twins, twins).outcome == "empty_close"
    # One object fewer than before: one was pushed aside, and the picked one is gone.
    assert verified(plan, "placed", twins, [box(x=0.25), twins[2]]).outcome == "placed"


def test_wrongly_placed_report_is_corrected_and_object_picked_again():
    shown, outcomes = [[box()], [box()], []], []
    cell = Cell(
        FakeRobot(), lambda _: ground_truth_scene(shown.pop(0) if shown else [], VIEW), TRAY
    )

    def on_pick(_choice, pick):
        outcomes.append(None if pick is None else pick.outcome)

    report = clear_table(cell, on_pick=on_pick)
    assert [pick.outcome for pick in report.picks] == ["empty_close", "placed"]
    assert outcomes == [None, "empty_close", None, "placed"]
    assert "still at its place" in report.picks[0].reason
    assert report.placed == 1
