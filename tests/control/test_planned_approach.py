"""The planned approach: paths are followed within speed limits, and failures are reported."""

from dataclasses import replace
from typing import cast

import numpy as np

from eyehand.apps.motion.reach_methods import ControllerMethod, reaching_world
from eyehand.apps.motion.reach_outcome import ReachOptions, run_reach
from eyehand.control import (
    CollisionWorld,
    JointPath,
    PlannedApproach,
    PlannerOptions,
    RobotModel,
    plan,
    planned_approach,
)
from eyehand.control.approach import ControlStep
from eyehand.control.options import ControlOptions
from eyehand.control.planned_approach import resample_path
from eyehand.control.planner import _Search
from eyehand.control.tasks import PointOnPlane, Position
from eyehand.data_synth.scenes import make_reaching_scene


class _StuckController:
    """A controller that is stuck from the start."""

    def __init__(self, world, tasks, options):
        self.world, self.robot, self.tasks = world, world.robot, tasks
        self.stuck_step = ControlStep(
            np.zeros(7), "stuck", "helpless", "approach", (1.0,), 1.0, (0.0,), ()
        )

    def step(self, q) -> ControlStep:
        return self.stuck_step

    def restart(self) -> None:
        pass


class _DriftingController(_StuckController):
    """A controller that is stuck and still moves."""

    def step(self, q) -> ControlStep:
        return replace(self.stuck_step, velocity=np.full(7, 0.1))


def test_resampled_path_keeps_speed_limits_and_corners():
    robot = reaching_world(()).robot
    corners = np.array([robot.home, robot.home + 0.3, robot.home + np.eye(7)[6]])
    track = resample_path(corners, robot, 0.005)
    np.testing.assert_allclose(track[[0, -1]], corners[[0, -1]])
    # The corner is not cut: one configuration lies within half a step of it.
    assert np.abs(track - corners[1]).max(axis=1).min() < 0.01
    speed = np.abs(np.diff(track, axis=0)) / 0.005
    assert np.all(speed <= 0.5 * robot.speed + 1e-9)
    tool = np.array([robot.at(q).position for q in track])
    assert np.linalg.norm(np.diff(tool, axis=0), axis=1).max() < 1.1 * 0.25 * 0.005
    np.testing.assert_allclose(resample_path(corners[:1], robot, 0.005), corners[:1])


def test_found_path_is_followed_to_goal(monkeypatch):
    scene = make_reaching_scene(9, boxes=0)
    world = reaching_world(scene.obstacles)
    steps = int(np.ceil(np.abs(scene.witness - scene.start).max() / 0.01))
    fractions = np.linspace(0.0, 1.0, steps)[:, None]
    postures = scene.start + fractions * (scene.witness - scene.start)
    path = JointPath(True, postures, 0.02, "", 1, 2, 0.0)
    monkeypatch.setattr(planned_approach, "plan", lambda *_: path)
    monkeypatch.setattr(planned_approach, "ApproachController", _StuckController)
    controller = PlannedApproach(world, (Position(scene.goal),))
    method = ControllerMethod(controller)
    result = run_reach(scene, method, ReachOptions(time_limit=60.0))
    assert result.status == "reached"
    assert method.paths == (path,)


def test_reach_without_path_ends_stuck_with_reason(monkeypatch):
    scene = make_reaching_scene(9, boxes=0)
    monkeypatch.setattr(planned_approach, "ApproachController", _StuckController)
    none = JointPath(False, scene.start[None], 0.02, "walled off", 1, 1, 0.0)
    monkeypatch.setattr(planned_approach, "plan", lambda *_: none)
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


def test_robot_stops_before_each_search(monkeypatch):
    searched = []

    def search(world, tasks, q, options, planner):
        searched.append(planner.seed)
        return JointPath(False, q[None], 0.02, "walled off", 1, 1, 0.0)

    monkeypatch.setattr(planned_approach, "plan", search)
    monkeypatch.setattr(planned_approach, "ApproachController", _DriftingController)
    scene = make_reaching_scene(9, boxes=0)
    controller = PlannedApproach(reaching_world(()), (Position(scene.goal),), searches=2)
    cycles = [controller.step(scene.start) for _ in range(5)]
    assert [cycle.status for cycle in cycles] == ["moving", "stuck", "moving", "stuck", "stuck"]
    assert searched == [0, 1]
    # The robot stands still until the last search. Then the controller's own cycle is used.
    assert [bool(np.any(cycle.velocity)) for cycle in cycles] == [False] * 4 + [True]


def test_reached_goal_resets_number_of_searches(monkeypatch):
    monkeypatch.setattr(planned_approach, "ApproachController", _DriftingController)
    scene = make_reaching_scene(9, boxes=0)
    none = JointPath(False, scene.start[None], 0.02, "walled off", 1, 1, 0.0)
    monkeypatch.setattr(planned_approach, "plan", lambda *_: none)
    approach = PlannedApproach(reaching_world(()), (Position(scene.goal),), searches=1)
    for _ in range(3):
        approach.step(scene.start)
    assert len(approach.paths) == 1
    controller = cast(_DriftingController, approach.controller)
    stuck = controller.stuck_step
    controller.stuck_step = replace(stuck, status="reached")
    assert approach.step(scene.start).status == "reached"
    controller.stuck_step = stuck
    for _ in range(3):
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
