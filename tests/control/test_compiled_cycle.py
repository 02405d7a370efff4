"""The compiled control cycle against the stepwise one: random cycles and whole motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control.approach import ApproachController
from eyehand.control.braking import bounding_pairs, brake_from, command_rows
from eyehand.control.collision_world import CollisionWorld
from eyehand.control.cycle import ControlCycle
from eyehand.control.motion_steps import nominal_motion
from eyehand.control.options import ControlOptions
from eyehand.control.robot_model import RobotModel
from eyehand.control.safety_kernels import satisfies
from eyehand.control.shapes import Box, Capsule, Cylinder, Ellipsoid, Obstacle, Sphere
from eyehand.control.tasks import (
    AxisAlignment,
    DistanceToPoint,
    Interval,
    JointCentring,
    Manipulability,
    Position,
)
from eyehand.data_synth import LBR_ARM, TOOL_SITE
from eyehand.data_synth.scenes import make_reaching_scene
from eyehand.errors import InputError

from .conftest import ARM, HOME
from .test_task_kernels import interval_tasks, random_tasks

seeds = st.integers(0, 100_000)
TOLERANCE = 1e-9
"""Largest accepted rounding difference, rad/s. None of 12 000 random cycles exceeded it."""
SCENES = range(700, 720)
STILL = np.zeros((2, 7))
TASK = Position(np.array([0.45, 0.1, 0.5]))


def load_lbr() -> RobotModel:
    return RobotModel.load(LBR_ARM, TOOL_SITE)


def load_mixed_arm() -> RobotModel:
    """Return an arm with seven joints, one of them sliding, and a branch that does not move it."""
    home = np.insert(HOME, 3, 0.0)
    return RobotModel.load(ARM.format(third='type="slide"'), "hand", home=home)


def random_pose(rng: np.random.Generator) -> RigidTransform:
    direction = rng.normal(size=3)
    centre = direction / np.linalg.norm(direction) * rng.uniform(0.25, 0.8) + [0.0, 0.0, 0.3]
    return RigidTransform.from_components(centre, Rotation.random(rng=rng))


def make_world(robot: RobotModel, count: int) -> CollisionWorld:
    rng = np.random.default_rng(count)
    shapes = [
        Box(np.array([0.05, 0.1, 0.14])),
        Sphere(0.1),
        Capsule(0.05, 0.1),
        Cylinder(0.06, 0.1),
        Ellipsoid(np.array([0.05, 0.1, 0.15])),
    ]
    obstacles = [Obstacle(f"o{k}", shapes[k], random_pose(rng)) for k in range(count)]
    world = CollisionWorld(robot, obstacles)
    if count > 3:
        world.move("o1", random_pose(rng), 0.1 * rng.normal(size=6))
    return world


@pytest.fixture(scope="module")
def worlds() -> list[CollisionWorld]:
    return [
        make_world(make(), count) for make in (load_lbr, load_mixed_arm) for count in (0, 2, 3, 5)
    ]


def random_configuration(rng: np.random.Generator, robot: RobotModel) -> np.ndarray:
    """Return a random configuration, one at a joint limit, or one close to a singularity."""
    q = rng.uniform(robot.lower, robot.upper)
    choice = rng.integers(3)
    if choice == 1:
        joint = rng.integers(robot.n)
        q[joint] = rng.choice([robot.lower[joint], robot.upper[joint]])
    if choice == 2:
        q = robot.home + rng.normal(size=robot.n) * 10.0 ** rng.uniform(-6, -1)
        q[rng.integers(robot.n)] = 0.0
    return q


def random_last_command(rng: np.random.Generator, robot: RobotModel) -> np.ndarray:
    """Return a last command (2, n): standstill, or a velocity and an acceleration in the limits."""
    motion = np.zeros((2, robot.n))
    if rng.random() < 0.6:
        motion[0] = rng.uniform(-0.4, 0.4, robot.n) * robot.speed
        motion[1] = rng.uniform(-1.0, 1.0, robot.n) * robot.acceleration
    return motion


def check(cycle: ControlCycle, q: np.ndarray, last: np.ndarray | None = None) -> bool:
    """Compare the compiled cycle with the stepwise one. Return False where it falls back to it."""
    last = np.zeros((2, len(q))) if last is None else last
    motion, stepwise = cycle.compiled(q, last), cycle.in_steps(q, last)
    assert np.all(np.isfinite(stepwise.velocity))
    state, near = cycle.world.robot.at(q), cycle.world.proximity(q)
    braking = brake_from(cycle.world, state, last, cycle.options)
    if motion is None:
        # Only the stepwise cycle finds a compromise if a bound cannot be satisfied.
        assert not stepwise.feasible or stepwise.clearance < cycle.options.margin
        return False
    assert stepwise.feasible
    assert motion.feasible
    np.testing.assert_allclose(motion.errors, stepwise.errors, atol=TOLERANCE)
    np.testing.assert_allclose(motion.beta, stepwise.beta, atol=TOLERANCE)
    np.testing.assert_allclose(motion.clearance, stepwise.clearance, atol=TOLERANCE)
    nominal = nominal_motion(state, cycle.tasks, near, cycle.options).velocity
    rows, least = (
        command_rows(nominal, state, near, cycle.options, braking, recover=recover)
        for recover in (True, False)
    )
    if cycle.options.safety and not satisfies(stepwise.velocity, rows):
        # Not all pairs inside the margin can leave it at the recovery speed.
        assert satisfies(motion.velocity, least)
        return True
    np.testing.assert_allclose(motion.velocity, stepwise.velocity, atol=TOLERANCE)
    if motion.blocking != stepwise.blocking:
        # Parts that share a joint can give the same row. Either of them may be reported.
        pairs = bounding_pairs(near, braking)
        labels = [f"{first} near {second}" for first, second in pairs]
        for name in set(motion.blocking) ^ set(stepwise.blocking):
            index = labels.index(name)
            difference = np.abs(rows.rows - rows.rows[index]).max(axis=1)
            difference += np.abs(rows.min_rates - rows.min_rates[index])
            assert np.count_nonzero(difference < TOLERANCE) > 1
    return True


@settings(max_examples=300)
@given(seed=seeds)
def test_compiled_cycle_equals_stepwise_cycle(worlds, seed):
    rng = np.random.default_rng(seed)
    world = worlds[rng.integers(len(worlds))]
    options = ControlOptions(
        eta=2.0,
        safety=bool(rng.random() < 0.7),
        beta=float(rng.choice([0.0, 1.0, 2.0])) if rng.random() < 0.4 else "dynamic",
    )
    q = random_configuration(rng, world.robot)
    choices = random_tasks(rng, world.robot.n)
    choices += interval_tasks(rng, world.robot.at(q), choices)
    selected = rng.choice(len(choices), rng.integers(1, 5), replace=False)
    tasks = [choices[k] for k in selected]
    cycle = ControlCycle(world, tasks, options, choices[:2])
    check(cycle, q, random_last_command(rng, world.robot))


def test_few_cycles_fall_back_to_stepwise_cycle(worlds):
    rng = np.random.default_rng(3)
    compiled = [
        check(
            ControlCycle(world, (TASK,), ControlOptions()), random_configuration(rng, world.robot)
        )
        for world in worlds
        for _ in range(50)
    ]
    assert np.mean(compiled) > 0.95


def test_compiled_cycle_follows_changing_obstacles():
    world = make_world(load_lbr(), 2)
    cycle = ControlCycle(world, (TASK,), ControlOptions())
    q = world.robot.home
    first = cycle.compiled(q, STILL)
    pose = RigidTransform.from_translation([0.5, 0.0, 0.55])
    world.add(Obstacle("late", Sphere(0.05), pose))
    assert check(cycle, q)
    second = cycle.compiled(q, STILL)
    world.move("late", RigidTransform.from_translation([0.5, 0.0, 0.65]), np.full(6, 0.01))
    assert check(cycle, q)
    world.remove("late")
    for k in range(40):
        # More obstacles than slots: the world is compiled again, with new buffers.
        distant_pose = RigidTransform.from_translation([2.0, 0.0, 0.1 * k])
        world.add(Obstacle(f"far{k}", Sphere(0.02), distant_pose))
    assert check(cycle, q)
    world.attach("tool", Box(np.full(3, 0.02)), RigidTransform.from_translation([0, 0, 0.03]))
    assert check(cycle, q)
    assert first is not None
    assert second is not None
    assert not np.allclose(first.velocity, second.velocity)


def test_frame_can_be_a_body():
    robot = RobotModel.load(LBR_ARM, "link6")
    cycle = ControlCycle(CollisionWorld(robot), (TASK,), ControlOptions())
    assert check(cycle, robot.home)


def test_unsupported_tasks_use_stepwise_cycle():
    class CustomTask:
        name = "own"

        def at(self, state):
            return TASK.at(state)

    world = make_world(load_lbr(), 3)
    q = world.robot.home
    ready = ControlOptions()
    for tasks in ((CustomTask(),), (TASK, Manipulability(0.01))):
        assert ControlCycle(world, tasks, ready).compiled(q, STILL) is None
        assert ApproachController(world, tasks, ready).step(q).status == "moving"


def test_invalid_input_raises_from_compiled_cycle():
    world = make_world(load_lbr(), 1)
    several = Interval(Position(np.zeros(3)), 0.0, 1.0)
    with pytest.raises(InputError, match="needs a task of 1 row"):
        ApproachController(world, (several,)).step(world.robot.home)
    controller = ApproachController(world, (TASK,))
    with pytest.raises(InputError, match="q must be finite"):
        controller.step(np.full(7, np.nan))
    with pytest.raises(InputError, match="q must have shape"):
        controller.step(np.zeros(6))
    with pytest.raises(InputError, match="must be finite"):
        ApproachController(world, (Position(np.full(3, 1e200)),)).step(world.robot.home)


def drive(world: CollisionWorld, tasks, options: ControlOptions, q: np.ndarray, cycles: int):
    controller = ApproachController(world, tasks, options)
    path, statuses = [q], []
    for _ in range(cycles):
        cycle = controller.step(q)
        statuses.append(cycle.status)
        if cycle.status != "moving":
            break
        q = q + options.dt * cycle.velocity
        path.append(q)
    return np.array(path), statuses[-1]


@pytest.mark.parametrize("seed", SCENES)
def test_whole_motions_equal_stepwise_motions(seed, monkeypatch):
    scene = make_reaching_scene(seed)
    obstacles = [
        Obstacle(one.name, Box(np.array(one.size)), one.T_world_shape) for one in scene.obstacles
    ]
    world = CollisionWorld(load_lbr(), obstacles)
    tasks = [Position(scene.goal)]
    if seed % 2:
        tasks += [AxisAlignment(np.array([0.0, 0.0, 1.0]), np.array([0.3, 0.0, -1.0]))]
        tasks += [Interval(DistanceToPoint(np.zeros(3), 1.0), 0.2, 0.7), JointCentring(4)]
    options = ControlOptions(dt=0.02, eta=1.5)
    path, status = drive(world, tasks, options, scene.start, 400)
    monkeypatch.setattr(ControlCycle, "compiled", lambda *_: None)
    stepwise_path, stepwise_status = drive(world, tasks, options, scene.start, 400)
    assert np.all(np.isfinite(path))
    assert status == stepwise_status
    assert len(path) == len(stepwise_path)
    assert np.abs(path - stepwise_path).max() < 1e-9
