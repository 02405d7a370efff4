"""Zeroing, drift, and sensors that fail in the middle of a contact."""

from itertools import count

import numpy as np
import pytest
from numpy.typing import NDArray

from eyehand.data_synth.pad import SENSORS, run_bench
from eyehand.errors import DeviceError, InputError
from eyehand.tactile import ServoGoal, TactileArray, TactileServo, TouchPhases, calibrate
from eyehand.tactile.sensors import (
    ContactSensor,
    RestTracker,
    SensorInfo,
    SensorMonitor,
    TactileFrame,
)

from ..closed_loop import World
from ..synthetic_pad import SyntheticPad

PAD = SyntheticPad.draw()
CALIBRATION = calibrate(PAD.bench())
SMALL = calibrate(run_bench(SENSORS["good"].readout(16)))
INFO = SensorInfo("pad", TactileArray.flat(), 250.0)
DT = 0.004


class WorldSensor:
    """A sensor over a simulated world, with drift and faults."""

    def __init__(self, world: World) -> None:
        self.info, self.world = INFO, world
        self.time, self.fault = 0.0, ""
        self.drift = np.zeros(256)
        self._rng = np.random.default_rng(5)
        self._last: NDArray[np.uint16] = np.zeros(256, np.uint16)

    def read(self, timeout: float = 1.0) -> TactileFrame | None:
        """Return the pad's image of the world."""
        self.time += DT
        if self.fault == "unplugged":
            raise DeviceError("gone")
        if self.fault == "silent":
            return None
        if self.fault != "repeats":
            self._last = PAD.raw(self.world.pressures(), self._rng)
            self._last += np.rint(self.drift * self.time).astype(np.uint16)
        if self.fault == "broken":
            self._last[:100] = 0
        if self.fault == "short":
            self._last[:100] = 4095
        rows = self._last.reshape(16, 16)
        if self.fault == "dead row":
            rows[8] = 0
        if self.fault == "stuck row":
            rows[2] = 4095
        if self.fault == "runtime":
            raise RuntimeError("usb")
        return TactileFrame(self.time, self._last.copy())

    def close(self) -> None:
        """Do nothing."""


def box(height: float = 0.0) -> World:
    def surface(x, y):
        return np.where(np.maximum(abs(x), abs(y)) < 0.015, height, np.inf)

    return World(surface, position=np.array([0.0, 0.0, -0.005]))


@pytest.mark.parametrize(
    ("fault", "outcome"),
    [
        ("silent", "sensor_stopped"),
        ("unplugged", "sensor_stopped"),
        ("repeats", "sensor_repeats"),
        ("broken", "tactels_lost"),
        ("short", "tactels_lost"),
        ("dead row", "tactels_lost"),
        ("stuck row", "tactels_lost"),
        ("runtime", "sensor_stopped"),
        ("", "done"),
    ],
)
def test_sensor_that_fails_in_contact_ends_with_its_name_and_pad_backs_off(fault, outcome):
    sensor = WorldSensor(box())
    contact = ContactSensor(sensor, CALIBRATION)
    phases = TouchPhases(TactileServo(ServoGoal(pressure=800.0)))
    peak = 0.0
    for cycle in range(2000):
        if cycle == 500:
            assert phases.phase == "task"
            sensor.fault = fault
            if not fault:
                phases.finish()
        reading = contact.read(DT)
        step = phases.step(reading.features, DT, fault=reading.fault)
        sensor.world.step(step.twist)
        peak = max(peak, sensor.world.force())
        if step.phase == "ended":
            break
    assert (phases.phase, phases.outcome) == ("ended", outcome)
    assert sensor.world.force() == 0.0
    assert peak < 3.0


def test_drift_is_followed_at_rest_and_under_contact():
    sensor = WorldSensor(box())
    sensor.drift = np.random.default_rng(0).normal(0.1, 0.03, 256)  # 6 counts per minute
    contact = ContactSensor(sensor, CALIBRATION)
    plain = ContactSensor(sensor, CALIBRATION)
    sensor.world.position[2] = -0.01
    for _ in range(50_000):
        reading = contact.read(DT)
        assert not reading.features
    # After 200 s the readings are 20 counts above rest.
    assert np.median(contact.rest.offsets) == pytest.approx(20.0, abs=1.5)
    assert plain.read(DT).features
    sensor.world.position[2] = 0.0005
    before = contact.read(DT).features.force
    for _ in range(10_000):
        contact.read(DT)
    assert contact.read(DT).features.force == pytest.approx(before, rel=0.02)


def test_steady_contact_is_not_absorbed_by_the_tracking():
    sensor = WorldSensor(box())
    contact = ContactSensor(sensor, CALIBRATION)
    sensor.world.position[2] = 0.0003
    before = contact.read(DT).features.force
    for _ in range(15_000):
        contact.read(DT)
    assert contact.read(DT).features.force == pytest.approx(before, rel=0.02)


def test_zeroing_removes_an_offset_and_refuses_contact_that_moves():
    tracker, rng = RestTracker(CALIBRATION), np.random.default_rng(1)
    rests = np.array([PAD.raw(np.zeros(256), rng) for _ in range(60)]) + np.uint16(30)
    tracker.zero(rests)
    assert np.allclose(tracker.offsets, 30.0, atol=2.0)
    moving = rests + np.linspace(0, 60, 60).astype(np.uint16)[:, None]
    with pytest.raises(InputError, match="free of contact"):
        tracker.zero(moving)
    with pytest.raises(InputError, match="20 images"):
        tracker.zero(rests[:10])
    # Dead and full-scale readings keep their values, so that faults stay visible.
    raw = rests[0].copy()
    raw[:2] = 0, 4095
    assert tracker.correct(raw, DT)[:2].tolist() == [0, 4095]


def test_zeroing_refuses_a_steady_load():
    sensor = WorldSensor(box())
    contact = ContactSensor(sensor, CALIBRATION)
    sensor.world.position[2] = 0.0005
    before = contact.read(DT).features.force
    with pytest.raises(InputError, match=r"tactel \d+ reads .* at most 300; free the pad"):
        contact.zero()
    assert contact.read(DT).features.force == pytest.approx(before, rel=0.05)
    sensor.world.position[2] = -0.005
    contact.zero()
    sensor.world.position[2] = 0.0005
    assert contact.read(DT).features.force == pytest.approx(before, rel=0.05)


def test_zeroing_accepts_ten_minutes_of_drift_and_faulty_tactels():
    rng = np.random.default_rng(0)
    drift = 10.0 * SENSORS["harsh"].drift * (1.0 + 0.5 * rng.standard_normal(256))
    rests = np.array([PAD.raw(np.zeros(256), rng) for _ in range(50)])
    rests += np.maximum(drift, 0.0).astype(np.uint16)
    rests[:, 0] = 0
    tracker = RestTracker(CALIBRATION)
    tracker.zero(rests)
    assert np.median(tracker.offsets) == pytest.approx(60.0, abs=10.0)
    rests[:, 1] = 4095
    with pytest.raises(InputError, match=r"tactel 1 reads 4095 counts.* broken wire"):
        tracker.zero(rests)
    RestTracker(CALIBRATION.mark_dead_at_rest(rests)).zero(rests)


def test_hard_contact_at_full_scale_is_no_fault_but_a_stuck_row_is():
    monitor, rng = SensorMonitor(INFO, CALIBRATION), np.random.default_rng(0)
    distance = np.hypot(*(np.mgrid[:16, :16] - 8.0)).ravel()

    times = count()

    def fault(press: float, stuck: slice) -> str | None:
        raw = PAD.raw(np.zeros(256), rng) + 5000 * press * np.exp(-((distance / 2.0) ** 2))
        raw = np.clip(raw, 0, 4095).astype(np.uint16)
        raw[stuck] = 4095
        return monitor.check(TactileFrame(DT * next(times), raw), DT)

    none, row = slice(0), slice(32, 48)
    assert {fault(press, none) for press in (0, 0, *[2.0] * 30, 0, 0)} == {None}
    assert {fault(0.0, row) for _ in range(4)} == {None}
    assert fault(0.0, row) == "tactels_lost"


def test_flat_contact_within_one_image_is_no_fault():
    monitor = SensorMonitor(INFO, CALIBRATION)
    rng, faults = np.random.default_rng(0), set()
    for image in range(40):
        raw = PAD.raw(np.zeros(256), rng).astype(np.int64)
        if image >= 10:
            grid = raw.reshape(16, 16)
            grid[4:10, 4:10] += 120  # crosstalk, 3 %
            grid[5:9, 5:9] = 4095
        faults.add(monitor.check(TactileFrame(DT * image, raw.astype(np.uint16)), DT))
    assert faults == {None}


def test_one_dead_tactel_of_a_small_pad_is_no_fault_but_two_are():
    array = TactileArray.flat(4, 4)
    monitor = SensorMonitor(SensorInfo("small", array, 250.0), SMALL)
    times, rest = count(), SMALL.rest.astype(np.uint16)

    def fault(dead: int) -> str | None:
        number = next(times)
        raw = rest + np.uint16(number % 2)
        raw[:dead] = 0
        return monitor.check(TactileFrame(DT * number, raw), DT)

    assert {fault(1) for _ in range(20)} == {None}
    assert [fault(2) for _ in range(5)][-1] == "tactels_lost"


@pytest.mark.parametrize(("unit", "fault"), [(1.0, None), (1000.0, "sensor_stopped")])
def test_slow_control_loop_is_no_fault_of_the_sensor_but_times_in_ms_are(unit, fault):
    host, rng = count(0.0, 0.03), np.random.default_rng(0)
    monitor = SensorMonitor(INFO, CALIBRATION, lambda: next(host))
    frames = [TactileFrame(0.03 * unit * k, PAD.raw(np.zeros(256), rng)) for k in range(60)]
    assert [monitor.check(frame, DT) for frame in frames][-1] == fault


@pytest.mark.parametrize(("unit", "rate"), [(1000.0, 250.0), (1.0, 2500.0)])
def test_zeroing_refuses_times_that_do_not_fit_the_rate(unit, rate):
    sensor = WorldSensor(box())
    sensor.info = SensorInfo("pad", TactileArray.flat(), rate)
    read = sensor.read
    sensor.read = lambda timeout=1.0: (f := read()) and TactileFrame(unit * f.time, f.raw)
    with pytest.raises(InputError, match=r"pad took .* s by its own clock for 50 images"):
        ContactSensor(sensor, CALIBRATION).zero()
    contact = ContactSensor(sensor, CALIBRATION)
    faults = [contact.read(DT).fault for _ in range(25)]
    assert faults[0] is None
    assert faults[-1] == ("sensor_stopped" if unit > 1 else None)


def test_zeroing_a_silent_sensor_is_a_device_error():
    sensor = WorldSensor(box())
    sensor.fault = "silent"
    with pytest.raises(DeviceError, match="0 of 50 images"):
        ContactSensor(sensor, CALIBRATION).zero()


def test_image_of_another_array_and_calibration_of_another_converter_are_input_errors():
    class Short(WorldSensor):
        def read(self, timeout: float = 1.0) -> TactileFrame | None:
            """Leave out a tactel."""
            frame = super().read(timeout)
            return frame and TactileFrame(frame.time, frame.raw[1:])

    with pytest.raises(InputError, match="raw must be 256 uint16, got list"):
        TactileFrame(0.0, [100] * 256).check(INFO)  # pyright: ignore[reportArgumentType] - the invalid argument under test
    with pytest.raises(InputError, match="raw must be 256 uint16"):
        ContactSensor(Short(box()), CALIBRATION).read(DT)
    sensor = WorldSensor(box())
    sensor.info = SensorInfo("pad", TactileArray.flat(), 250.0, 8)
    with pytest.raises(InputError, match="raw must be 0 to 255 at 8 bits, got "):
        TactileFrame(0.0, np.full(256, 300, np.uint16)).check(sensor.info)
    sensor.info = SensorInfo("pad", TactileArray.flat(), 250.0, 16)
    with pytest.raises(InputError, match="pad has 16 bits, and its calibration 12"):
        ContactSensor(sensor, CALIBRATION)


def test_shear_becomes_side_force():
    class Shearing(WorldSensor):
        def read(self, timeout: float = 1.0) -> TactileFrame | None:
            """Add shear."""
            frame = super().read(timeout)
            shear = np.tile([200.0, -100.0], (256, 1))
            return frame and TactileFrame(frame.time, frame.raw, shear)

    sensor = Shearing(box())
    with pytest.raises(InputError, match=r"shear must be None because SensorInfo\.shear is False"):
        ContactSensor(sensor, CALIBRATION).read(DT)
    sensor.info = SensorInfo("pad", TactileArray.flat(), 250.0, shear=True)
    force = ContactSensor(sensor, CALIBRATION).read(DT).side_force
    assert force == pytest.approx(np.array([200.0, -100.0]) * 256 * 0.005**2)
