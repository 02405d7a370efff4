"""The approach: what ends a motion, what counts as progress, and what is said when it is stuck."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control.approach import ApproachController, ControlStep, retreat_configurations
from eyehand.control.collision_world import CollisionWorld
from eyehand.control.cycle import ControlCycle
from eyehand.control.options import ControlOptions
from eyehand.control.robot_model import RobotModel
from eyehand.control.shapes import Obstacle, Sphere
from eyehand.control.tasks import JointCentring, PointOnPlane, Position, Posture
from eyehand.data_synth import LBR_ARM
from eyehand.errors import InputError

GOAL = np.array([0.45, 0.25, 0.5])


@pytest.fixture(scope="module")
def world() -> CollisionWorld:
    return CollisionWorld(RobotModel.load(LBR_ARM, "tool"))


def _run(controller: ApproachController, seconds: float = 60.0) -> tuple[ControlStep, float]:
    q = controller.robot.home
    dt = controller.options.dt
    for number in range(round(seconds / dt)):
        cycle = controller.step(q)
        if cycle.status != "moving":
            return cycle, dt * number
        q = q + dt * cycle.velocity
    pytest.fail(f"still moving after {seconds} s")


@pytest.mark.parametrize("compiled", [True, False])
def test_an_endless_task_does_not_keep_a_motion_from_its_end(
    world: CollisionWorld, compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = ControlOptions()
    if not compiled:
        monkeypatch.setattr(ControlCycle, "compiled", lambda *_: None)
    # Off the middle of the ranges the error of centring grows on the way.
    tasks = [Position(GOAL), JointCentring(reference=world.robot.home)]
    cycle, _ = _run(ApproachController(world, tasks, options))
    assert cycle.status == "reached"
    assert cycle.errors[0] <= options.tolerance
    assert len(cycle.errors) == 2
    assert cycle.errors[1] > options.tolerance


def test_an_endless_task_ends_the_motion_when_it_is_alone(world: CollisionWorld) -> None:
    reference = world.robot.home + 0.2
    cycle, seconds = _run(ApproachController(world, [JointCentring(reference=reference)]))
    assert cycle.status == "reached"
    assert seconds > 1.0


def test_a_lower_task_may_lose_for_a_higher_one(world: CollisionWorld) -> None:
    far = PointOnPlane(np.array([0.0, 0.0, 1.0]), 1.1)
    posture = Posture(world.robot.home)
    controller = ApproachController(world, [far, posture])
    cycle, _ = _run(controller)
    # The posture is lost by rad for what the plane gains in m; that is progress all the same.
    assert cycle.errors[0] <= controller.options.tolerance
    assert cycle.errors[1] > 0.1
    assert cycle.status == "stuck"
    assert cycle.reason.endswith("off: the tasks above leave no way")
    assert cycle.reason.startswith("posture")


def _stuck_reason(ball: list[float], goal: list[float], options: ControlOptions) -> str:
    obstacle = Obstacle("ball", Sphere(0.05), RigidTransform.from_translation(ball))
    world = CollisionWorld(RobotModel.load(LBR_ARM, "tool"), [obstacle])
    cycle, _ = _run(ApproachController(world, [Position(np.array(goal))], options))
    assert cycle.clearance < options.influence
    assert cycle.status == "stuck"
    return cycle.reason


def test_a_goal_out_of_reach_is_said_so_beside_what_repels() -> None:
    reason = _stuck_reason([0.5, 0.12, 0.25], [2.0, 0.3, 0.4], ControlOptions(retreats=0))
    assert reason.endswith("out of reach from here")


def test_repulsion_that_holds_off_the_goal_is_said_so() -> None:
    options = ControlOptions(beta=5.0, retreats=0)
    reason = _stuck_reason([0.56, 0.25, 0.5], GOAL.tolist(), options)
    assert reason.endswith("repulsion and goal are in balance")


def test_tasks_stay_what_they_are(world: CollisionWorld) -> None:
    controller = ApproachController(world, [Position(GOAL)])
    with pytest.raises(AttributeError):
        controller.tasks = ()  # pyright: ignore[reportAttributeAccessIssue] -- that it is refused


@pytest.mark.parametrize("tasks", [[], Position(GOAL), [GOAL]])
def test_what_is_no_list_of_tasks_is_refused(world: CollisionWorld, tasks: list) -> None:
    with pytest.raises(InputError, match="task"):
        ApproachController(world, tasks)


def test_joints_without_limits_have_a_retreat_and_a_cycle_in_steps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    arm = """<mujoco><worldbody>
    <body><joint axis="0 0 1" name="turn"/><geom size=".05" pos=".3 0 0"/>
    <body pos=".3 0 0"><joint axis="0 0 1" name="bend" range="-120 120"/>
    <geom size=".05" pos=".3 0 0"/><site name="tip" pos=".3 0 0"/></body></body></worldbody>
    </mujoco>"""
    robot = RobotModel.load(arm, "tip", home=[0.4, 0.5])
    controller = ApproachController(
        CollisionWorld(robot),
        [PointOnPlane(np.array([1.0, 0.0, 0.0]), 0.2)],
    )
    monkeypatch.setattr(ControlCycle, "compiled", lambda *_: None)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_allclose(retreat_configurations(robot)[1], [-0.4, -0.5])
        assert np.all(np.isfinite(controller.step(robot.home).velocity))
        assert JointCentring().at(robot.at(robot.home)).error[0] == 0.0
