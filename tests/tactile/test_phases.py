"""The phase machine: to the contact, through the task, and off again whatever happens."""

import math
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.tactile import ContactFeatures
from eyehand.tactile import phases as phases_module
from eyehand.tactile.error_watchdog import ErrorWatchdog
from eyehand.tactile.oscillation_detector import OscillationDetector
from eyehand.tactile.phase_options import PhaseOptions
from eyehand.tactile.phases import Outcome, TouchPhases
from eyehand.tactile.selection import PRESS, TRACK
from eyehand.tactile.servo import ServoGoal, TactileServo
from eyehand.tactile.servo_options import ServoOptions

from .closed_loop import DT, OBJECTS, World, ball

NOTHING = ContactFeatures(0.0, np.zeros(3), 0.0, 0.0, 0.0, 0.0)
OPTIONS = PhaseOptions(task_seconds=3.0)


def world_of(name: str, x: float = 0.0) -> World:
    height, stiffness = OBJECTS[name]
    return World(height, stiffness, place=np.array([x, 0, -0.005]), noise=3.0, threshold=15.0)


def emptiness(x, y):
    return np.full_like(x, np.inf)


def play(world, machine, hook=None, seconds=20.0, **kwargs):
    """Run until the machine has ended; phases in order and the largest force."""
    phases, peak = [], 0.0
    for cycle in range(round(seconds / DT)):
        if hook:
            hook(cycle, world, machine)
        step = machine.step(world.features(), DT, **kwargs)
        world.step(step.twist)
        peak = max(peak, world.force())
        if not phases or phases[-1] != step.phase:
            phases.append(step.phase)
        if step.phase == "ended":
            assert step.outcome in get_args(Outcome)
            assert not machine.step(world.features(), DT).twist.any()
            return phases, peak
    raise AssertionError(f"never ended: {phases}")


@pytest.mark.parametrize("name", OBJECTS)
def test_a_task_runs_its_time_and_leaves_the_object(name):
    world, machine = world_of(name), TouchPhases(TactileServo(), OPTIONS)
    phases, peak = play(world, machine)
    assert phases == ["hold", "task", "back_off", "ended"]
    assert machine.outcome == "done"
    assert world.force() == 0.0
    assert peak < 8.0


def test_the_caller_drives_to_the_work_area_and_only_then_does_the_pad_descend():
    machine = TouchPhases(TactileServo(), OPTIONS)
    for _ in range(10):
        step = machine.step(NOTHING, DT, pose_error=(0.1, 0.0))
        assert step.phase == "move"
        assert not step.twist.any()
    step = machine.step(NOTHING, DT, pose_error=(0.001, 0.001))
    assert step.phase == "hold"
    assert step.twist[2] == OPTIONS.approach_speed


def test_a_work_area_that_is_not_reached_is_unreachable(monkeypatch):
    monkeypatch.setattr(phases_module, "MAX_MOVE_SECONDS", 0.1)
    machine = TouchPhases(TactileServo(), OPTIONS)
    steps = [machine.step(NOTHING, DT, pose_error=(0.1, 0.0)) for _ in range(40)]
    assert steps[-1].outcome == "unreachable"
    assert steps[-1].phase == "ended"


def test_where_nothing_is_nothing_is_found():
    world, machine = World(emptiness, noise=3.0, threshold=15.0), TouchPhases(TactileServo())
    play(world, machine)
    assert machine.outcome == "no_contact"
    assert world.place[2] < 0.06


def test_a_pad_told_to_hold_waits_for_the_object_to_come():
    world = world_of("box")
    machine = TouchPhases(TactileServo(), replace(OPTIONS, approach_speed=0.0))

    def come(cycle, world, machine):
        if machine.phase in ("move", "hold"):
            assert not world.velocity.any()
            world.place = world.place + np.array([0.0, 0.0, 2e-5])

    assert play(world, machine, come)[0][:2] == ["hold", "task"]


def test_a_contact_that_slipped_off_is_found_again():
    world, machine = world_of("pen"), TouchPhases(TactileServo(), OPTIONS)

    def slip(cycle, world, machine):
        if cycle == 400:
            world.place = world.place - np.array([0.012, 0.0, 0.004])

    phases, _ = play(world, machine, slip)
    assert phases == ["hold", "task", "search", "task", "back_off", "ended"]
    assert machine.outcome == "done"


def test_a_contact_that_is_gone_is_searched_for_a_while():
    world, machine = world_of("box"), TouchPhases(TactileServo(), PhaseOptions())

    def vanish(cycle, world, machine):
        if cycle == 400:
            world.height = emptiness

    phases, _ = play(world, machine, vanish)
    assert phases[-3:] == ["search", "back_off", "ended"]
    assert machine.outcome == "contact_lost"


def test_an_object_that_comes_too_fast_is_fled():
    world, machine = world_of("box"), TouchPhases(TactileServo(), PhaseOptions())

    def press(cycle, world, machine):
        if cycle > 300 and machine.outcome is None:
            world.place = world.place + np.array([0.0, 0.0, 3e-4])

    play(world, machine, press)
    assert machine.outcome == "overload"
    assert world.force() == 0.0


def test_tactels_that_cannot_tell_more_count_as_overload():
    machine = TouchPhases(TactileServo(), OPTIONS)
    features = ContactFeatures(1.0, np.zeros(3), 900.0, 1e-3, 0.0, 0.0, tactels=40, saturated=12)
    steps = [machine.step(features, DT) for _ in range(3)]
    assert steps[-1].outcome == "overload"
    assert steps[-1].twist[2] < 0


@pytest.mark.parametrize(("name", "share"), [("box", 1.5), ("box", 2.0), ("pen", 4.0)])
def test_a_gain_beyond_the_limit_ends_with_the_pad_backed_off(name, share):
    options = ServoOptions(stability_share=share, press_gain=1e3)
    world, machine = world_of(name), TouchPhases(TactileServo(None, PRESS, options), OPTIONS)
    _, peak = play(world, machine)
    assert machine.outcome in ("oscillation", "contact_lost")
    assert world.force() == 0.0
    assert peak < 15.0


def test_an_object_that_gives_way_is_not_pushed_for_ever():
    world, machine = world_of("box"), TouchPhases(TactileServo(None, PRESS), PhaseOptions())
    way, height = [0.0], world.height

    def give_way(cycle, world, machine):
        pressure = float(world.pressures().max())
        way[0] += max(0.0, pressure - 100.0) * 5e-7
        world.height = lambda x, y: height(x, y) + way[0]

    play(world, machine, give_way)
    assert machine.outcome == "no_resistance"
    assert world.force() == 0.0


@pytest.mark.parametrize(("speed", "sign"), [(0.016, 1.0), (-0.013, -1.0)])
def test_a_pressure_that_stays_off_its_goal_is_left(speed, sign, monkeypatch):
    """An object that comes or goes faster than the integral may make up for."""
    monkeypatch.setattr(phases_module, "NEAR_GOAL", 0.0)
    world, felt = world_of("box"), []
    options = ServoOptions(known_stiffness=1e6)
    machine = TouchPhases(TactileServo(None, PRESS, options), PhaseOptions())

    def come(cycle, world, machine):
        if machine.phase == "task":
            felt.append(machine.servo.filtered[0])
            share = min(len(felt) / 250, 1.0)
            world.place = world.place + np.array([0.0, 0.0, share * speed * DT])

    play(world, machine, come)
    assert machine.outcome == "steady_miss"
    assert world.force() == 0.0
    # It had settled there: neither a landing nor a run-away.
    late = np.array(felt[-125:]) / 1000.0 - 1.0
    assert np.all(sign * late > 0.1)
    assert late.std() < 0.05


def test_a_swing_below_half_of_the_goal_that_lasts_is_an_oscillation():
    for swing, outcome in ((0.3, "oscillation"), (0.03, "done")):
        machine = TouchPhases(TactileServo(None, PRESS), OPTIONS)
        twist = np.zeros(6)
        for cycle in range(2000):
            pressure = 1000.0 + 500.0 * swing * math.sin(2 * math.pi * 6 * cycle * DT)
            features = ContactFeatures(1e-3 * pressure, np.zeros(3), pressure, 1e-3, 0.0, 0.0)
            twist = machine.step(features, DT).twist
            if machine.outcome:
                break
        assert machine.outcome == outcome
        assert twist[2] < 0


def test_a_contact_that_noise_takes_and_gives_back_is_unsteady_and_no_oscillation():
    machine = TouchPhases(TactileServo(None, PRESS), OPTIONS)
    felt = ContactFeatures(1e-3, np.zeros(3), 1200.0, 4e-5, 0.0, 0.0)
    nothing = ContactFeatures(0.0, np.zeros(3), 0.0, 0.0, 0.0, 0.0)
    for cycle in range(500):
        machine.step(nothing if cycle % 20 > 14 else felt, DT)
        if machine.outcome:
            break
    assert machine.outcome == "unsteady_contact"


def test_a_contact_that_fades_before_it_comes_again_is_an_oscillation():
    """As under a pad that bounces: the pressure falls from cycle to cycle."""
    machine = TouchPhases(TactileServo(None, PRESS), OPTIONS)
    for cycle in range(500):
        pressure = 700.0 * max(0.0, 0.9 + math.sin(2 * math.pi * 5 * cycle * DT))
        machine.step(ContactFeatures(1e-3 * pressure, np.zeros(3), pressure, 1e-3, 0.0, 0.0), DT)
        if machine.outcome:
            break
    assert machine.outcome == "oscillation"


def test_what_the_outer_motion_does_to_the_pressure_is_no_steady_miss():
    for outer, outcome in ((0.0, "steady_miss"), (0.02, "done")):
        machine = TouchPhases(TactileServo(None, PRESS), OPTIONS)
        features = ContactFeatures(1.3, np.zeros(3), 1300.0, 1e-3, 0.0, 0.0)
        while machine.outcome is None:
            machine.step(features, DT, external=np.array([outer, 0, 0, 0, 0, 0]))
        assert machine.outcome == outcome


def test_a_goal_of_force_is_guarded_by_the_force():
    """A narrow imprint's pressure is far above the force over the reference area."""
    servo = TactileServo(ServoGoal(force=1.0), PRESS)
    machine = TouchPhases(servo, OPTIONS)
    for cycle in range(1000):
        swing = 0.02 * math.sin(2 * math.pi * 6 * cycle * DT)
        area = 3.3e-4 * (1.0 + 10.0 * swing)
        force = 1.0 + swing
        machine.step(ContactFeatures(force, np.zeros(3), force / area, area, 0.0, 0.0), DT)
        if machine.outcome:
            break
    assert machine.outcome == "done"


def test_only_what_gets_no_better_counts():
    def told(errors):
        guard = ErrorWatchdog()
        for error in errors:
            outcome = guard.update(error, 0.1)
            if outcome:
                return outcome
        return None

    def spans(*means):
        return np.repeat(means, 5)

    wave = np.tile([0.2, -0.2, 0.2, -0.2, 0.0], 3)
    assert told(spans(0.2, 0.2, 0.2)) == "steady_miss"
    assert told(spans(-0.2, -0.19, -0.3)) == "steady_miss"
    assert told(spans(0.2, 0.2)) is None
    assert told(spans(0.09, 0.09, 0.09, 0.09)) is None
    assert told(spans(0.8, 0.5, 0.3, 0.2, 0.15, 0.12)) is None
    assert told(spans(0.2, -0.2, 0.2, -0.2, 0.2)) is None
    assert told(wave) == "oscillation"
    assert told(wave[:10]) is None
    assert told(np.concatenate([wave[:5], 0.8 * wave[5:10], 0.6 * wave[10:]])) is None
    assert told(0.3 * wave) is None


def test_a_contact_at_the_border_is_centred_or_left():
    for selection, outcome in ((TRACK, "done"), (PRESS, "at_border")):
        world = world_of("pen", x=-0.037)
        machine = TouchPhases(TactileServo(None, selection), OPTIONS)
        play(world, machine)
        assert machine.outcome == outcome


def test_two_contacts_that_swap_are_left():
    one, other = ball(0.006, -0.02), ball(0.006, 0.02)
    world = replace(world_of("pen"), height=one)

    def swap(cycle, world, machine):
        lift = 2e-4 * np.sign(np.sin(cycle / 12))
        world.height = lambda x, y: np.minimum(one(x, y) + lift, other(x, y) - lift)

    machine = TouchPhases(TactileServo(), OPTIONS)
    play(world, machine, swap)
    assert machine.outcome == "unsteady_contact"


def test_a_threshold_at_the_noise_level_is_no_contact():
    world = World(emptiness, noise=30.0, threshold=15.0)
    machine = TouchPhases(TactileServo(), replace(OPTIONS, touch_pressure=20.0))
    play(world, machine)
    assert machine.outcome in ("unsteady_contact", "no_contact", "contact_lost")
    assert world.place[2] < 0.06


def test_dead_tactels_are_borne_until_too_many_are():
    world = world_of("box")
    world.dead = np.flatnonzero(np.random.default_rng(0).random(256) < 0.2)
    machine = TouchPhases(TactileServo(), OPTIONS)
    play(world, machine, trusted=0.8)
    assert machine.outcome == "done"
    machine = TouchPhases(TactileServo(), OPTIONS)

    def die(cycle, world, machine):
        if cycle == 300:
            world.dead = np.arange(256)

    world = world_of("box")
    peak, step, cycle = 0.0, None, 0
    while step is None or step.phase != "ended":
        die(cycle, world, machine)
        step = machine.step(world.features(), DT, trusted=0.0 if cycle >= 300 else 1.0)
        world.step(step.twist)
        peak, cycle = max(peak, world.force()), cycle + 1
    assert machine.outcome == "sensor_fault"
    assert world.force() == 0.0
    assert peak < 8.0


def test_features_that_are_not_finite_are_a_sensor_fault():
    world, machine = world_of("box"), TouchPhases(TactileServo(), OPTIONS)
    for _ in range(300):
        world.step(machine.step(world.features(), DT).twist)
    assert machine.phase == "task"
    step = machine.step(replace(world.features(), pressure=float("nan")), DT)
    assert step.phase == "back_off"
    assert step.outcome == "sensor_fault"
    assert machine.step(replace(world.features(), force=float("inf")), DT).twist[2] < 0


def test_finishing_backs_off():
    world, machine = world_of("box"), TouchPhases(TactileServo(), PhaseOptions())

    def enough(cycle, world, machine):
        if cycle == 300:
            machine.finish()

    assert play(world, machine, enough)[0][-2:] == ["back_off", "ended"]
    assert machine.outcome == "done"
    assert world.force() == 0.0


@settings(max_examples=30, deadline=None)
@given(data=st.data())
def test_whatever_the_pad_reads_the_machine_ends_in_bounded_time_and_never_pushes_far(data):
    """Random contacts, switched at random: the sum of all pushing stays within what is allowed."""
    options = PhaseOptions(task_seconds=1.0, hold_seconds=2.0, search_seconds=1.0)
    machine = TouchPhases(TactileServo(None, PRESS), options)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    share = data.draw(st.floats(0.0, 1.0))
    for _ in range(5000):
        pressure = rng.uniform(0, 3000) if rng.random() < share else 0.0
        features = NOTHING
        if pressure:
            centre = np.append(rng.uniform(-0.03, 0.03, 2), 0.0)
            features = ContactFeatures(pressure * 1e-3, centre, pressure, 1e-3, 0.3, 0.8)
        step = machine.step(features, DT)
        assert np.all(np.isfinite(step.twist))
        assert step.twist[2] <= machine.servo.options.press_speed
        if step.phase == "ended":
            return
    raise AssertionError("never ended")


def test_swings_that_grow_are_told_from_a_landing_and_from_noise():
    rng, time = np.random.default_rng(0), np.arange(0, 2, DT)
    for growth, noise, want in ((2.0, 3.0, True), (0.0, 3.0, True), (-4.0, 3.0, False)):
        swing = 600.0 * np.exp(growth * time) * np.sin(2 * np.pi * 8 * time)
        swing = 1000.0 + np.clip(swing, -1000, 1000) + rng.normal(0, noise, time.size)
        guard = OscillationDetector()
        assert any(guard.update(p / 1000.0, DT) for p in swing) == want
    guard = OscillationDetector()
    assert not any(guard.update(p / 1000.0, DT) for p in 1000.0 + rng.normal(0, 50, 5000))


def test_impossible_options_are_refused():
    with pytest.raises(InputError, match="searches"):
        PhaseOptions(searches=-1)
    with pytest.raises(InputError, match="pad_half_size"):
        PhaseOptions(pad_half_size=(0.04, -0.04))
