"""What a robot does not report itself becomes a fault, and the arm is stopped."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from eyehand.control import ApproachController, CollisionWorld, ControlOptions
from eyehand.control.tasks import Posture
from eyehand.errors import DeviceError
from eyehand.grasping import Cell, Tray
from eyehand.grasping.hands import JawReading
from eyehand.grasping.motion import execute
from eyehand.grasping.robot_watch import RobotWatch

from .fake_robot import FakeRobot

START = FakeRobot().q
LIMITS = np.full(len(START), 7.5)


class Arm(FakeRobot):
    """A robot whose states, read after each step, pass through ``change``."""

    def __init__(self, change):
        super().__init__()
        self.change, self.velocities = change, []

    def step(self, velocity, command=None):
        """Record the velocity, move, and return the changed state."""
        self.velocities.append(np.array(velocity))
        return self.change(self, super().step(velocity, command))


def faults(change, speed=0.3, seconds=1.0):
    """Return the first fault, the time at which it came, s, and the robot."""
    robot = Arm(change)
    watch = RobotWatch(robot.read(), LIMITS)
    velocity = np.full(len(robot.joints), speed)
    for _ in range(round(seconds / robot.period)):
        before = robot.time
        reading = watch.step(robot, velocity, None)
        if reading.fault:
            # Without the time in which the arm brakes.
            return reading.fault, before + robot.period, robot
    return "", robot.time, robot


def lost(robot, reading):
    if robot.time > 0.1:
        raise TimeoutError("no answer\nafter 20 s")
    return reading


def unplugged(robot, reading):
    raise RuntimeError("modbus")


def faster(factor):
    """Return a change of readings: the joints move at a multiple of the command, to 2 rad/s."""

    def change(robot, reading):
        way = np.minimum(factor * (reading.q - START), 2.0 * reading.time)
        return replace(reading, q=START + way)

    return change


def test_robot_that_follows_has_no_fault():
    assert faults(lambda robot, reading: reading)[0] == ""


@pytest.mark.parametrize(
    ("change", "words", "latest"),
    [
        (lost, "the robot's driver failed: no answer after 20 s", 0.11),
        (unplugged, "the robot's driver failed: RuntimeError: modbus", 0.01),
        (faster(3.0), "moves farther than commanded: it moved 0.2", 0.4),
        (faster(57.3), "check that the driver takes rad/s", 0.3),
        (lambda robot, r: replace(r, time=1e3 * r.time), "4 s in a period of 0.004 s", 0.03),
        (lambda robot, r: replace(r, q=START), "the arm does not follow: it moved 0.000 rad", 0.65),
        (lambda robot, r: replace(r, time=0.0), "the arm has sent no new state for 0.3 s", 0.35),
        (lambda robot, r: replace(r, q=r.q * np.nan), "7 finite joint angles, got [nan", 0.01),
        (lambda robot, r: None, "robot.step() must return a RobotReading", 0.01),
        (lambda robot, r: replace(r, q=r.q[:3]), "7 finite joint angles, got [", 0.01),
    ],
)  # fmt: skip
def test_each_end_has_a_name_and_stops_the_arm(change, words, latest):
    fault, time, robot = faults(change)

    assert words in fault
    assert time <= latest + robot.period
    np.testing.assert_array_equal(robot.velocities[-1], 0.0)


@pytest.mark.parametrize("speed", [0.3, 0.05])
def test_joint_with_the_wrong_sign_is_named_before_it_moves_far(speed):
    fault, time, robot = faults(mirrored, speed, seconds=3.0)

    assert f"joint {robot.joints[3]} moves against its command" in fault
    assert time < 0.11 / speed


def motions(period, peak, rng):
    """Yield the velocities of motions from rest to rest at up to ``peak`` rad/s, with pauses."""
    for _ in range(12):
        ramp = np.arange(0.0, peak, 10.0 * period)
        cruise = np.full(int(rng.uniform(0.0, 1.0) / period), peak)
        pause = np.zeros(int(rng.uniform(0.0, 0.4) / period))
        yield from rng.choice([-1, 1]) * np.concatenate([ramp, cruise, ramp[::-1], pause])


@pytest.mark.parametrize(("delay", "peak"), [(8, 1.0), (8, 3.0), (15, 1.5), (15, 3.0)])
def test_late_arm_that_reverses_has_no_fault(delay, peak):
    """Delays of 32 and 60 ms."""
    robot = FakeRobot()
    states = [robot.read()] * (delay + 1)

    def delayed(arm, reading):
        states.append(reading)
        return replace(states[-1 - delay], time=reading.time)

    arm = Arm(delayed)
    watch = RobotWatch(arm.read(), LIMITS)
    for velocity in motions(arm.period, peak, np.random.default_rng(delay)):
        assert not watch.step(arm, np.full(len(arm.joints), velocity), None).fault
        assert watch.held is None


def test_arm_that_is_too_late_is_named(caplog):
    """80 ms, known to 5 ms: a constant command shows no more."""
    states = []

    def delayed(arm, reading):
        states.append(reading)
        return replace(states[max(len(states) - 21, 0)], time=reading.time)

    assert not faults(delayed, speed=0.6)[0]
    assert "follows its commands 85 ms late" in caplog.text


@pytest.mark.parametrize("late", [0.0, 0.028, 0.048])
def test_late_arm_keeps_its_joint_limits(late):
    """The delay is unknown in the first motion. The largest unnamed one is assumed."""
    delay = round(late / FakeRobot().period)
    states = [FakeRobot().read()] * (delay + 1)
    farthest = np.zeros(len(START))

    def delayed(robot, reading):
        np.maximum(farthest, np.abs(reading.q), out=farthest)
        states.append(reading)
        return replace(states[-1 - delay], time=reading.time)

    cell = Cell(Arm(delayed), no_scene, Tray(np.zeros(3), (0.2, 0.2), 0.05))
    model = cell.model(cell.hand.posture(cell.hand.max_opening))
    options = ControlOptions(dt=cell.robot.period, tolerance=0.02)
    for side in (1.0, -1.0):
        goal = np.array(START)
        goal[4] = side * model.upper[4]
        task = Posture(goal, speed=3.0, gain=50.0)
        assert execute(cell, ApproachController(CollisionWorld(model, ()), (task,), options), 10.0)

    assert model.upper[4] - 0.02 < farthest[4] < model.upper[4]


def test_arm_that_freezes_does_not_stray():
    """It freezes at 0.4 rad; the controller turns its command back."""
    states = []

    def frozen(arm, reading):
        states.append(reading.q)
        return replace(reading, q=states[:100][-1])

    arm = Arm(frozen)
    watch = RobotWatch(arm.read(), LIMITS)
    for k in range(400):
        watch.step(arm, np.full(len(arm.joints), 1.0 if k < 100 else -1.0), None)
    assert "does not follow" in watch.reading.fault


def test_push_in_a_former_motion_is_no_fault_of_the_next():
    """A contact holds the joints back by 0.25 rad; then the arm moves back."""
    arm = Arm(lambda robot, r: replace(r, q=r.q - min(0.25, max(0.0, robot.time - 0.5))))
    watch = RobotWatch(arm.read(), LIMITS)
    for speed, seconds in ((0.5, 1.0), (-0.5, 1.0)):
        watch.begin_motion()
        for _ in range(round(seconds / arm.period)):
            velocity = np.full(len(arm.joints), speed)
            assert not watch.step(arm, velocity, None).fault


def blocked(robot, reading):
    """Return a state in which joint 4 meets an obstacle after 0.1 rad; the others follow."""
    q = reading.q.copy()
    q[3] = min(q[3], START[3] + 0.1)
    return replace(reading, q=q)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (blocked, rf"{FakeRobot().joints[3]} back: it moved 0\.10 of 0\.1\d rad"),
        (faster(0.2), r"\w+ back: it moved 0\.02 of 0\.09 rad commanded\. .* the driver is slow"),
    ],
)
def test_joint_that_is_held_back_is_named_at_a_small_angle(change, words):
    arm = Arm(change)
    watch = RobotWatch(arm.read(), LIMITS)
    while watch.held is None:
        assert not watch.step(arm, np.full(len(arm.joints), 0.2), None).fault
    assert re.match(f"something holds joint {words}", watch.held.reason)
    watch.begin_motion()
    assert watch.held is None


def test_motion_in_free_space_ends_soon_after_a_joint_is_blocked():
    """It is not pushed until the time limit of the motion."""
    robot, result = moved(blocked)

    assert result.end == "stuck"
    assert re.match(f"something holds joint {robot.joints[3]} back", result.reason)
    pushes = np.flatnonzero(np.array(robot.velocities)[:, 3] > 0.0)
    # 0.1 rad at 0.3 rad/s, 0.05 rad and 0.12 s behind, 0.2 s held, and braking.
    assert robot.period * pushes[-1] < 0.1 / 0.3 + 0.05 / 0.3 + 0.12 + 0.2 + 0.1
    assert not robot.velocities[-1].any()


def mirrored(robot, reading):
    """Return a state in which joint 4 moves against its command."""
    q = reading.q.copy()
    q[3] = 2 * START[3] - q[3]
    return replace(reading, q=q)


def stopped(after):
    """Return a change of states: joint 4 stops for good after a time in s."""
    angles = []

    def change(robot, reading):
        q = reading.q.copy()
        angles.append(q[3])
        q[3] = angles[min(len(angles), max(round(after / robot.period), 1)) - 1]
        return replace(reading, q=q)

    return change


def moved(change, **options):
    """Return the robot, and the result of an endless motion of all joints."""
    robot = Arm(change)
    cell = Cell(robot, no_scene, Tray(np.zeros(3), (0.2, 0.2), 0.05))
    return robot, execute(cell, Endless(0.3), 5.0, **options)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (stopped(0.0), "does not follow: .* and it moves neither back nor on"),
        (stopped(0.8), "does not follow: .* and it moves neither back nor on"),
        (mirrored, r"moves against its command: it moved .*; check the sign"),
    ],
)
def test_joint_that_does_not_move_back_is_a_fault_of_the_first_motion(change, words, caplog):
    robot, result = moved(change)

    assert result.end == "fault"
    assert re.match(f"joint {robot.joints[3]} {words}", result.reason)
    assert robot.time < 3.0
    assert not robot.velocities[-1].any()
    assert "is slow" not in caplog.text


def test_joint_that_an_obstacle_held_back_in_another_motion_is_no_fault():
    """The driver adds up the commands, so the joint returns only after they do."""
    robot = Arm(blocked)
    cell = Cell(robot, no_scene, Tray(np.zeros(3), (0.2, 0.2), 0.05))

    def back(reading):
        return "back" if reading.q[3] < START[3] else ""

    pressed = execute(cell, Endless(0.3), 5.0, guarded=True)  # pyright: ignore[reportArgumentType]
    first = execute(cell, Endless(-0.3), 5.0, stop=back)  # pyright: ignore[reportArgumentType]
    second = execute(cell, Endless(-0.3), 5.0, stop=back)  # pyright: ignore[reportArgumentType]

    assert robot.q[3] < START[3]
    assert [pressed.end, first.end, second.end] == ["stuck", "stuck", "stopped"]


def test_arm_at_half_its_speed_is_not_held_back_but_named(caplog):
    """Some arms scale all speeds."""
    arm = Arm(faster(0.5))
    watch = RobotWatch(arm.read(), LIMITS)
    for _ in range(round(5.0 / arm.period)):
        assert not watch.step(arm, np.full(len(arm.joints), 0.2), None).fault
        assert watch.held is None
    assert caplog.text.count("is slow: it moved 0.30 of 0.60 rad commanded; check the driver") == 1


def test_states_that_arrive_in_a_wrong_order_make_no_arm_slow(caplog):
    """Each third state is two periods older than the one before."""
    states = []

    def disordered(robot, reading):
        states.append(reading)
        return states[-3] if len(states) % 3 == 0 else reading

    arm = Arm(disordered)
    watch = RobotWatch(arm.read(), LIMITS)
    for _ in range(round(3.0 / arm.period)):
        assert not watch.step(arm, np.full(len(arm.joints), 0.3), None).fault
    assert watch.held is None
    assert not caplog.text


def test_arm_moved_by_hand_in_a_pause_has_no_fault():
    def moved(robot, reading):
        late = robot.time > 0.4
        return replace(reading, q=reading.q + 0.5 * late, time=reading.time + 20.0 * late)

    assert faults(moved)[0] == ""


def test_arm_that_goes_on_while_its_driver_is_slow_has_no_fault_but_a_warning(caplog):
    """Each step takes three periods, and the arm moves for all of them."""

    def slow(robot, reading):
        return replace(reading, q=START + 3 * (reading.q - START), time=3 * reading.time)

    assert faults(slow)[0] == ""
    assert "a step takes 0.012 s, robot.period is 0.004 s" in caplog.text


def test_stopped_robot_receives_no_more_commands():
    robot = Arm(lambda arm, reading: replace(reading, fault="the emergency stop is pressed"))
    watch = RobotWatch(robot.read(), LIMITS)
    for _ in range(5):
        watch.step(robot, np.full(len(robot.joints), 0.3), None)

    assert watch.reading.fault == "the emergency stop is pressed"
    assert len(robot.velocities) == 2
    assert not robot.velocities[-1].any()


def test_one_unusable_reading_brakes_within_the_limits():
    fault, _, robot = faults(lambda arm, r: replace(r, q=r.q * np.nan))
    assert "finite" in fault
    changes = np.abs(np.diff(robot.velocities, axis=0)) / robot.period
    assert changes.max() <= 7.5 + 1e-9
    assert len(robot.velocities) > 5
    assert not robot.velocities[-1].any()


def test_arm_of_a_driver_that_raises_brakes_within_the_limits():
    """Only the hand may have failed; then the arm still follows."""

    def fails(arm, reading):
        if arm.time > 0.1:
            raise OSError("cable")
        return reading

    fault, _, robot = faults(fails)
    assert fault == "the robot's driver failed: cable"
    changes = np.abs(np.diff(robot.velocities, axis=0)) / robot.period
    assert changes.max() <= 7.5 + 1e-9
    assert not robot.velocities[-1].any()


def width(number, until=np.inf):
    """Return a change of states whose jaws have a width from 0.1 s on."""

    def change(robot, reading):
        late = 0.1 < robot.time < until
        return replace(reading, hand=JawReading(number if late else 0.05, 3.0))

    return change


def test_a_width_that_is_no_number_keeps_the_last_one_and_soon_is_a_fault():
    fault, when, _ = faults(width(np.nan))
    assert fault.startswith("the hand has sent no finite reading for 0.3 s")
    assert when == pytest.approx(0.4, abs=0.02)
    assert faults(width(np.nan, until=0.3))[0] == ""
    robot = Arm(width(np.nan))
    watch = RobotWatch(robot.read(), LIMITS)
    for _ in range(50):
        reading = watch.step(robot, np.zeros(len(robot.joints)), None)
        assert reading.hand == JawReading(0.05, 3.0)


def test_step_that_takes_long_while_the_arm_moves_is_named(caplog):
    def slow(robot, reading):
        return replace(reading, time=reading.time + (0.5 if robot.time > 0.1 else 0.0))

    assert faults(slow, seconds=0.3)[0] == ""
    assert caplog.text.count("a step took 0.5 s while the arm moved") == 1


def test_second_interrupt_while_braking_still_stops_the_arm():
    def interrupted(arm, reading):
        if arm.velocities[-1].any() and arm.time > 0.02:
            raise KeyboardInterrupt
        return reading

    arm = Arm(interrupted)
    watch = RobotWatch(arm.read(), LIMITS)
    for _ in range(5):
        watch.step(arm, np.full(len(arm.joints), 0.3), None)
    with pytest.raises(KeyboardInterrupt):
        watch.stop(arm)
    assert not arm.velocities[-1].any()


def test_error_of_the_last_stop_does_not_hide_the_fault():
    def broken(robot, reading):
        raise DeviceError("cable")

    assert faults(broken)[0] == "the robot's driver failed: cable"


def no_scene(frame):
    pytest.fail("no image is perceived")


class Endless:
    """A controller that never reaches its goal."""

    def __init__(self, speed=0.1):
        self.speed = speed

    def step(self, q):
        """Move on."""
        return SimpleNamespace(velocity=np.full(len(q), self.speed), status="moving")

    def resume(self, velocity, acceleration=None):
        """Ignore the velocity."""

    def stop(self, q):
        """Stand still."""
        return SimpleNamespace(velocity=np.zeros(len(q)))


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_error_in_a_motion_stops_the_arm_before_it_is_raised(error):
    robot = Arm(lambda robot, reading: reading)

    def interrupt(reading):
        if robot.time > 0.1:
            raise error
        return ""

    cell = Cell(robot, no_scene, Tray(np.zeros(3), (0.2, 0.2), 0.05))
    with pytest.raises(error):
        execute(cell, Endless(), 5.0, stop=interrupt)  # pyright: ignore[reportArgumentType]

    assert robot.velocities[-2].any()
    np.testing.assert_array_equal(robot.velocities[-1], 0.0)
