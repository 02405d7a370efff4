"""The touch phases: approach to contact, task, and retreat with an outcome in every case."""

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
from eyehand.tactile.phase_step import Outcome, SensorFault
from eyehand.tactile.phases import TouchPhases
from eyehand.tactile.selection import PRESS, TRACK
from eyehand.tactile.servo import ServoGoal, TactileServo
from eyehand.tactile.servo_options import ServoOptions

from .closed_loop import DT, OBJECTS, World, ball

NO_CONTACT = ContactFeatures(0.0, np.zeros(3), 0.0, 0.0, 0.0, 0.0)
OPTIONS = PhaseOptions(task_seconds=3.0)


def make_world(name: str, x: float = 0.0) -> World:
    height, stiffness = OBJECTS[name]
    return World(height, stiffness, position=np.array([x, 0, -0.005]), noise=3.0, threshold=15.0)


def no_surface(x, y):
    return np.full_like(x, np.inf)


def run_phases(world, machine, hook=None, seconds=20.0, **kwargs):
    """Run until the machine has ended. Return the phases in order and the peak force, N."""
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
def test_task_runs_for_its_time_and_pad_retreats(name):
    world, machine = make_world(name), TouchPhases(TactileServo(), OPTIONS)
    phases, peak = run_phases(world, machine)
    assert phases == ["hold", "task", "back_off", "ended"]
    assert machine.outcome == "done"
    assert world.force() == 0.0
    assert peak < 8.0


def test_peak_above_its_limit_is_named_and_the_pad_retreats():
    options = replace(OPTIONS, peak_limit=1.02)
    world, machine = make_world("ball"), TouchPhases(TactileServo(), options)
    phases, _ = run_phases(world, machine)
    assert phases == ["hold", "task", "back_off", "ended"]
    assert machine.outcome == "overshoot"
    assert world.force() == 0.0


def test_approach_that_is_too_fast_for_the_delay_is_refused():
    slow_sensor = TactileServo(options=ServoOptions(latency=6, arm_lag=0.035))
    TouchPhases(slow_sensor, PhaseOptions(approach_speed=0.13))
    with pytest.raises(InputError, match=r"<= 0.136 m/s, because .* after 59 ms, got 0.2"):
        TouchPhases(slow_sensor, PhaseOptions(approach_speed=0.2))


def test_pad_descends_only_after_caller_reached_work_area():
    machine = TouchPhases(TactileServo(), OPTIONS)
    for _ in range(10):
        step = machine.step(NO_CONTACT, DT, pose_error=(0.1, 0.0))
        assert step.phase == "move"
        assert not step.twist.any()
    step = machine.step(NO_CONTACT, DT, pose_error=(0.001, 0.001))
    assert step.phase == "hold"
    assert step.twist[2] == OPTIONS.approach_speed


def test_move_phase_that_times_out_ends_as_unreachable(monkeypatch):
    monkeypatch.setattr(phases_module, "MAX_MOVE_SECONDS", 0.1)
    machine = TouchPhases(TactileServo(), OPTIONS)
    steps = [machine.step(NO_CONTACT, DT, pose_error=(0.1, 0.0)) for _ in range(40)]
    assert steps[-1].outcome == "unreachable"
    assert steps[-1].phase == "ended"


def test_finish_while_arm_moves_ends_without_motion():
    machine = TouchPhases(TactileServo(), OPTIONS)
    machine.step(NO_CONTACT, DT, pose_error=(0.1, 0.0))
    machine.finish()
    step = machine.step(NO_CONTACT, DT, pose_error=(0.1, 0.0))
    assert (step.phase, step.outcome) == ("ended", "done")
    assert not step.twist.any()


@pytest.mark.parametrize("phase", ["move", "hold", "task", "back_off"])
@pytest.mark.parametrize("fault", [None, "tactels_lost"])
@pytest.mark.parametrize(
    "cycle",
    [
        {"dt": 0.0},
        {"dt": -1.0},
        {"dt": math.nan},
        {"dt": DT, "external": np.array([0.0, 0.0, math.nan, 0.0, 0.0, 0.0])},
        {"dt": DT, "external": np.array([math.inf, -math.inf, 0.0, 0.0, 0.0, 0.0])},
    ],
)
def test_invalid_cycle_is_rejected_in_every_phase(phase, fault, cycle):
    machine = TouchPhases(TactileServo(), OPTIONS)
    machine.phase = phase
    with pytest.raises(InputError, match="a cycle needs dt > 0 s"):
        machine.step(NO_CONTACT, fault=fault, **cycle)


def test_approach_without_object_ends_as_no_contact():
    world, machine = World(no_surface, noise=3.0, threshold=15.0), TouchPhases(TactileServo())
    run_phases(world, machine)
    assert machine.outcome == "no_contact"
    assert world.position[2] < 0.06


def test_hold_with_zero_approach_speed_waits_for_contact():
    world = make_world("box")
    machine = TouchPhases(TactileServo(), replace(OPTIONS, approach_speed=0.0))

    def approach(cycle, world, machine):
        if machine.phase in ("move", "hold"):
            assert not world.velocity.any()
            world.position = world.position + np.array([0.0, 0.0, 2e-5])

    assert run_phases(world, machine, approach)[0][:2] == ["hold", "task"]


def test_search_regains_contact_after_slip():
    world, machine = make_world("pen"), TouchPhases(TactileServo(), OPTIONS)

    def slip(cycle, world, machine):
        if cycle == 400:
            world.position = world.position - np.array([0.012, 0.0, 0.004])

    phases, _ = run_phases(world, machine, slip)
    assert phases == ["hold", "task", "search", "task", "back_off", "ended"]
    assert machine.outcome == "done"


def test_search_for_lost_contact_is_bounded():
    world, machine = make_world("box"), TouchPhases(TactileServo(), PhaseOptions())

    def vanish(cycle, world, machine):
        if cycle == 400:
            world.height = no_surface

    phases, _ = run_phases(world, machine, vanish)
    assert phases[-3:] == ["search", "back_off", "ended"]
    assert machine.outcome == "contact_lost"


def test_fast_approaching_object_ends_as_overload():
    world, machine = make_world("box"), TouchPhases(TactileServo(), PhaseOptions())

    def press(cycle, world, machine):
        if cycle > 300 and machine.outcome is None:
            world.position = world.position + np.array([0.0, 0.0, 3e-4])

    run_phases(world, machine, press)
    assert machine.outcome == "overload"
    assert world.force() == 0.0


def test_saturated_tactels_end_as_overload():
    machine = TouchPhases(TactileServo(), OPTIONS)
    features = ContactFeatures(1.0, np.zeros(3), 900.0, 1e-3, 0.0, 0.0, tactels=40, saturated=12)
    steps = [machine.step(features, DT) for _ in range(3)]
    assert steps[-1].outcome == "overload"
    assert steps[-1].twist[2] < 0


@pytest.mark.parametrize(("name", "share"), [("box", 1.5), ("box", 2.0), ("pen", 4.0)])
def test_unstable_gain_ends_with_pad_retracted(name, share):
    options = ServoOptions(stability_share=share, press_gain=1e3)
    # A calm landing grows into an oscillation in 0.3 s, and seven losses of contact end the touch.
    longer = replace(OPTIONS, task_seconds=4.0)
    world, machine = make_world(name), TouchPhases(TactileServo(None, PRESS, options), longer)
    _, peak = run_phases(world, machine)
    assert machine.outcome in ("oscillation", "contact_lost")
    assert world.force() == 0.0
    assert peak < 15.0


def test_yielding_object_ends_as_no_resistance():
    world, machine = make_world("box"), TouchPhases(TactileServo(None, PRESS), PhaseOptions())
    travel, height = [0.0], world.height

    def yield_to_pressure(cycle, world, machine):
        pressure = float(world.pressures().max())
        travel[0] += max(0.0, pressure - 100.0) * 5e-7
        world.height = lambda x, y: height(x, y) + travel[0]

    run_phases(world, machine, yield_to_pressure)
    assert machine.outcome == "no_resistance"
    assert world.force() == 0.0


@pytest.mark.parametrize(("speed", "sign"), [(0.016, 1.0), (-0.013, -1.0)])
def test_persistent_pressure_error_ends_as_steady_miss(speed, sign, monkeypatch):
    """The object moves faster than the limited integral term can compensate."""
    monkeypatch.setattr(phases_module, "NEAR_GOAL", 0.0)
    world, pressures = make_world("box"), []
    options = ServoOptions(known_stiffness=1e6)
    machine = TouchPhases(TactileServo(None, PRESS, options), PhaseOptions())

    def approach(cycle, world, machine):
        if machine.phase == "task":
            pressures.append(machine.servo.filtered[0])
            share = min(len(pressures) / 250, 1.0)
            world.position = world.position + np.array([0.0, 0.0, share * speed * DT])

    run_phases(world, machine, approach)
    assert machine.outcome == "steady_miss"
    assert world.force() == 0.0
    # The pressure had settled at this error: it is neither a landing nor a divergence.
    late = np.array(pressures[-125:]) / 1000.0 - 1.0
    assert np.all(sign * late > 0.1)
    assert late.std() < 0.05


def test_lasting_pressure_swing_ends_as_oscillation():
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


def test_intermittent_contact_ends_as_unsteady_contact():
    machine = TouchPhases(TactileServo(None, PRESS), OPTIONS)
    contact = ContactFeatures(1e-3, np.zeros(3), 1200.0, 4e-5, 0.0, 0.0)
    for cycle in range(500):
        machine.step(NO_CONTACT if cycle % 20 > 14 else contact, DT)
        if machine.outcome:
            break
    assert machine.outcome == "unsteady_contact"


def test_bouncing_contact_ends_as_oscillation():
    """A bouncing pad: the pressure falls gradually before the contact is lost."""
    machine = TouchPhases(TactileServo(None, PRESS), OPTIONS)
    for cycle in range(500):
        pressure = 700.0 * max(0.0, 0.9 + math.sin(2 * math.pi * 5 * cycle * DT))
        machine.step(ContactFeatures(1e-3 * pressure, np.zeros(3), pressure, 1e-3, 0.0, 0.0), DT)
        if machine.outcome:
            break
    assert machine.outcome == "oscillation"


def test_pressure_error_during_external_motion_is_no_steady_miss():
    for outer, outcome in ((0.0, "steady_miss"), (0.02, "done")):
        machine = TouchPhases(TactileServo(None, PRESS), OPTIONS)
        features = ContactFeatures(1.3, np.zeros(3), 1300.0, 1e-3, 0.0, 0.0)
        while machine.outcome is None:
            machine.step(features, DT, external=np.array([outer, 0, 0, 0, 0, 0]))
        assert machine.outcome == outcome


def test_force_goal_is_monitored_by_the_force():
    """The pressure of a narrow imprint is far above the force divided by the reference area."""
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


def test_error_watchdog_reports_only_errors_that_do_not_improve():
    def watchdog_outcome(errors):
        watchdog = ErrorWatchdog()
        for error in errors:
            outcome = watchdog.update(error, 0.1)
            if outcome:
                return outcome
        return None

    def spans(*means):
        return np.repeat(means, 5)

    wave = np.tile([0.2, -0.2, 0.2, -0.2, 0.0], 3)
    assert watchdog_outcome(spans(0.2, 0.2, 0.2)) == "steady_miss"
    assert watchdog_outcome(spans(-0.2, -0.19, -0.3)) == "steady_miss"
    assert watchdog_outcome(spans(0.2, 0.2)) is None
    assert watchdog_outcome(spans(0.09, 0.09, 0.09, 0.09)) is None
    assert watchdog_outcome(spans(0.8, 0.5, 0.3, 0.2, 0.15, 0.12)) is None
    assert watchdog_outcome(spans(0.2, -0.2, 0.2, -0.2, 0.2)) is None
    assert watchdog_outcome(wave) == "oscillation"
    assert watchdog_outcome(wave[:10]) is None
    assert watchdog_outcome(np.concatenate([wave[:5], 0.8 * wave[5:10], 0.6 * wave[10:]])) is None
    assert watchdog_outcome(0.3 * wave) is None


def test_contact_at_border_is_centred_or_released():
    for selection, outcome in ((TRACK, "done"), (PRESS, "at_border")):
        world = make_world("pen", x=-0.037)
        machine = TouchPhases(TactileServo(None, selection), OPTIONS)
        run_phases(world, machine)
        assert machine.outcome == outcome


def test_alternating_contacts_end_as_unsteady_contact():
    one, other = ball(0.006, -0.02), ball(0.006, 0.02)
    world = replace(make_world("pen"), height=one)

    def swap(cycle, world, machine):
        lift = 2e-4 * np.sign(np.sin(cycle / 12))
        world.height = lambda x, y: np.minimum(one(x, y) + lift, other(x, y) - lift)

    machine = TouchPhases(TactileServo(), OPTIONS)
    run_phases(world, machine, swap)
    assert machine.outcome == "unsteady_contact"


def test_threshold_at_noise_level_does_not_start_task():
    world = World(no_surface, noise=30.0, threshold=15.0)
    machine = TouchPhases(TactileServo(), replace(OPTIONS, touch_pressure=20.0))
    run_phases(world, machine)
    assert machine.outcome in ("unsteady_contact", "no_contact", "contact_lost")
    assert world.position[2] < 0.06


def test_task_is_done_with_a_fifth_of_the_tactels_dead():
    world = make_world("box")
    world.dead = np.flatnonzero(np.random.default_rng(0).random(256) < 0.2)
    machine = TouchPhases(TactileServo(), OPTIONS)
    run_phases(world, machine)
    assert machine.outcome == "done"


@pytest.mark.parametrize("fault", get_args(SensorFault))
def test_sensor_fault_in_the_task_has_its_name_and_pad_backs_off(fault):
    world, machine = make_world("box"), TouchPhases(TactileServo(), OPTIONS)
    peak, step, cycle = 0.0, None, 0
    while step is None or step.phase != "ended":
        if cycle == 300:
            world.dead = np.arange(256)
        step = machine.step(world.features(), DT, fault=fault if cycle >= 300 else None)
        world.step(step.twist)
        peak, cycle = max(peak, world.force()), cycle + 1
    assert machine.outcome == fault
    assert world.force() == 0.0
    assert peak < 8.0


def test_non_finite_features_end_as_sensor_fault():
    world, machine = make_world("box"), TouchPhases(TactileServo(), OPTIONS)
    for _ in range(300):
        world.step(machine.step(world.features(), DT).twist)
    assert machine.phase == "task"
    step = machine.step(replace(world.features(), pressure=float("nan")), DT)
    assert step.phase == "back_off"
    assert step.outcome == "sensor_fault"
    assert machine.step(replace(world.features(), force=float("inf")), DT).twist[2] < 0


def test_finish_starts_retreat():
    world, machine = make_world("box"), TouchPhases(TactileServo(), PhaseOptions())

    def finish_at_cycle_300(cycle, world, machine):
        if cycle == 300:
            machine.finish()

    assert run_phases(world, machine, finish_at_cycle_300)[0][-2:] == ["back_off", "ended"]
    assert machine.outcome == "done"
    assert world.force() == 0.0


@settings(max_examples=30, deadline=None)
@given(data=st.data())
def test_machine_ends_in_bounded_time_for_random_contacts(data):
    """Contacts appear at random. Every commanded press speed stays within its limit."""
    options = PhaseOptions(task_seconds=1.0, hold_seconds=2.0, search_seconds=1.0)
    machine = TouchPhases(TactileServo(None, PRESS), options)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    share = data.draw(st.floats(0.0, 1.0))
    for _ in range(5000):
        pressure = rng.uniform(0, 3000) if rng.random() < share else 0.0
        features = NO_CONTACT
        if pressure:
            centre = np.append(rng.uniform(-0.03, 0.03, 2), 0.0)
            features = ContactFeatures(pressure * 1e-3, centre, pressure, 1e-3, 0.3, 0.8)
        step = machine.step(features, DT)
        assert np.all(np.isfinite(step.twist))
        assert step.twist[2] <= machine.servo.options.press_speed
        if step.phase == "ended":
            return
    raise AssertionError("never ended")


def test_oscillation_detector_ignores_landing_and_noise():
    rng, time = np.random.default_rng(0), np.arange(0, 2, DT)
    for growth, noise, expected in ((2.0, 3.0, True), (0.0, 3.0, True), (-4.0, 3.0, False)):
        swing = 600.0 * np.exp(growth * time) * np.sin(2 * np.pi * 8 * time)
        swing = 1000.0 + np.clip(swing, -1000, 1000) + rng.normal(0, noise, time.size)
        detector = OscillationDetector()
        assert any(detector.update(p / 1000.0, DT) for p in swing) == expected
    detector = OscillationDetector()
    assert not any(detector.update(p / 1000.0, DT) for p in 1000.0 + rng.normal(0, 50, 5000))


def test_phase_options_reject_invalid_values():
    with pytest.raises(InputError, match="searches"):
        PhaseOptions(searches=-1)
    with pytest.raises(InputError, match="pad_half_size"):
        PhaseOptions(pad_half_size=(0.04, -0.04))
