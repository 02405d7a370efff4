"""Lag, hysteresis, creep, gains, drift and wait of a sensor: closed forms and NumPy."""

from dataclasses import replace

import numpy as np
import pytest

from eyehand.data_synth.pad import SENSORS, SensorModel
from eyehand.data_synth.pad.sensor_memory import (
    CREEP_TIME_S,
    RECOVERY_TIME_S,
    SensorMemory,
    remember,
)
from eyehand.errors import InputError

LOAD = np.full(4, 1000.0)
REST = np.zeros(4)


def memory(**changes: float) -> SensorMemory:
    """Return the memory of a sensor of 4 tactels without noise, apart from these properties."""
    model = SensorModel(**{"noise": 0.0, **changes})
    return SensorMemory(model, model.readout(4), seed=3)


def test_good_sensor_remembers_nothing() -> None:
    model = SENSORS["good"]
    readout = model.readout(4)
    noise = [np.random.default_rng(0), np.random.default_rng(0)]
    sensor = SensorMemory(model, readout)
    for time in range(5):
        read = sensor.read(float(time), LOAD * time, noise[0])
        assert (read == readout.raw(LOAD * time, noise[1])).all()


def test_lag_is_exponential() -> None:
    sensor = memory(lag=0.025)
    sensor.sense(0.0, REST)
    for time in np.arange(1, 25) * 1e-3:
        sensor.sense(time, LOAD)
    assert sensor.sense(0.025, LOAD) == pytest.approx(1000 * (1 - np.exp(-1.0)))


def test_unloading_reads_share_of_previous_load() -> None:
    sensor = memory(hysteresis=0.1)
    sensor.sense(0.0, REST)
    for time, load in ((0.01, 300.0), (0.02, 1000.0)):
        assert sensor.sense(time, np.full(4, load)) == pytest.approx(load)
    now = sensor.sense(0.021, np.full(4, 400.0))
    left = 400 + 0.1 * 600 * np.exp(-0.001 / RECOVERY_TIME_S)
    assert now == pytest.approx(left)
    assert sensor.sense(0.022, REST) == pytest.approx(100.0, rel=2e-3)
    assert sensor.sense(60.0, REST) == pytest.approx(0.0, abs=1e-6)


def test_creep_rises_to_its_share() -> None:
    sensor = memory(creep=0.05)
    sensor.sense(0.0, REST)
    sensor.sense(1e-9, LOAD)
    for time in (1.0, 2.0, 7.0, 30.0):
        expected = 1000 * (1 + 0.05 * (1 - np.exp(-time / CREEP_TIME_S)))
        assert sensor.sense(time, LOAD) == pytest.approx(expected)


def test_gain_scatters_by_spread() -> None:
    model = SensorModel(noise=0.0, gain_spread=0.1)
    gains = SensorMemory(model, model.readout(4096)).sense(0.0, np.ones(4096))
    assert np.log(gains).std() == pytest.approx(0.1, rel=0.05)
    assert np.log(gains).mean() == pytest.approx(0.0, abs=0.005)


def test_drift_is_linear_in_time() -> None:
    model = SensorModel(noise=0.0, drift=60.0)
    sensor, rng = SensorMemory(model, model.readout(400)), np.random.default_rng(0)
    reads = [sensor.read(t, np.zeros(400), rng).astype(float) for t in (0.0, 10.0, 20.0)]
    assert (reads[1] - reads[0]).mean() == pytest.approx(10.0, abs=1.0)
    assert (reads[2] - reads[0]) == pytest.approx(2 * (reads[1] - reads[0]), abs=2.0)


def test_image_arrives_after_the_wait() -> None:
    model = SensorModel(noise=0.0, wait=0.008)
    readout = model.readout(4)
    sensor, rng = SensorMemory(model, readout), np.random.default_rng(0)
    loads = [np.full(4, 100.0 * k) for k in range(8)]
    reads = [sensor.read(0.004 * k, load, rng) for k, load in enumerate(loads)]
    for k in range(2, 8):
        assert (reads[k] == readout.raw(loads[k - 2], None)).all()
    assert (reads[1] == readout.raw(loads[0], None)).all()


def test_common_noise_moves_all_tactels_together() -> None:
    readout = SensorModel(noise=0.0, common_noise=20.0).readout(64)
    rng = np.random.default_rng(0)
    images = np.array([readout.raw(np.full(64, 800.0), rng) for _ in range(300)], float)
    assert images.mean(axis=1).std() == pytest.approx(20.0, rel=0.15)
    assert (images - images.mean(axis=1)[:, None]).std(axis=0).max() < 1.0


def test_kernel_equals_numpy() -> None:
    rng = np.random.default_rng(1)
    gains, states = rng.uniform(0.8, 1.2, 50), np.zeros((3, 50))
    kept, shares = (0.7, 0.95, 0.99), (0.1, 0.15)
    lagged, load, crept, sensed = np.zeros(50), np.zeros(50), np.zeros(50), np.zeros(50)
    for _ in range(30):
        pressures = rng.normal(500, 600, 50)
        remember(pressures, gains, kept, shares, states, sensed)
        pressure = np.maximum(pressures, 0)
        lagged = pressure + (lagged - pressure) * kept[0]
        load = np.maximum(lagged + (load - lagged) * kept[1], lagged)
        felt = lagged + shares[0] * (load - lagged)
        crept = felt + (crept - felt) * kept[2]
        assert sensed == pytest.approx(gains * (felt + shares[1] * crept), rel=1e-12)


def test_faults_are_shares_of_tactels() -> None:
    readout = replace(SENSORS["good"], dead=0.1, saturated=0.05).readout(200, seed=4)
    assert (len(readout.dead), len(readout.saturated)) == (20, 10)
    assert not set(readout.dead) & set(readout.saturated)


def test_bad_values_are_rejected() -> None:
    with pytest.raises(InputError, match="wait must be finite and >= 0, got -1"):
        SensorModel(wait=-1.0)
    with pytest.raises(InputError, match="must be <= 1, got"):
        SensorModel(dead=0.8, saturated=0.4)
