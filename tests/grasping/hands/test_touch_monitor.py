"""The monitor of a hand's touch: lost tactels and repeated readings, and none of them."""

from dataclasses import replace

import numpy as np
import pytest

from eyehand.grasping import HandReading, JawReading
from eyehand.grasping.hands.touch_monitor import REPEAT_SECONDS, TouchMonitor
from eyehand.tactile import TactileArray, TactileImage

DT = 0.004
PAD = TactileArray.flat(4, 3, 0.005)
CYCLES = int(3 * REPEAT_SECONDS / DT)


def reading(cycle: int = 0, force: float = 2.0, moving: bool = True) -> HandReading:
    pressures = np.full(12, 100.0 * force)
    angles = np.full(3, 0.1 + (1e-4 * cycle if moving else 0.0))
    forces = np.array([force, 0.0])
    return HandReading(np.zeros(2), np.ones(2), angles, forces, (TactileImage(pressures, PAD),))


def faults(readings) -> set[str]:
    monitor = TouchMonitor()
    return {monitor.check(one, DT) for one in readings}


def test_changing_touch_is_no_fault():
    assert faults(reading(k, 2.0 + 1e-9 * k) for k in range(CYCLES)) == {""}


def test_repeated_touch_of_a_moving_hand_is_a_fault_after_a_while():
    monitor = TouchMonitor()
    found = [monitor.check(reading(k), DT) for k in range(CYCLES)]
    first = next(k for k, fault in enumerate(found) if fault)
    assert first * DT == pytest.approx(REPEAT_SECONDS, abs=2 * DT)
    assert "has not changed" in found[first]


@pytest.mark.parametrize("changes", [{"force": 0.0}, {"moving": False}])
def test_equal_readings_without_touch_or_motion_are_no_fault(changes):
    assert faults(reading(k, **changes) for k in range(CYCLES)) == {""}


@pytest.mark.parametrize("rate", [2.0, 20.0, 1000.0])
def test_equal_readings_with_new_times_are_no_fault(rate):
    """A switch reads the same while it is pressed, and a slow sensor repeats itself."""
    count = int(2.0 / DT)
    times = [int(k * DT * rate) / rate for k in range(count)]
    assert faults(replace(reading(k), touch_time=times[k]) for k in range(count)) == {""}


@pytest.mark.parametrize(("rate", "limit"), [(2.0, 2.5), (100.0, REPEAT_SECONDS)])
def test_time_that_stops_is_a_fault_after_some_periods(rate, limit):
    monitor = TouchMonitor()
    times = [min(int(k * DT * rate) / rate, 1.0) for k in range(int(5.0 / DT))]
    found = [monitor.check(replace(reading(moving=False), touch_time=t), DT) for t in times]
    first = next(k for k, fault in enumerate(found) if fault)
    assert first * DT == pytest.approx(1.0 + limit, abs=2 * DT)
    assert found[first] == f"no measurement of touch for {limit:g} s"


def first_fault(arrivals: list[float], seconds: float) -> float:
    """Return the time of the first fault, s, if measurements arrive at these times; inf if none."""
    monitor = TouchMonitor()
    for k in range(int(seconds / DT)):
        newest = max((time for time in arrivals if time <= k * DT), default=0.0)
        if monitor.check(replace(reading(moving=False), touch_time=newest), DT):
            return k * DT
    return np.inf


@pytest.mark.parametrize("late", [[0.08], [0.08, 0.09, 0.07]])
def test_late_measurements_before_a_stop_do_not_delay_its_fault(late):
    """The last gaps are eight times the period; five of them would be 0.35 s or more."""
    arrivals = list(np.cumsum([0.01] * 50 + late))
    assert first_fault(arrivals, 2.0) == pytest.approx(arrivals[-1] + REPEAT_SECONDS, abs=3 * DT)


@pytest.mark.parametrize("burst", [1, 3])
def test_burst_of_a_slow_sensor_is_no_fault(burst):
    """A driver that was held up delivers several measurements at once."""
    arrivals = list(np.cumsum([0.5] * 9 + [0.01] * burst + [0.5] * 3))
    assert first_fault(arrivals, arrivals[-1] + 0.5) == np.inf


def test_slower_rate_becomes_the_period_after_some_measurements():
    """Four gaps at the new rate are within the old limit of 0.1 s; then the period is the new."""
    arrivals = list(np.cumsum([0.01] * 20 + [0.06] * 6))
    assert first_fault(arrivals, 3.0) == pytest.approx(arrivals[-1] + 0.3, abs=3 * DT)


@pytest.mark.parametrize("one", [reading(), JawReading(0.05)])
def test_a_fault_that_the_driver_reports_is_one(one):
    assert faults([replace(one, touch_fault="sensor_stopped")]) == {"sensor_stopped"}


def test_a_missing_pad_force_is_a_fault():
    missing = replace(reading(), forces=np.array([np.nan, 0.0]))
    assert faults([missing]) == {"1 of 2 pad forces are missing"}


def test_jaws_without_touch_are_never_wrong():
    assert faults(JawReading(0.05 - 1e-4 * k) for k in range(CYCLES)) == {""}
