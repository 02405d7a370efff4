"""The compiled cycle against its single steps: cycles of all kinds, and whole motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control.approach import ApproachController
from eyehand.control.collision_world import CollisionWorld
from eyehand.control.cycle import ControlCycle
from eyehand.control.options import ControlOptions
from eyehand.control.robot_model import RobotModel
from eyehand.control.safety import safety_rows
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
from .test_task_kernels import any_tasks, bounded

seeds = st.integers(0, 100_000)
SAME = 1e-9
"""Rounding, rad/s: in 12 000 drawn cycles not one is farther off."""
SCENES = range(700, 720)
TASK = Position(np.array([0.45, 0.1, 0.5]))


def lbr() -> RobotModel:
    return RobotModel.load(LBR_ARM, TOOL_SITE)


def mixed() -> RobotModel:
    """Seven joints, one of them sliding, and a branch that moves nothing."""
    home = np.insert(HOME, 3, 0.0)
    return RobotModel.load(ARM.format(third='type="slide"'), "hand", home=home)


def somewhere(rng: np.random.Generator) -> RigidTransform:
    way = rng.normal(size=3)
    centre = way / np.linalg.norm(way) * rng.uniform(0.25, 0.8) + [0.0, 0.0, 0.3]
    return RigidTransform.from_components(centre, Rotation.random(rng=rng))


def world_of(robot: RobotModel, count: int) -> CollisionWorld:
    rng = np.random.default_rng(count)
    shapes = [
        Box(np.array([0.05, 0.1, 0.14])),
        Sphere(0.1),
        Capsule(0.05, 0.1),
        Cylinder(0.06, 0.1),
        Ellipsoid(np.array([0.05, 0.1, 0.15])),
    ]
    obstacles = [Obstacle(f"o{k}", shapes[k], somewhere(rng)) for k in range(count)]
    world = CollisionWorld(robot, obstacles)
    if count > 3:
        world.move("o1", somewhere(rng), 0.1 * rng.normal(size=6))
    return world


@pytest.fixture(scope="module")
def worlds() -> list[CollisionWorld]:
    return [world_of(make(), count) for make in (lbr, mixed) for count in (0, 2, 3, 5)]


def any_posture(rng: np.random.Generator, robot: RobotModel) -> np.ndarray:
    """Anywhere, at some joint's limit, or near a posture in which axes line up."""
    q = rng.uniform(robot.lower, robot.upper)
    choice = rng.integers(3)
    if choice == 1:
        joint = rng.integers(robot.n)
        q[joint] = rng.choice([robot.lower[joint], robot.upper[joint]])
    if choice == 2:
        q = robot.home + rng.normal(size=robot.n) * 10.0 ** rng.uniform(-6, -1)
        q[rng.integers(robot.n)] = 0.0
    return q


def check(cycle: ControlCycle, q: np.ndarray) -> bool:
    """Hold a cycle to the plain one; false where it leaves that to it."""
    motion, plain = cycle.compiled(q), cycle.in_steps(q)
    assert np.all(np.isfinite(plain.velocity))
    if motion is None:
        # What is inside the margin cannot all leave at the speed asked: the plain cycle weighs.
        assert not plain.feasible or plain.clearance < cycle.options.margin
        return False
    assert plain.feasible
    assert motion.feasible
    np.testing.assert_allclose(motion.velocity, plain.velocity, atol=SAME)
    np.testing.assert_allclose(motion.errors, plain.errors, atol=SAME)
    np.testing.assert_allclose(motion.beta, plain.beta, atol=SAME)
    np.testing.assert_allclose(motion.clearance, plain.clearance, atol=SAME)
    if motion.blocking != plain.blocking:
        # Parts that share a joint can be bound by the same row, and either blocks for both.
        near = cycle.world.proximity(q)
        least = safety_rows(cycle.world.robot.at(q), near, cycle.options).least
        told = [f"{first} near {second}" for first, second in near.names]
        for name in set(motion.blocking) ^ set(plain.blocking):
            place = told.index(name)
            away = np.abs(near.rows - near.rows[place]).max(axis=1)
            away += np.abs(least - least[place])
            assert np.count_nonzero(away < SAME) > 1
    return True


@settings(max_examples=300)
@given(seed=seeds)
def test_a_cycle_is_the_plain_one_to_rounding(worlds, seed):
    rng = np.random.default_rng(seed)
    world = worlds[rng.integers(len(worlds))]
    options = ControlOptions(
        eta=2.0,
        safety=bool(rng.random() < 0.7),
        beta=float(rng.choice([0.0, 1.0, 2.0])) if rng.random() < 0.4 else "dynamic",
    )
    q = any_posture(rng, world.robot)
    choices = any_tasks(rng, world.robot.n)
    choices += bounded(rng, world.robot.at(q), choices)
    chosen = rng.choice(len(choices), rng.integers(1, 5), replace=False)
    tasks = [choices[k] for k in chosen]
    check(ControlCycle(world, tasks, options, choices[:2]), q)


def test_few_cycles_are_left_to_the_plain_one(worlds):
    rng = np.random.default_rng(3)
    settled = [
        check(ControlCycle(world, (TASK,), ControlOptions()), any_posture(rng, world.robot))
        for world in worlds
        for _ in range(50)
    ]
    assert np.mean(settled) > 0.95


def test_obstacles_may_come_move_and_go():
    world = world_of(lbr(), 2)
    cycle = ControlCycle(world, (TASK,), ControlOptions())
    q = world.robot.home
    first = cycle.compiled(q)
    place = RigidTransform.from_translation([0.5, 0.0, 0.55])
    world.add(Obstacle("late", Sphere(0.05), place))
    assert check(cycle, q)
    second = cycle.compiled(q)
    world.move("late", RigidTransform.from_translation([0.5, 0.0, 0.65]), np.full(6, 0.01))
    assert check(cycle, q)
    world.remove("late")
    for k in range(40):
        # More than there is room for: the world is compiled anew, with other buffers.
        away = RigidTransform.from_translation([2.0, 0.0, 0.1 * k])
        world.add(Obstacle(f"far{k}", Sphere(0.02), away))
    assert check(cycle, q)
    world.attach("tool", Box(np.full(3, 0.02)), RigidTransform.from_translation([0, 0, 0.03]))
    assert check(cycle, q)
    assert first is not None
    assert second is not None
    assert not np.allclose(first.velocity, second.velocity)


def test_a_body_may_be_the_frame():
    robot = RobotModel.load(LBR_ARM, "link6")
    cycle = ControlCycle(CollisionWorld(robot), (TASK,), ControlOptions())
    assert check(cycle, robot.home)


def test_what_it_cannot_do_is_done_plainly():
    class Own:
        name = "own"

        def at(self, state):
            return TASK.at(state)

    world = world_of(lbr(), 3)
    q = world.robot.home
    ready = ControlOptions()
    for tasks in ((Own(),), (TASK, Manipulability(0.01))):
        assert ControlCycle(world, tasks, ready).compiled(q) is None
        assert ApproachController(world, tasks, ready).step(q).status == "moving"


def test_what_is_wrong_is_told_as_before():
    world = world_of(lbr(), 1)
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
    way, statuses = [q], []
    for _ in range(cycles):
        cycle = controller.step(q)
        statuses.append(cycle.status)
        if cycle.status != "moving":
            break
        q = q + options.dt * cycle.velocity
        way.append(q)
    return np.array(way), statuses[-1]


@pytest.mark.parametrize("seed", SCENES)
def test_whole_motions_are_the_same(seed, monkeypatch):
    scene = make_reaching_scene(seed)
    obstacles = [
        Obstacle(one.name, Box(np.array(one.size)), one.T_world_shape) for one in scene.obstacles
    ]
    world = CollisionWorld(lbr(), obstacles)
    tasks = [Position(scene.goal)]
    if seed % 2:
        tasks += [AxisAlignment(np.array([0.0, 0.0, 1.0]), np.array([0.3, 0.0, -1.0]))]
        tasks += [Interval(DistanceToPoint(np.zeros(3), 1.0), 0.2, 0.7), JointCentring(4)]
    options = ControlOptions(dt=0.02, eta=1.5)
    way, status = drive(world, tasks, options, scene.start, 400)
    monkeypatch.setattr(ControlCycle, "compiled", lambda *_: None)
    plain_way, plain_status = drive(world, tasks, options, scene.start, 400)
    assert np.all(np.isfinite(way))
    assert status == plain_status
    assert len(way) == len(plain_way)
    assert np.abs(way - plain_way).max() < 1e-9
