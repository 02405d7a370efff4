"""Braking: the kernels against plain simulations, and random states that stop before the limits."""

import numpy as np
import pytest

from eyehand.control import ApproachController, CollisionWorld, ControlOptions, RobotModel
from eyehand.control.braking_kernels import (
    Brake,
    acceleration_for,
    brake,
    brake_command,
    braking_distance,
    fading,
    joint_bounds,
)
from eyehand.control.packed_options import pack_options
from eyehand.control.tasks import Position, Posture
from eyehand.data_synth import LBR_ARM, TOOL_SITE
from eyehand.data_synth.scenes import ArmClearance, make_reaching_scene

from .conftest import boxes_world

ROUNDING = 1e-9
"""Maximum relative excess over a limit that counts as rounding."""
PERIODS = (0.0005, 0.001, 0.002, 0.004, 0.005, 0.02)
STATES = 10_000


def fading_reference(acceleration: float, change: float) -> float:
    steps = acceleration - np.sign(acceleration) * change * np.arange(1, 10_000)
    return float(steps[steps * acceleration > 0.0].sum())


def stop_reference(v: float, a: float, limit: float, change: float, dt: float):
    """Brake cycle by cycle; check every cycle; return end, lowest and highest displacement."""
    positions = [0.0]
    while abs(v) > 1e-12 or abs(a) > change:
        now = brake(v, a, limit, change, dt)
        assert abs(now) <= limit * (1.0 + ROUNDING)
        assert abs(now - a) <= change * (1.0 + ROUNDING)
        a, v = now, v + dt * now
        positions.append(positions[-1] + dt * v)
        assert len(positions) < 50_000
    return positions[-1], min(positions), max(positions)


def test_fading_and_its_inverse_equal_plain_sums():
    rng = np.random.default_rng(0)
    for _ in range(500):
        a, change = rng.uniform(-20, 20), rng.uniform(0.05, 30)
        assert fading(a, change) == pytest.approx(fading_reference(a, change), abs=1e-9)
        total = a + fading(a, change)
        assert acceleration_for(total, change) == pytest.approx(a, abs=1e-9)


def test_braking_distance_equals_simulation():
    rng = np.random.default_rng(1)
    for _ in range(400):
        dt, limit = rng.choice(PERIODS), rng.uniform(1, 30)
        change = dt * limit * rng.choice([50, 500, 5000])
        v, a = rng.uniform(-3, 3), rng.uniform(-limit, limit)
        expected = stop_reference(v, a, limit, change, dt)
        np.testing.assert_allclose(
            braking_distance(v, a, limit, change, dt), expected, rtol=0, atol=1e-10
        )


def test_exact_braking_distances():
    # 5 ms cycles, 15 rad/s²: 0.3 rad/s loses 0.075 rad/s per cycle, 0.225 + 0.15 + 0.075 rad/s.
    end, low, high = braking_distance(0.3, 0.0, 15.0, 37.5, 0.005)
    assert end == pytest.approx(0.005 * 0.45)
    assert (low, high) == (0.0, pytest.approx(end))
    # 1 ms cycles, 7.5 rad/s² more per cycle: -7.5, -15, -7.5, 0 lose 0.03 rad/s.
    end, _, _ = braking_distance(0.03, 0.0, 15.0, 7.5, 0.001)
    assert end == pytest.approx(0.001 * (0.0225 + 0.0075))
    # Without limits a joint stops at once.
    assert braking_distance(2.0, 0.0, np.inf, np.inf, 0.005)[0] == 0.0


def random_states(rng: np.random.Generator, count: int, dt: float):
    """Return joints (count,) that can stop in their range: limits, positions and motions."""
    lower, upper = rng.uniform(-3, -0.1, count), rng.uniform(0.1, 3, count)
    limit = rng.uniform(2, 25, count)
    jerk = limit * rng.choice([50, 500, 2000], count)
    limits = np.column_stack([lower, upper, rng.uniform(0.5, 3, count), limit, jerk])
    q, motion = np.zeros(count), np.zeros((2, count))
    for joint in range(count):
        change = jerk[joint] * dt
        while True:
            # Half of the joints are near a limit that they approach.
            near = rng.choice([lower[joint], upper[joint]])
            q[joint] = near * (1.0 - rng.random() ** 4)
            v = rng.uniform(-1, 1) * limits[joint, 2]
            a = rng.uniform(-1, 1) * limit[joint]
            peak = v + dt * fading(a, change)
            _, low, high = braking_distance(v, a, limit[joint], change, dt)
            if (
                abs(peak) <= limits[joint, 2]
                and q[joint] + low >= lower[joint]
                and q[joint] + high <= upper[joint]
            ):
                motion[:, joint] = v, a
                break
    return limits, q, motion


@pytest.mark.parametrize("dt", [0.001, 0.005])
def test_ten_thousand_random_states_stop_before_the_limits(dt):
    rng = np.random.default_rng(int(1e4 * dt))
    options = pack_options(ControlOptions(dt=dt, limit_margin=0.0, damper=1.0))
    limits, q, motion = random_states(rng, STATES // 2, dt)
    lower, upper, speed, limit, jerk = limits.T
    for cycle in range(40):
        low, high = np.empty(len(q)), np.empty(len(q))
        braking = Brake(np.empty(len(q)), np.empty(len(q)), np.empty(len(q)))
        joint_bounds(q, motion, limits, options, True, low, high, braking)
        assert np.all(low <= braking.command + ROUNDING)
        assert np.all(braking.command <= high + ROUNDING)
        # Commands that approach limits most: the ends of the interval, then the brake.
        chosen = rng.choice([0.0, 1.0, rng.random()], len(q))
        command = low + chosen * (high - low)
        if cycle >= 20:
            command = brake_command(motion, limits, dt)
        after = (command - motion[0]) / dt
        assert np.all(np.abs(after) <= limit * (1 + ROUNDING))
        assert np.all(np.abs(after - motion[1]) <= jerk * dt * (1 + ROUNDING) + 1e-9)
        assert np.all(np.abs(command) <= speed + ROUNDING)
        q, motion = q + dt * command, np.array([command, after])
        assert np.all(q <= upper + ROUNDING)
        assert np.all(q >= lower - ROUNDING)
    for joint in range(len(q)):
        v, a = motion[:, joint]
        _, least, most = braking_distance(v, a, limit[joint], jerk[joint] * dt, dt)
        assert q[joint] + most <= upper[joint] + ROUNDING
        assert q[joint] + least >= lower[joint] - ROUNDING


def drive(controller: ApproachController, q, cycles: int, *, stop_after: int):
    """Return positions and velocities of a motion that is stopped after some cycles."""
    options, path, commands = controller.options, [q], []
    for cycle in range(cycles):
        step = controller.stop(q) if cycle >= stop_after else controller.step(q)
        q = q + options.dt * step.velocity
        path.append(q)
        commands.append(step.velocity)
        if step.status == "stopped":
            break
    else:
        raise AssertionError("the arm did not stop")
    return np.array(path), np.array(commands)


@pytest.mark.parametrize("dt", [0.001, 0.005])
def test_motion_and_stop_keep_all_limits_and_the_margin(dt):
    rng = np.random.default_rng(5)
    for seed in range(800, 808):
        scene = make_reaching_scene(seed)
        world = boxes_world(scene)
        robot = world.robot
        controller = ApproachController(world, (Position(scene.goal),), ControlOptions(dt=dt))
        stop_after = int(rng.uniform(0.05, 1.5) / dt)
        path, commands = drive(controller, scene.start, 100_000, stop_after=stop_after)
        steps = np.vstack([np.zeros((2, robot.n)), commands])
        acceleration = np.diff(steps, axis=0) / dt
        jerk = np.diff(acceleration, axis=0) / dt
        assert np.all(np.abs(commands) <= robot.speed * (1 + ROUNDING))
        assert np.all(np.abs(acceleration) <= robot.acceleration * (1 + 1e-6))
        assert np.all(np.abs(jerk) <= robot.jerk * (1 + 1e-6))
        clearance = ArmClearance(scene.obstacles)
        assert min(clearance.at(q) for q in path[stop_after - 1 :]) > 0.0098


def test_stop_brakes_into_joint_limit_without_passing_it():
    robot = RobotModel.load(LBR_ARM, TOOL_SITE)
    options = ControlOptions(centring=0.0, retreats=0)
    goal = robot.upper + 1.0
    controller = ApproachController(CollisionWorld(robot), (Posture(goal, speed=9.0),), options)
    q = robot.home
    for _ in range(600):
        q = q + options.dt * controller.step(q).velocity
        assert np.all(q <= robot.upper - options.limit_margin + ROUNDING)


def test_velocity_ramps_from_standstill_and_from_a_given_velocity():
    robot = RobotModel.load(LBR_ARM, TOOL_SITE, acceleration=4.0, jerk=np.inf)
    world = CollisionWorld(robot)
    controller = ApproachController(world, (Posture(robot.home + 1.0, speed=9.0),))
    first = controller.step(robot.home).velocity
    assert np.abs(first).max() == pytest.approx(4.0 * 0.005)
    controller.resume(np.full(7, 0.3))
    np.testing.assert_allclose(controller.velocity, 0.3)
    assert controller.stop(robot.home).velocity == pytest.approx(np.full(7, 0.28))
