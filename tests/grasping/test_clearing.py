"""Clearing a table between picks: observations, return to rest, faults, layers in the tray."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.control.tasks import Orientation, Position
from eyehand.data_synth.scenes import TabletopObject
from eyehand.errors import InputError
from eyehand.grasping import JawOptions, grasp_selection, load_hand
from eyehand.grasping.cell import Cell
from eyehand.grasping.clearing import HOME_SPEED, ClearOptions, clear_table, move_home
from eyehand.grasping.failed_grasps import FailedGrasps
from eyehand.grasping.grasp_selection import select_grasp
from eyehand.grasping.motion import remaining_distance
from eyehand.grasping.pick import pick_object
from eyehand.grasping.pick_options import PickOptions
from eyehand.grasping.pick_state import PickState
from eyehand.grasping.planning import plan_prototypes
from eyehand.grasping.tray import Tray
from eyehand.perception import SceneWarning, Superquadric, SuperquadricFit

from .fake_robot import HAND, FakeRobot

TRAY = Tray(np.array([0.0, -0.45, 0.006]), (0.25, 0.3), 0.05)
VIEW = np.array([0.0, 0.5, 0.9])
HEIGHT = 0.06


def box(x=0.05):
    pose = RigidTransform.from_translation([x, 0.0, 0.5 * HEIGHT])
    shape = Superquadric(np.array([0.015, 0.015, 0.5 * HEIGHT]), (0.1, 0.1), pose, "box")
    return TabletopObject("box_1", shape, 0.1, (0.8, 0.2, 0.2))


def trial_cell(robot, *scenes):
    """Return a cell that shows these objects, one list per observation; the last list repeats."""
    shown = [list(objects) for objects in scenes or ([],)]

    def perceive(_frame):
        return ground_truth_scene(shown.pop(0) if len(shown) > 1 else shown[0], VIEW)

    cell = Cell(robot, perceive, TRAY)
    robot.palm_height = lambda q: cell.palm_pose().translation[2]
    return cell


def cleared(robot, boxes, on_cycle=None, tray=TRAY):
    """Clear a table from which every box disappears once it is picked."""
    remaining = list(boxes)

    def on_pick(choice, report):
        if report is None:
            place = choice.target.points.mean(axis=0)
            remaining.sort(key=lambda one: -np.linalg.norm(one.shape.centre - place))
            remaining.pop()

    cell = trial_cell(robot)
    cell.tray = tray
    cell.perceive = lambda _frame: ground_truth_scene(remaining, VIEW)
    cell.on_cycle = on_cycle
    return clear_table(cell, on_pick=on_pick), cell


@dataclass
class SpeedRecordingRobot(FakeRobot):
    """Records the commanded joint speed at every capture."""

    def __post_init__(self):
        super().__post_init__()
        self.speeds = []

    def capture(self):
        """Return an image that no test reads."""
        self.speeds.append(float(np.abs(self.speed).max()))
        return super().capture()


@dataclass
class ThumbContactRobot(FakeRobot):
    """Has one hard thumb contact while the open hand is far from the object."""

    contact_made: bool = False

    def pad_forces(self, reading):
        """Return the force on every pad, (P,), N."""
        touch = super().pad_forces(reading)
        if not self.contact_made and self.time > 0.3:
            self.contact_made = True
            touch[np.array([pad.startswith("thumb") for pad in HAND.pads])] = 40.0
        return touch


@dataclass
class FrictionRobot(FakeRobot):
    """Does not follow slow commands, because friction holds the joints."""

    min_speed: float = 0.045

    def step(self, velocity, command=None):
        """Move by one period, or not at all."""
        slow = np.linalg.norm(velocity) < self.min_speed and self.time > 0.3
        return super().step(np.zeros_like(velocity) if slow else velocity, command)


def test_hand_leaves_tray_without_going_down():
    cycles = []
    report, cell = cleared(FakeRobot(), [box(), box(-0.1)], cycles.append)
    assert report.placed == 2
    heights = []
    for cycle in cycles:
        cell.reading = cycle.reading
        palm = cell.palm_pose().translation
        if cycle.phase == "pre-grasp" and TRAY.contains(palm):
            heights.append(palm[2])
    assert len(heights) > 10
    assert min(heights) > heights[0] - 0.01


def test_arm_stuck_near_pre_grasp_starts_approach():
    report = clear_table(trial_cell(FrictionRobot(), [box()], []))
    pick = report.picks[0]
    before = {record.phase: record for record in pick.phases}["pre-grasp"]
    assert before.outcome == "done"
    assert before.end - before.start < 2.1


def test_arm_stands_still_at_every_capture():
    robot = SpeedRecordingRobot()
    report, _ = cleared(robot, [box(), box(-0.1)])
    assert report.placed == 2
    assert len(robot.speeds) == report.observations >= 3
    assert max(robot.speeds) == 0.0


def test_every_image_and_pick_gets_a_line(caplog):
    caplog.set_level("INFO", "eyehand")

    report, _ = cleared(FakeRobot(), [box()])

    lines = [record.getMessage() for record in caplog.records]
    assert lines[0] == "image 1: objects on the table: 1; the tray's floor is 6 mm above the table"
    assert lines.count(f"pick 1: {report.picks[0]}") == 1
    assert str(report.picks[0]).startswith("box, ")


def test_table_is_clear_only_after_observation_from_rest_posture():
    robot = FakeRobot()
    cell = trial_cell(robot, [box()], [])
    report = clear_table(cell)
    assert report.stop_reason == "clear"
    assert report.observations == 3
    assert np.allclose(robot.q, cell.home, atol=0.03)


def test_object_that_no_image_shows_after_its_pick_failed_is_missed():
    report, _ = cleared(FakeRobot(lost_at=3.0), [box()])

    (pick,) = report.picks
    assert pick.outcome == "lost"
    assert not report.cleared
    assert report.stop_reason == (
        "the image shows no object, but object 1 was not seen again: lost"
    )
    assert report.remaining == ("object 1 was not seen again: lost",)


@pytest.mark.parametrize("speed", [0.2, 1.0])
def test_speed_option_scales_the_way_home(speed):
    robot = FakeRobot(None)
    cell = trial_cell(robot)
    cell.options = PickOptions(speed=speed)
    robot.q = cell.home + 0.4
    speeds: list[float] = []
    cell.on_cycle = lambda cycle: speeds.append(float(np.linalg.norm(cycle.reading.velocity)))
    assert move_home(cell, ground_truth_scene([], VIEW))
    assert speeds
    assert max(speeds) <= 1.001 * speed * HOME_SPEED


def test_fault_during_return_is_reported_instead_of_clear_table():
    unbroken = FakeRobot()
    picked = clear_table(trial_cell(unbroken, [box()], [])).picks[0]
    robot = FakeRobot(fault_at=picked.phases[-1].end + 0.1)
    report = clear_table(trial_cell(robot, [box()], []))
    assert report.picks[0].outcome == "placed"
    assert report.stop_reason == "the arm has lost its power"


def test_lost_driver_of_a_robot_class_ends_in_a_fault(monkeypatch):
    robot = FakeRobot()

    def lost(velocity, command=None):
        raise TimeoutError("no answer")

    monkeypatch.setattr(robot, "step", lost)
    report, _ = cleared(robot, [box()])

    assert report.stop_reason == "the robot's driver failed: no answer"


def test_arm_that_moves_against_its_commands_is_stopped_at_once(monkeypatch):
    robot = FakeRobot()
    step, start = robot.step, robot.q.copy()
    monkeypatch.setattr(robot, "step", lambda velocity, command=None: step(-velocity, command))

    report, _ = cleared(robot, [box()])

    assert "moves against its command" in report.stop_reason
    assert np.abs(robot.q - start).max() < 0.3


def test_pick_with_faulty_robot_reports_fault():
    robot = FakeRobot()
    cell = trial_cell(robot, [box()])
    choice = select_grasp(cell, cell.perceive(robot.capture()), FailedGrasps()).grasp
    assert choice is not None
    robot.fault_at = 0.0
    cell.reading = robot.read()
    report = pick_object(cell, choice)
    assert report.outcome == "fault"
    assert report.forces.shape == (0, len(HAND.fingers) + 1)


def test_hard_contact_far_from_object_stops_motion():
    report = clear_table(trial_cell(ThumbContactRobot(), [box()]), options=ClearOptions(failures=1))
    assert report.picks[0].outcome == "stuck"
    assert "thumb" in report.picks[0].reason
    assert "touched something that was not perceived" in report.picks[0].reason


def test_full_tray_is_filled_in_next_layer():
    robot = FakeRobot()
    lowest = [np.inf]

    def on_cycle(cycle):
        if cycle.phase == "pre-grasp" and np.isfinite(lowest[-1]):
            lowest.append(np.inf)
        if cycle.phase == "place":
            lowest[-1] = min(lowest[-1], robot.palm_height(cycle.reading.q))

    narrow = replace(TRAY, size=(0.12, 0.12))
    report, cell = cleared(robot, [box(-0.1), box(0.05)], on_cycle, narrow)
    assert report.placed == 2
    tops = [item.top for item in cell.tray_content]
    assert tops == pytest.approx([HEIGHT, 2 * HEIGHT], abs=0.002)
    assert len(lowest) == 2
    assert lowest[1] - lowest[0] == pytest.approx(HEIGHT, abs=0.02)


def test_spent_time_counts_as_planning_time():
    cell = trial_cell(FakeRobot(), [box()])
    scene = cell.perceive(cell.robot.capture())
    assert select_grasp(cell, scene, FailedGrasps(), spent_ms=500.0).plan_ms > 500.0
    memory = FailedGrasps()
    plan = plan_prototypes(scene.objects[0], scene.support)[0]
    for _ in range(2):
        memory.add(scene, scene.objects[0], plan)
    selection = select_grasp(cell, scene, memory, spent_ms=500.0)
    assert selection.grasp is None
    assert selection.plan_ms > 500.0


@pytest.mark.parametrize("frozen", [True, False])
def test_frozen_camera_is_named_beside_the_hand(frozen):
    robot = FakeRobot()
    taken, image = [0], robot.capture()

    def capture():
        taken[0] += 1
        noise = np.float32(0.0 if frozen else 1e-4 * taken[0])
        return replace(image, depth=image.depth + noise)

    robot.capture = capture
    report = clear_table(trial_cell(robot, [box()]), options=ClearOptions(picks=1))

    assert report.picks[0].outcome == "empty_close"
    assert "the object is still at its place" in report.picks[0].reason
    assert report.picks[0].reason.count("identical to the one before the pick") == frozen


def test_a_chosen_object_is_picked_while_the_others_stay_obstacles():
    cell = trial_cell(FakeRobot(), [box(-0.1), box(0.05)])
    scene = cell.perceive(cell.robot.capture())
    best = select_grasp(cell, scene).grasp
    assert best is not None
    other = next(item for item in scene.objects if item.label != best.target.label)

    chosen = select_grasp(cell, scene, labels=[other.label]).grasp

    assert chosen is not None
    assert chosen.target is other
    world = PickState(chosen).world(cell, "obstacle")
    assert any(one.name.endswith(str(best.target.label)) for one in world.obstacles)
    with pytest.raises(InputError, match=r"no object 7; its objects are 1 \(box\), 2 \(box\)"):
        select_grasp(cell, scene, labels=[1, 7])


def test_remaining_distance_ignores_angles():
    tasks = (Position(np.zeros(3)), Orientation(np.eye(3)))
    assert remaining_distance(tasks, (0.003, 0.2)) == 0.003
    assert remaining_distance(tasks[1:], (0.2,)) == 0.0


@pytest.mark.parametrize(
    "wrong", [{"speed": -1}, {"carry_speed": 0.0}, {"speed": 0.0}, {"max_attempts": 0}]
)
def test_options_that_reverse_or_stop_motion_are_rejected(wrong):
    (name,) = wrong
    with pytest.raises(InputError, match=name):
        PickOptions(**wrong)


def test_objects_with_warnings_come_later():
    robot = FakeRobot()
    cell = trial_cell(robot, [box(0.05), box(-0.1)])
    scene = cell.perceive(robot.capture())
    first = select_grasp(cell, scene).grasp
    assert first is not None
    warning = SceneWarning("cut_by_image", "cut", first.target.label)
    warned = replace(scene, segmentation=replace(scene.segmentation, warnings=(warning,)))
    second = select_grasp(cell, warned, FailedGrasps()).grasp
    assert second is not None
    assert second.target.label != first.target.label


def test_fingers_get_no_grasp_in_a_scene_with_a_doubtful_support():
    robot = FakeRobot()
    cell = trial_cell(robot, [box()])
    scene = cell.perceive(robot.capture())
    warning = SceneWarning("support_doubtful", "two supports", None)
    warned = replace(scene, segmentation=replace(scene.segmentation, warnings=(warning,)))
    selection = select_grasp(cell, warned)
    assert selection.grasp is None
    assert selection.skipped == ("object 1: the scene is not reliable: two supports",)


def test_grasps_that_will_probably_not_hold_come_last(monkeypatch):
    robot = FakeRobot()
    cell = trial_cell(robot, [box(0.05), box(-0.1)])
    scene = cell.perceive(robot.capture())
    first = select_grasp(cell, scene).grasp
    assert first is not None
    asked = []

    def hold_of_others(plan, solid, hand):
        asked.append(plan)
        return float(plan.name != first.plan.name)

    monkeypatch.setattr(grasp_selection, "plan_hold", hold_of_others)
    other = select_grasp(cell, scene).grasp
    assert other is not None
    assert other.plan.name != first.plan.name
    assert len(asked) > 1
    # Without a better grasp, the order of the scores remains. Opposed fingers have another score.
    monkeypatch.setattr(grasp_selection, "plan_hold", lambda *_: 0.0)
    monkeypatch.setattr(grasp_selection, "_opposed_candidates", lambda *_: [])
    same = select_grasp(cell, scene).grasp
    assert same is not None
    assert (same.target.label, same.plan.name) == (first.target.label, first.plan.name)


def test_fingers_are_planned_as_jaws_where_no_usual_grasp_is_reached(monkeypatch):
    cell = trial_cell(FakeRobot(), [box()])
    scene = cell.perceive(cell.robot.capture())
    reach = grasp_selection.check_reachability

    def reach_of_jaws(cell, state, worlds):
        usual = state.plan.tip_depth is not None
        return "too far" if usual else reach(cell, state, worlds)

    monkeypatch.setattr(grasp_selection, "check_reachability", reach_of_jaws)
    grasp = select_grasp(cell, scene).grasp
    assert grasp is not None
    assert grasp.plan.gripped_width == pytest.approx(0.03, abs=0.002)


def test_object_without_solid_is_planned_on_its_readings():
    cell = trial_cell(FakeRobot(), [box()])
    scene = cell.perceive(cell.robot.capture())
    bent = replace(scene.objects[0], fit=SuperquadricFit.rejected("bent"))
    grasp = select_grasp(cell, replace(scene, objects=(bent,)), FailedGrasps()).grasp
    assert grasp is not None
    assert grasp.plan.gripped_width == pytest.approx(0.03, abs=0.005)


def test_object_that_slipped_is_gripped_with_full_force_where_it_fell():
    robot = FakeRobot()
    cell = Cell(robot, lambda _frame: ground_truth_scene([box()], VIEW), TRAY)
    scene = cell.perceive(robot.capture())
    before = ground_truth_scene([box(0.1)], VIEW)
    memory = FailedGrasps()
    plan = plan_prototypes(before.objects[0], before.support)[-1]
    memory.add(before, before.objects[0], plan, slipped=False)
    soft = select_grasp(cell, scene, memory).grasp
    memory = FailedGrasps()
    memory.add(before, before.objects[0], plan, slipped=True)
    firm = select_grasp(cell, scene, memory).grasp

    assert soft is not None
    assert firm is not None
    assert (soft.firm, firm.firm) == (False, True)


def test_more_grasps_of_jaws_are_tried_where_none_of_the_best_is_reached(monkeypatch):
    """The best three of a box beside the arm's base had one approach."""
    cell = trial_cell(FakeRobot(), [box()])
    scene, jaws = cell.perceive(cell.robot.capture()), JawOptions(depth_error=0.005)
    robot: Any = SimpleNamespace(hand=load_hand("panda"))
    options = PickOptions(jaws=jaws)
    arm: Any = SimpleNamespace(robot=robot, options=options, enter=lambda _: None)
    seen: list[tuple[float, ...]] = []

    def first_three_are_out_of_reach(_cell, state, _worlds):
        position = tuple(state.plan.tasks[0].point.round(6))
        if position not in seen:
            seen.append(position)
        return "out of reach" if len(seen) <= jaws.per_object else ""

    monkeypatch.setattr(grasp_selection, "check_reachability", first_three_are_out_of_reach)
    assert select_grasp(arm, scene).grasp is not None
    assert len(seen) == jaws.per_object + 1
