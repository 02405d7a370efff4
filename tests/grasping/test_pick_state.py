"""Shared state of the phases of a pick: the hand posture of the collision model."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.grasp.ground_truth_scene import ground_truth_scene
from eyehand.control.tasks import Position
from eyehand.data_synth.scenes import TabletopObject
from eyehand.grasping import GraspOptions, JawReading, load_hand, plan_prototypes
from eyehand.grasping import pick_state as pick_state_module
from eyehand.grasping.cell import Cell
from eyehand.grasping.grasp_phases import pre_grasp
from eyehand.grasping.hands import GripOptions
from eyehand.grasping.hands.closing import preshape_command
from eyehand.grasping.hands.jaw_control import JawControl
from eyehand.grasping.motion import NEAR_ENOUGH, execute
from eyehand.grasping.pick_options import PickOptions
from eyehand.grasping.pick_state import PickState, SelectedGrasp
from eyehand.grasping.tray import Tray
from eyehand.perception import Superquadric

from .fake_robot import HAND, FakeRobot

TRAY = Tray(np.array([0.0, -0.45, 0.006]), (0.25, 0.3), 0.05)
VIEW = np.array([0.0, 0.5, 0.9])


@pytest.fixture
def cell():
    return Cell(FakeRobot(), lambda _: ground_truth_scene([], VIEW), TRAY)


def pick_state(prototype, size=(0.012, 0.02, 0.03)) -> PickState:
    """Plan a grasp of a box with a prototype."""
    pose = RigidTransform.from_translation([0.05, 0.0, size[2]])
    shape = Superquadric(np.array(sorted(size)), (0.1, 0.1), pose, "box")
    scene = ground_truth_scene([TabletopObject("box", shape, 0.1, (0.8, 0.2, 0.2))], VIEW)
    (item,) = scene.objects
    plans = plan_prototypes(item, scene.support, hand=HAND, options=GraspOptions())
    plan = next(plan for plan in plans if plan.prototype == prototype)
    return PickState(SelectedGrasp(scene, item, plan))


@pytest.mark.parametrize("prototype", ["pincer", "precision"])
def test_collision_model_uses_preshaped_hand(cell, prototype):
    state = pick_state(prototype)
    command = preshape_command(HAND, state.plan.opening, prototype)
    preshaped, evenly_open = (
        cell.model(command.values),
        cell.model(HAND.excursions_at(state.plan.opening)),
    )
    assert state.model(cell) is preshaped
    assert (preshaped is evenly_open) == (prototype != "pincer"), (
        "a pincer's idle fingers stand wider"
    )


@pytest.mark.parametrize("end", [0.03, 0.15])
def test_motion_starts_and_brakes_within_the_limits(cell, end):
    goal = cell.palm_pose().translation + np.array([0.0, 0.2, 0.1])
    controller = pick_state("precision").move_off(cell, (Position(goal),), speed=1.0)
    commands = recorded_commands(cell, controller)
    start = cell.reading.time
    result = execute(
        cell, controller, 2.0, stop=lambda now: NEAR_ENOUGH if now.time > start + end else ""
    )
    assert result.reason == NEAR_ENOUGH
    assert len(commands) > round(end / cell.robot.period) + 1
    if end > 0.1:
        fastest = max(np.abs(velocity).max() for velocity in commands)
        assert fastest > 0.3, "the arm moves when the motion ends"
    np.testing.assert_array_equal(commands[-1], 0.0)
    assert_within_acceleration(cell, commands)


@pytest.mark.parametrize("status", ["stuck", "reached"])
def test_arm_brakes_within_the_limits_when_its_controller_ends(cell, status, monkeypatch):
    goal = cell.palm_pose().translation + np.array([0.0, 0.2, 0.1])
    controller = pick_state("precision").move_off(cell, (Position(goal),), speed=1.0)
    commands, start, step = recorded_commands(cell, controller), cell.reading.time, controller.step

    def ends(q):
        cycle = step(q)
        return replace(cycle, status=status) if cell.reading.time > start + 0.15 else cycle

    monkeypatch.setattr(controller, "step", ends)
    assert execute(cell, controller, 2.0).end == status
    assert max(np.abs(velocity).max() for velocity in commands) > 0.3
    np.testing.assert_array_equal(commands[-1], 0.0)
    assert_within_acceleration(cell, commands)


def test_hand_leaves_the_tray_within_the_limits(cell):
    palm = cell.palm_pose().translation
    cell.tray = replace(TRAY, centre=np.array([*palm[:2], 0.006]))
    commands = recorded_commands(cell)
    assert pre_grasp(cell, pick_state("precision")) is None
    assert cell.tray.distance(cell.palm_pose().translation) > 0.0
    assert_within_acceleration(cell, commands)


def test_contact_while_braking_stops_the_arm_at_once(cell):
    goal = cell.palm_pose().translation + np.array([0.0, 0.2, 0.1])
    controller = pick_state("precision").move_off(cell, (Position(goal),), speed=1.0)
    start = cell.reading.time

    def stop(now):
        passed = now.time - start
        return "contact" if passed > 0.17 else NEAR_ENOUGH if passed > 0.15 else ""

    result = execute(cell, controller, 2.0, stop=stop)
    assert (result.end, result.reason) == ("stopped", "contact")
    assert cell.reading.time - start < 0.18


def test_arm_whose_object_is_lost_brakes_within_the_limits(cell):
    goal = cell.palm_pose().translation + np.array([0.0, 0.2, 0.1])
    controller = pick_state("precision").move_off(cell, (Position(goal),), speed=1.0)
    start, commands = cell.reading.time, recorded_commands(cell)
    lost = execute(
        cell, controller, 2.0, stop=lambda r: "lost" * (r.time - start > 0.15), gentle=True
    )
    assert (lost.end, lost.reason) == ("stopped", "lost")
    assert max(np.abs(velocity).max() for velocity in commands) > 0.3
    assert_within_acceleration(cell, commands)


def test_bounce_between_the_pads_is_no_loss(cell):
    state = pick_state("precision")
    assert cell.robot.object_width is not None
    state.closing = closing = cell.hand.closing("precision", 0.06, GripOptions())
    robot = cell.robot
    robot.pulling = True
    for _ in range(800):
        cell.step(np.zeros(7), closing.step(cell.reading.hand, cell.robot.period))
    assert closing.state == "holding"
    robot.object_width = None
    for _ in range(10):
        cell.step(np.zeros(7), closing.step(cell.reading.hand, cell.robot.period))
    assert not cell.hand.holds(cell.reading.hand)
    assert not state.lost(cell)
    for _ in range(60):
        cell.step(np.zeros(7), closing.step(cell.reading.hand, cell.robot.period))
    assert state.lost(cell)


class Jaws:
    """A cell whose jaws open at a speed, after a time, to a width."""

    halted = ""
    options = PickOptions()

    def __init__(self, width, *, reached=0.08, late=0.0, speed=0.1, glitch=np.nan):
        self.hand = JawControl(load_hand("panda"))
        self.robot = SimpleNamespace(hand=self.hand.model, joints=("j",))
        self.reading = SimpleNamespace(time=0.0, hand=JawReading(width))
        self.reached, self.late, self.speed, self.width = reached, late, speed, width
        self.glitch = glitch

    def step(self, _velocity, _command):
        """Open the jaws for one period."""
        time = self.reading.time + 0.01
        if time > self.late:
            self.width = max(self.width, min(self.width + 0.01 * self.speed, self.reached))
        width = self.glitch if round(time, 2) == 1.0 else self.width
        self.reading = SimpleNamespace(time=time, hand=JawReading(width))

    def palm_pose(self):
        """Return a pose that no test reads."""
        return RigidTransform.identity()


def test_one_wrong_width_is_no_loss_but_an_empty_gripper_is():
    jaws, state = Jaws(0.04, reached=0.04, glitch=0.0), pick_state("precision")
    losses = []
    for _ in range(120):
        jaws.step(None, None)
        losses.append(bool(state.lost(jaws)))  # pyright: ignore[reportArgumentType]
    assert not any(losses)
    jaws.width = jaws.reached = 0.0
    for _ in range(8):
        jaws.step(None, None)
        losses.append(bool(state.lost(jaws)))  # pyright: ignore[reportArgumentType]
    assert losses[-1]


def released(monkeypatch, jaws, gripped):
    """Release an object gripped at a width; return the failure, and whether the hand moved off."""
    moved = []
    monkeypatch.setattr(pick_state_module, "execute", lambda *_: moved.append(True))
    monkeypatch.setattr(PickState, "move_off", lambda *_: None)
    state = pick_state("precision")
    if gripped is not None:
        state.closing, state.gripped = jaws.hand.closing("precision", 0.08, GripOptions()), gripped
    return state.release(jaws), bool(moved)


@pytest.mark.parametrize(
    ("width", "gripped", "opens", "least", "most"),
    [
        (0.04, 0.04, {"late": 1.0, "speed": 0.05}, 1.3, 1.5),
        (0.04, 0.04, {"speed": 0.002}, 3.0, 3.1),
        (0.07, 0.07, {"reached": 0.074}, 3.0, 3.1),
        (0.079, 0.04, {"reached": 0.079}, 0.0, 0.0),
        (0.0, 0.04, {"speed": 0.01}, 1.9, 2.1),
        (0.079, None, {"reached": 0.079}, 0.2, 0.3),
    ],
    ids=["late", "very slow", "not by the whole stroke", "open before", "object lost", "no grip"],
)
def test_hand_moves_off_once_its_jaws_have_let_go(monkeypatch, width, gripped, opens, least, most):
    jaws = Jaws(width, **opens)
    assert released(monkeypatch, jaws, gripped) == (None, True)
    assert least <= jaws.reading.time <= most


@pytest.mark.parametrize(
    ("width", "opens", "said"),
    [
        (0.04, {"reached": 0.041}, "41 mm wide after 3 s"),
        (0.077, {"reached": 0.077, "glitch": 0.079}, "77 mm wide"),
        (np.nan, {"reached": np.nan}, "nan mm wide"),
    ],
    ids=["jaws that stay", "one reading beside the others", "width that is not a number"],
)
def test_arm_stays_while_its_jaws_may_hold_the_object(monkeypatch, width, opens, said):
    failure, moved = released(monkeypatch, Jaws(width, **opens), min(width, 0.077))
    assert failure is not None
    assert failure.outcome == "hand_stalled"
    assert said in failure.reason
    assert not moved


def recorded_commands(cell, controller=None):
    """Return the list of joint velocities, beginning with rest, that the robot gets from now on."""
    commands = [np.zeros(len(cell.robot.joints))]
    step = cell.robot.step

    def recorded(velocity, command=None):
        commands.append(np.array(velocity))
        if controller is not None and velocity.any():
            # Otherwise the controller brakes too late before obstacles.
            np.testing.assert_allclose(controller.velocity, velocity)
        return step(velocity, command)

    cell.robot.step = recorded
    return commands


def assert_within_acceleration(cell, commands):
    """Assert that no joint changes its velocity faster than its limit."""
    changes = np.abs(np.diff(commands, axis=0))
    limits = cell.model(HAND.excursions[-1]).limits()[:, 3]
    assert (changes <= limits * cell.robot.period * (1.0 + 1e-6)).all()
