"""The planned approach: paths are followed within speed limits, and failures are reported."""

import time
from dataclasses import replace
from typing import cast

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.motion.reach_methods import ControllerMethod, reaching_world
from eyehand.apps.motion.reach_outcome import ReachOptions, run_reach
from eyehand.control import (
    Box,
    CollisionWorld,
    JointPath,
    Obstacle,
    PlannedApproach,
    PlannerOptions,
    RobotModel,
    joint_planner,
    plan,
    planned_approach,
    search,
)
from eyehand.control.configuration_space import clearance_at
from eyehand.control.control_step import ControlStep
from eyehand.control.joint_path import SPEED_FRACTION, resample_path
from eyehand.control.joint_planner import find_path, make_space, solutions
from eyehand.control.options import ControlOptions
from eyehand.control.planner import _Search
from eyehand.control.tasks import AxisAlignment, PointOnPlane, Position, Posture
from eyehand.data_synth import LBR_ARM
from eyehand.data_synth.scenes import make_reaching_scene


class _StuckController:
    """A controller that is stuck from the start."""

    def __init__(self, world, tasks, options):
        self.world, self.robot, self.tasks = world, world.robot, tasks
        self.commit(np.zeros(7))
        self.stuck_step = ControlStep(
            np.zeros(7), "stuck", "helpless", "approach", (1.0,), 1.0, (0.0,), ()
        )

    def step(self, q) -> ControlStep:
        return self.stuck_step

    def restart(self) -> None:
        pass

    def stop(self, q) -> ControlStep:
        self.commit(np.zeros(7))
        return replace(self.stuck_step, velocity=np.zeros(7), status="moving")

    def commit(self, velocity) -> None:
        self.velocity = velocity
        self.last_command = np.array([velocity, np.zeros(7)])


class _DriftingController(_StuckController):
    """A controller that is stuck and still moves."""

    def step(self, q) -> ControlStep:
        self.commit(np.full(7, 0.1))
        return replace(self.stuck_step, velocity=self.velocity)


@pytest.fixture
def only_stuck(monkeypatch):
    """Leave out the prediction and the search in the joint space."""
    monkeypatch.setattr(search, "find_path", lambda *_: None)


def test_resampled_path_keeps_speed_limits_and_corners():
    robot = reaching_world(()).robot
    corners = np.array([robot.home, robot.home + 0.3, robot.home + np.eye(7)[6]])
    track = resample_path(corners, robot, 0.005)
    np.testing.assert_allclose(track[[0, -1]], corners[[0, -1]])
    # The corner is not cut: one configuration lies within half a step of it.
    assert np.abs(track - corners[1]).max(axis=1).min() < 0.01
    speed = np.abs(np.diff(track, axis=0)) / 0.005
    assert np.all(speed <= SPEED_FRACTION * robot.speed + 1e-9)
    tool = np.array([robot.at(q).position for q in track])
    assert np.linalg.norm(np.diff(tool, axis=0), axis=1).max() < 1.1 * 0.25 * 0.005
    np.testing.assert_allclose(resample_path(corners[:1], robot, 0.005), corners[:1])


def test_found_path_is_followed_to_goal(monkeypatch, only_stuck):
    scene = make_reaching_scene(9, boxes=0)
    world = reaching_world(scene.obstacles)
    steps = int(np.ceil(np.abs(scene.witness - scene.start).max() / 0.01))
    fractions = np.linspace(0.0, 1.0, steps)[:, None]
    postures = scene.start + fractions * (scene.witness - scene.start)
    path = JointPath(True, postures, 0.02, "", 1, 2, 0.0)
    monkeypatch.setattr(search, "plan", lambda *_: path)
    monkeypatch.setattr(planned_approach, "ApproachController", _StuckController)
    controller = PlannedApproach(world, (Position(scene.goal),))
    method = ControllerMethod(controller)
    result = run_reach(scene, method, ReachOptions(time_limit=60.0))
    # The tasks take over before the end of the path, and this controller stops there.
    assert result.final_error < 0.08
    assert method.paths[0] == path


@pytest.mark.parametrize(("passes", "arrives"), [(0.03, True), (0.0, False)])
def test_robot_held_up_on_path_heads_for_nearer_point_or_leaves_it(
    monkeypatch, only_stuck, passes, arrives
):
    """Let the safety level pass only motions to points nearer than ``passes`` rad."""
    scene = make_reaching_scene(9, boxes=0)
    goal = scene.start + 0.4
    path = JointPath(True, np.linspace(scene.start, goal, 41), 0.02, "", 1, 2, 0.0)
    monkeypatch.setattr(search, "plan", lambda *_: path)
    monkeypatch.setattr(planned_approach, "ApproachController", _StuckController)
    controller = PlannedApproach(reaching_world(()), (Position(scene.goal),), searches=1)
    ahead, move = [], controller._path_cycle.at

    def held_up(q, last):
        motion = move(q, last)
        ahead.append(np.abs(controller._path_cycle._goal - q).max())
        free = ahead[-1] < passes or len(ahead) < 20
        return motion if free else motion._replace(command=0.01 * motion.command)

    monkeypatch.setattr(controller._path_cycle, "at", held_up)
    q = scene.start.copy()
    for _ in range(3000):
        step = controller.step(q)
        if step.status == "stuck":
            break
        q = q + controller.options.dt * step.velocity
    else:
        pytest.fail("the motion has no end")
    # A path of 0.4 rad ends 0.1 rad early, where the tasks take over.
    assert (np.abs(q - goal).max() < 0.2) == arrives
    if not arrives:
        assert len(ahead) * controller.options.dt < 1.5, "a creeping robot leaves its path"


def test_reach_without_path_ends_stuck_with_reason(monkeypatch, only_stuck):
    scene = make_reaching_scene(9, boxes=0)
    monkeypatch.setattr(planned_approach, "ApproachController", _StuckController)
    none = JointPath(False, scene.start[None], 0.02, "walled off", 1, 1, 0.0)
    monkeypatch.setattr(search, "plan", lambda *_: none)
    world, task = reaching_world(scene.obstacles), Position(scene.goal)
    method = ControllerMethod(PlannedApproach(world, (task,)))
    result = run_reach(scene, method)
    assert result.status == "stuck"
    assert "walled off" in method.reason


def test_plan_around_box_is_collision_free_and_reaches_goal():
    scene = make_reaching_scene(16)
    world, tasks = reaching_world(scene.obstacles), (Position(scene.goal),)
    path = plan(world, tasks, scene.start, ControlOptions(), PlannerOptions())
    assert path
    np.testing.assert_array_equal(path.configurations[0], scene.start)
    assert tasks[0].at(world.robot.at(path.configurations[-1])).unmet < 1e-3
    clear = [world.proximity(q).distance.min(initial=1.0) for q in path.configurations]
    assert min(clear) > 0.008


def test_plan_is_repeatable_with_seed():
    scene = make_reaching_scene(13)
    world, tasks = reaching_world(scene.obstacles), (Position(scene.goal),)
    options = PlannerOptions(rollouts=12, seed=3)
    first, second = (plan(world, tasks, scene.start, ControlOptions(), options) for _ in range(2))
    # One attempt to reach the goal may follow the last counted roll-out.
    assert first.rollouts == second.rollouts <= 13
    np.testing.assert_array_equal(first.configurations, second.configurations)


def test_budget_of_zero_roll_outs_fails_with_reason():
    scene = make_reaching_scene(13)
    world, tasks = reaching_world(scene.obstacles), (Position(scene.goal),)
    path = plan(world, tasks, scene.start, ControlOptions(), PlannerOptions(rollouts=0))
    assert not path
    assert path.rollouts == 0
    assert "no roll-outs" in path.reason


def test_goal_inside_obstacle_has_no_path_and_a_reason():
    scene = make_reaching_scene(3)
    world = reaching_world(scene.obstacles)
    goal = scene.obstacles[0].T_world_shape.translation
    path = plan(world, (Position(goal),), scene.start, ControlOptions(), PlannerOptions(rollouts=8))
    assert not path
    assert path.reason
    assert np.all(np.isfinite(path.configurations))


def test_robot_stops_before_each_search(monkeypatch, only_stuck):
    searched = []

    def search_path(world, tasks, q, options, planner):
        searched.append(planner.seed)
        return JointPath(False, q[None], 0.02, "walled off", 1, 1, 0.0)

    monkeypatch.setattr(search, "plan", search_path)
    monkeypatch.setattr(planned_approach, "ApproachController", _DriftingController)
    scene = make_reaching_scene(9, boxes=0)
    controller = PlannedApproach(reaching_world(()), (Position(scene.goal),), searches=2)
    cycles = [controller.step(scene.start) for _ in range(7)]
    # A cycle that is stuck, one that brakes, the search, the same again, and the last word.
    statuses = ["moving", "moving", "stuck", "moving", "moving", "stuck", "stuck"]
    assert [cycle.status for cycle in cycles] == statuses
    assert searched == [0, 1]
    moving = [True, False, False, True, False, False, True]
    assert [bool(np.any(cycle.velocity)) for cycle in cycles] == moving


def test_reached_goal_resets_number_of_searches(monkeypatch, only_stuck):
    monkeypatch.setattr(planned_approach, "ApproachController", _DriftingController)
    scene = make_reaching_scene(9, boxes=0)
    none = JointPath(False, scene.start[None], 0.02, "walled off", 1, 1, 0.0)
    monkeypatch.setattr(search, "plan", lambda *_: none)
    approach = PlannedApproach(reaching_world(()), (Position(scene.goal),), searches=1)
    for _ in range(4):
        approach.step(scene.start)
    assert len(approach.paths) == 1
    controller = cast(_DriftingController, approach.controller)
    stuck = controller.stuck_step
    controller.stuck_step = replace(stuck, status="reached")
    assert approach.step(scene.start).status == "reached"
    controller.stuck_step = stuck
    for _ in range(4):
        approach.step(scene.start)
    assert len(approach.paths) == 2


def test_search_bounds_stay_small_in_singular_configuration():
    arm = """<mujoco><worldbody>
    <body><joint axis="0 0 1" name="a" range="-170 170"/><geom size=".05" pos="0 0 .1"/>
    <body pos="0 0 .3"><joint axis="0 1 0" name="b" range="-170 170"/><geom size=".05"/>
    <body pos="0 0 .4"><joint axis="0 1 0" name="c" range="-170 170"/><geom size=".03"/>
    <site name="tip" pos="0 0 .3"/></body></body></body></worldbody></mujoco>"""
    world = CollisionWorld(RobotModel.load(arm, "tip"))
    tasks = (PointOnPlane(np.array([0.0, 0.0, 1.0]), 0.5),)
    search = _Search(world, tasks, ControlOptions(), PlannerOptions())
    search.add(-1, np.zeros((0, 3)), np.array([0.0, 1e-7, 0.0]))
    low, high = search.bounds()
    assert np.all(high - low < 8.0)


def test_clearance_kernel_equals_proximity():
    scene = make_reaching_scene(16)
    world = reaching_world(scene.obstacles)
    space = make_space(world)
    rng = np.random.default_rng(2)
    for q in rng.uniform(world.robot.lower, world.robot.upper, (50, 7)):
        expected = min(world.proximity(q).distance.min(initial=1.0), 0.05)
        assert clearance_at(q, space, 0.05) == pytest.approx(expected, abs=1e-12)


def test_solutions_reach_tasks_within_joint_limits():
    scene = make_reaching_scene(16)
    world = reaching_world(scene.obstacles)
    axis = AxisAlignment(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0]))
    tasks = (Position(np.array([0.45, 0.1, 0.4])), axis)
    found = solutions(world, tasks, scene.start)
    assert found is not None
    good = found.errors < 1e-4
    assert np.count_nonzero(good) > 5
    for q, error in zip(found.configurations, found.errors, strict=True):
        assert np.all(world.robot.lower <= q)
        assert np.all(q <= world.robot.upper)
        unmet = max(task.at(world.robot.at(q)).unmet for task in tasks)
        assert unmet == pytest.approx(error, abs=1e-9)


@pytest.mark.parametrize("seed", [2, 13, 16])
def test_path_of_two_trees_is_clear_and_repeatable(seed):
    scene = make_reaching_scene(seed)
    world, tasks = reaching_world(scene.obstacles), (Position(scene.goal),)
    first, second = (find_path(world, tasks, scene.start, ControlOptions()) for _ in range(2))
    assert first is not None
    assert second is not None
    np.testing.assert_array_equal(first.configurations, second.configurations)
    np.testing.assert_array_equal(first.configurations[0], scene.start)
    assert tasks[0].at(world.robot.at(first.configurations[-1])).unmet < 5e-4
    track = resample_path(first.configurations, world.robot, 0.02)
    clear = [world.proximity(q).distance.min(initial=1.0) for q in track]
    assert min(clear) > 0.008
    # The track is a little slower than the estimate of the kernel at coarse steps.
    assert 0.02 * len(track) == pytest.approx(first.seconds, rel=0.1)


def test_reach_that_was_stuck_is_planned_in_the_first_cycle():
    scene = make_reaching_scene(2)
    controller = PlannedApproach(reaching_world(scene.obstacles), (Position(scene.goal),))
    method = ControllerMethod(controller)
    result = run_reach(scene, method)
    assert result.success
    assert result.seconds < 4.0
    assert len(method.paths) == 1
    assert result.min_clearance > 0.0099
    assert result.peak_acceleration <= 1.0 + 1e-6
    assert result.peak_jerk <= 1.0 + 1e-6


@pytest.mark.parametrize("distance", [1.05, 1.5, 3.0])
def test_goal_out_of_reach_is_named_in_the_first_cycle(distance):
    world = reaching_world(())
    goal = np.array([0.0, 0.0, 0.34]) + distance * np.array([0.6, 0.0, 0.8])
    controller = PlannedApproach(world, (Position(goal),))
    cycle = controller.step(world.robot.home)
    assert cycle.status == "stuck"
    assert "unreachable: at the nearest configuration position" in cycle.reason
    assert not np.any(cycle.velocity)
    # Reachable with another task: the next goal is planned as usual.
    near = PlannedApproach(world, (Position(np.array([0.4, 0.2, 0.5])),))
    assert near.step(world.robot.home).status == "moving"


@pytest.mark.parametrize("seed", [9, 62])
def test_path_by_way_of_another_place_is_found_where_the_trees_do_not_meet(seed, monkeypatch):
    monkeypatch.setattr(joint_planner, "LAST_ITERATIONS", 0)
    scene = make_reaching_scene(seed)
    world, tasks = reaching_world(scene.obstacles), (Position(scene.goal),)
    direct = find_path(world, tasks, scene.start, ControlOptions())
    assert direct is not None
    assert direct.reason == "the trees did not meet"
    path = plan(world, tasks, scene.start, ControlOptions(), PlannerOptions(rollouts=8))
    assert path
    np.testing.assert_array_equal(path.configurations[0], scene.start)
    assert tasks[0].at(world.robot.at(path.configurations[-1])).unmet < 1e-3
    steps = np.abs(np.diff(path.configurations, axis=0)).max(axis=1)
    assert steps.max() < 1.5 * world.robot.speed.max() * path.dt
    clear = [world.proximity(q).distance.min(initial=1.0) for q in path.configurations]
    assert min(clear) > 0.008


def test_search_in_the_background_takes_the_same_path_and_leaves_the_world_alone():
    scene = make_reaching_scene(2)
    steps, paths = [], []
    for background in (False, True):
        world = reaching_world(scene.obstacles)
        before = world.proximity(scene.start).distance
        controller = PlannedApproach(world, (Position(scene.goal),), background=background)
        controller.warm_up()
        deadline = time.monotonic() + 60.0
        step = controller.step(scene.start)
        phases = [step.phase]
        while step.phase == "plan":
            step = controller.step(scene.start)
            np.testing.assert_array_equal(world.proximity(scene.start).distance, before)
            phases.append(step.phase)
            assert step.status == "moving"
            assert time.monotonic() < deadline
        steps.append(step.velocity)
        paths.append(controller.paths[0].configurations)
        assert ("plan" in phases) == background
        assert phases[-1] == "path"
    np.testing.assert_array_equal(steps[0], steps[1])
    np.testing.assert_array_equal(paths[0], paths[1])


def test_restart_forgets_a_search_in_the_background():
    world = reaching_world(())
    far = PlannedApproach(world, (Position(np.array([3.0, 0.0, 0.3])),), background=True)
    far.step(world.robot.home)
    far.restart()
    assert far.paths == []
    statuses = set()
    deadline = time.monotonic() + 60.0
    while "stuck" not in statuses and time.monotonic() < deadline:
        statuses.add(far.step(world.robot.home).status)
    assert statuses == {"moving", "stuck"}


def test_goal_inside_an_obstacle_ends_as_stuck_and_names_it():
    robot = RobotModel.load(LBR_ARM, "tool")
    pose = RigidTransform.from_translation([0.4, 0.3, 0.2])
    block = Obstacle("block", Box(half_extents=np.array([0.1, 0.1, 0.2])), pose)
    world = CollisionWorld(robot, [block])
    approach = PlannedApproach(world, [Position(pose.translation)])
    q, cycles = robot.home, 1
    # It brakes before it searches; only the end has another status than "moving".
    while (step := approach.step(q)).status == "moving" and cycles < 2000:
        q = q + approach.options.dt * step.velocity
        cycles += 1
    assert step.status == "stuck"
    assert "block" in step.reason


@pytest.mark.parametrize(("gap", "margin"), [(0.008, 0.01), (0.0055, 0.006)])
def test_parts_near_each_other_at_home_reach_home_and_never_overlap(gap, margin):
    arm = f"""<mujoco><worldbody><body><joint name="turn" axis="0 0 1" range="-120 120"/>
    <geom name="rest" type="box" size=".01 .01 .02" pos=".3 0 -.02"/>
    <body><joint name="bend" axis="0 1 0" range="-120 120"/><inertial pos="0 0 0" mass="1"
    diaginertia="1 1 1"/><body pos=".3 0 0"><joint name="roll" range="-120 120"/>
    <geom name="tip" size=".01" pos="0 0 {0.01 + gap}"/><site name="tool"/></body></body></body>
    </worldbody></mujoco>"""
    robot = RobotModel.load(arm, "tool", home=[0.0, 0.0, 0.0])
    world = CollisionWorld(robot)
    options = ControlOptions(margin=margin)
    q = np.array([0.2, -0.6, 0.0])
    for bend, status in ((0.0, "reached"), (0.1, "stuck")):
        goal = Posture(np.array([0.0, bend, 0.0]), speed=1.0)
        motion = PlannedApproach(world, (goal,), options)
        step = motion.step(q)
        while step.status == "moving":
            q = q + options.dt * step.velocity
            step = motion.step(q)
            assert gap - 0.3 * np.sin(q[1]) > 0.4 * margin
        assert step.status == status
