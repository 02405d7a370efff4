"""The approach controller: end of a motion, progress, and the reason of a stuck motion."""

from __future__ import annotations

import pickle
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

import eyehand.control.cycle as cycle_module
from eyehand.control.approach import ApproachController
from eyehand.control.collision_world import CollisionWorld
from eyehand.control.control_step import ControlStep
from eyehand.control.cycle import ControlCycle
from eyehand.control.options import ControlOptions
from eyehand.control.retreat import retreat_configurations
from eyehand.control.robot_model import RobotModel
from eyehand.control.safety import blocking_names
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
def test_endless_task_does_not_prevent_convergence(
    world: CollisionWorld, compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = ControlOptions()
    if not compiled:
        monkeypatch.setattr(ControlCycle, "compiled", lambda *_: None)
    # The reference is not the range centre, so the centring error grows during the motion.
    tasks = [Position(GOAL), JointCentring(reference=world.robot.home)]
    cycle, _ = _run(ApproachController(world, tasks, options))
    assert cycle.status == "reached"
    assert cycle.errors[0] <= options.tolerance
    assert len(cycle.errors) == 2
    assert cycle.errors[1] > options.tolerance


def test_endless_task_alone_decides_convergence(world: CollisionWorld) -> None:
    reference = world.robot.home + 0.2
    cycle, seconds = _run(ApproachController(world, [JointCentring(reference=reference)]))
    assert cycle.status == "reached"
    assert seconds > 1.0


def test_progress_of_higher_task_outweighs_lower_task(world: CollisionWorld) -> None:
    far = PointOnPlane(np.array([0.0, 0.0, 1.0]), 1.1)
    posture = Posture(world.robot.home)
    controller = ApproachController(world, [far, posture])
    cycle, _ = _run(controller)
    # The plane error falls by metres while the posture error grows by radians. This is progress.
    assert cycle.errors[0] <= controller.options.tolerance
    assert cycle.errors[1] > 0.1
    assert cycle.status == "stuck"
    assert cycle.reason.endswith("off: the tasks above leave no joint motion free")
    assert cycle.reason.startswith("posture")


def _stuck_reason(ball: list[float], goal: list[float], options: ControlOptions) -> str:
    obstacle = Obstacle("ball", Sphere(0.05), RigidTransform.from_translation(ball))
    world = CollisionWorld(RobotModel.load(LBR_ARM, "tool"), [obstacle])
    cycle, _ = _run(ApproachController(world, [Position(np.array(goal))], options))
    assert cycle.clearance < options.influence
    assert cycle.status == "stuck"
    return cycle.reason


def test_stuck_reason_reports_unreachable_goal_near_obstacle() -> None:
    reason = _stuck_reason([0.5, 0.12, 0.25], [2.0, 0.3, 0.4], ControlOptions(retreats=0))
    assert reason.endswith("out of reach from here")


def test_stuck_reason_reports_repulsion_in_balance_with_goal() -> None:
    options = ControlOptions(beta=5.0, retreats=0)
    reason = _stuck_reason([0.56, 0.25, 0.5], GOAL.tolist(), options)
    assert reason.endswith("repulsion balances the motion to the goal")


def test_tasks_of_controller_are_read_only(world: CollisionWorld) -> None:
    controller = ApproachController(world, [Position(GOAL)])
    with pytest.raises(AttributeError):
        controller.tasks = ()  # pyright: ignore[reportAttributeAccessIssue] -- the attribute is read-only


@pytest.mark.parametrize("tasks", [[], Position(GOAL), [GOAL]])
def test_controller_rejects_invalid_tasks(world: CollisionWorld, tasks: list) -> None:
    with pytest.raises(InputError, match="task"):
        ApproachController(world, tasks)


def test_unlimited_joints_have_retreat_configuration_and_numpy_cycle(
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


def test_names_of_blocking_constraints_are_computed_when_read(
    world: CollisionWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    named = []

    def count_names(*arguments: Any) -> tuple[str, ...]:
        named.append(arguments)
        return blocking_names(*arguments)

    monkeypatch.setattr(cycle_module, "blocking_names", count_names)
    # The acceleration limits are active in the first cycles.
    step = ApproachController(world, [Position(GOAL)]).step(world.robot.home)
    assert not named
    copy = pickle.loads(pickle.dumps(step))
    assert step.blocking
    assert all(name.startswith("joint ") for name in step.blocking)
    assert len(named) == 1
    assert copy.blocking == step.blocking
    assert replace(step, status="stuck").blocking == step.blocking
    assert not hasattr(step, "bloking")
