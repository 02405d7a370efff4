"""The next scene corrects the reported outcome of a pick."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.grasping.cell import Cell
from eyehand.grasping.clearing import clear_table
from eyehand.grasping.depth_change import DepthChange
from eyehand.grasping.pick_state import SelectedGrasp
from eyehand.grasping.pick_verification import verify_pick
from eyehand.grasping.plan import GraspPlan
from eyehand.grasping.report import PickOutcome, PickReport
from eyehand.perception import CameraIntrinsics, DepthFrame

from .fake_robot import FakeRobot
from .test_pick import TRAY, VIEW, box, run

CAMERA = CameraIntrinsics(600.0, 600.0, 319.5, 319.5, 640, 640)
HEIGHT = 1.2
"""Height of the camera, which looks straight down, m."""
NOISE = 1e-3
"""Noise of disparity, 1/m."""


def box_beside_tray():
    one = box()
    pose = RigidTransform.from_translation([0.0, -0.27, 0.03])
    return replace(one, shape=replace(one.shape, pose=pose))


@pytest.fixture(scope="module")
def plan() -> GraspPlan:
    report, _ = run(FakeRobot(), [box()], [])
    return report.picks[0].plan


def tops_seen(objects, seed):
    """Return the depth image of the tops of boxes on the table, and the scene of these tops."""
    rng = np.random.default_rng(seed)
    down = Rotation.from_euler("x", 180, degrees=True)
    pose = RigidTransform.from_components([0.0, -0.1, HEIGHT], down)
    scene, depth, seen = ground_truth_scene(objects, VIEW), np.full((640, 640), HEIGHT), []
    for item, one in zip(scene.objects, objects, strict=True):
        half, centre = one.shape.semi_axes, one.shape.pose.translation
        x, y = np.meshgrid(*(np.linspace(-0.9, 0.9, 12) * side for side in half[:2]))
        top = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, half[2])]) + centre
        corners = CAMERA.project(pose.inv().apply(centre + half * [[-1, 1, 1], [1, -1, 1]]))
        (u0, v0), (u1, v1) = np.rint(corners).astype(int)
        depth[v0 : v1 + 1, u0 : u1 + 1] = HEIGHT - top[0, 2]
        seen.append(replace(item, points=top))
    depth = (1.0 / (1.0 / depth + NOISE * rng.standard_normal(depth.shape))).astype(np.float32)
    segmentation = replace(scene.segmentation, noise=NOISE)
    scene = replace(scene, objects=tuple(seen), segmentation=segmentation)
    return DepthFrame(depth, CAMERA, pose), scene


def verified_by_depth(plan, before, after, outcome: PickOutcome = "placed") -> PickReport:
    frame, scene = tops_seen(before, 1)
    later, new_scene = tops_seen(after, 2)
    return verify_pick(
        placed_report(plan, outcome),
        SelectedGrasp(scene, scene.objects[0], plan),
        new_scene,
        TRAY,
        DepthChange(frame, scene, later, new_scene),
    )


def placed_report(plan, outcome: PickOutcome) -> PickReport:
    return PickReport(
        label=1, kind="box", plan=plan, outcome=outcome, reason="why", phases=(), perceive_ms=0.0,
        plan_ms=0.0, times=np.zeros(0), forces=np.zeros((0, 5)), contact_pads=0, finger_curl=0.0,
    )  # fmt: skip


def verified(plan, outcome: PickOutcome, before, after) -> PickReport:
    scene = ground_truth_scene(before, VIEW)
    report = placed_report(plan, outcome)
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


TALL, LOW = (0.03, 0.03, 0.05), (0.02, 0.03, 0.02)
"""Half sizes of two neighbours, m."""


def test_picked_neighbour_is_wrong_object(plan):
    pile = [box(), box(x=0.15, size=TALL, name="box_2"), box(x=-0.2, size=LOW, name="box_3")]
    for picked in (1, 2):
        left = [one for k, one in enumerate(pile) if k != picked]
        assert verified_by_depth(plan, pile, left).outcome == "wrong_object"
    assert verified_by_depth(plan, pile, pile[1:]).outcome == "placed"
    assert verified_by_depth(plan, pile, pile).outcome == "empty_close"
    # Touch already reported the failure.
    assert verified_by_depth(plan, pile, pile[:2], "slipped").outcome == "slipped"


def test_pushed_neighbour_is_no_wrong_object(plan):
    pile = [box(), box(x=0.15, size=TALL, name="box_2")]
    pushed = box(x=0.25, size=TALL, name="box_2")
    assert verified_by_depth(plan, pile, [pushed]).outcome == "placed"
    assert verified_by_depth(plan, pile, [pile[0], pushed]).outcome == "empty_close"


def test_fallen_object_is_found_among_new_surfaces(plan):
    pile = [box(), box(x=0.15, size=TALL, name="box_2")]
    # From above, a fallen object may show another size.
    fallen = box_beside_tray()
    fallen = replace(fallen, shape=replace(fallen.shape, semi_axes=np.array([0.03, 0.02, 0.03])))
    report = verified_by_depth(plan, pile, [pile[1], fallen])
    assert report.outcome == "place_failed"
    assert verified_by_depth(plan, pile, [pile[1], box(x=-0.2)]).outcome == "lost"
    # Its place may overlap the former one.
    assert verified_by_depth(plan, pile, [pile[1], box(x=0.015)]).outcome == "lost"
    # An object that was hidden has another size.
    hidden = box(x=-0.2, size=TALL, name="box_3")
    assert verified_by_depth(plan, pile, [pile[1], hidden]).outcome == "placed"


def test_surface_without_readings_decides_nothing():
    frame, scene = tops_seen([box()], 1)
    later = frame.without(frame.depth < HEIGHT - 0.03)
    change = DepthChange(frame, scene, later, scene)
    assert change.remaining(scene.objects[0].points) is None
    assert DepthChange(frame, scene, frame, scene).remaining(scene.objects[0].points) == 1.0


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
