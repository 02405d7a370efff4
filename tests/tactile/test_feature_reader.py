"""The feature reader: from raw readings to contact features."""

import time

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile import (
    BenchRun,
    ContactFeatures,
    FeatureOptions,
    FeatureReader,
    FoamMemory,
    TactileArray,
    calibrate,
    contact_features,
)

from .synthetic_pad import SyntheticPad

ARRAY = TactileArray.flat()
PAD = SyntheticPad.draw(seed=1)
CALIBRATION = calibrate(PAD.bench())
MAX_READ_US = 40.0
"""Longest accepted time of one reading. A quiet machine needs 6 µs; a busy one needs more."""


def imprint(x: float = 0.0, y: float = 0.0, angle: float = 0.0, long: float = 0.015, peak=4000.0):
    along = np.array([np.cos(angle), np.sin(angle)])
    gaps = ARRAY.positions[:, :2] - [x, y]
    u, v = gaps @ along, gaps @ [-along[1], along[0]]
    return peak * np.exp(-0.5 * ((u / long) ** 2 + (v / 0.003) ** 2))


def test_read_equals_calibration_followed_by_contact_features():
    raw = PAD.raw(imprint(0.003, -0.004, 0.7), np.random.default_rng(0))
    found = FeatureReader(CALIBRATION, ARRAY).read(raw)
    separate = contact_features(CALIBRATION.to_image(raw, ARRAY), CALIBRATION.threshold(4.0))
    assert found.force == pytest.approx(separate.force)
    assert np.allclose(found.centre, separate.centre)
    assert found.orientation == pytest.approx(separate.orientation)
    assert found.orientation == pytest.approx(0.7, abs=0.01)
    assert found.centre[:2] == pytest.approx([0.003, -0.004], abs=2e-4)


def test_noise_is_not_detected_as_contact():
    reader, rng = FeatureReader(CALIBRATION, ARRAY), np.random.default_rng(0)
    assert not any(reader.read(PAD.raw(np.zeros(256), rng)) for _ in range(2000))


def test_round_contact_has_low_orientation_confidence():
    reader, rng = FeatureReader(CALIBRATION, ARRAY), np.random.default_rng(0)
    for x, y in rng.uniform(-0.02, 0.02, (50, 2)):
        assert reader.read(PAD.raw(imprint(x, y, long=0.003), rng)).confidence < 0.12


def test_dead_tactel_in_contact_is_interpolated_and_counted():
    run = PAD.bench()
    raw = run.raw.copy()
    raw[:, 136] = 120
    reader = FeatureReader(calibrate(BenchRun(run.pressures, raw)), ARRAY)
    pressed = PAD.raw(imprint(long=0.008))
    reference = FeatureReader(CALIBRATION, ARRAY).read(pressed)
    pressed[136] = 120
    found = reader.read(pressed)
    assert found.interpolated == 1
    assert reference.interpolated == 0
    assert np.linalg.norm(found.centre - reference.centre) < 5e-4
    assert found.force == pytest.approx(reference.force, rel=0.1)


def test_saturated_tactels_in_a_contact_are_counted():
    found = FeatureReader(CALIBRATION, ARRAY).read(PAD.raw(imprint(peak=20e3)))
    assert found.saturated > 0
    assert FeatureReader(CALIBRATION, ARRAY).read(PAD.raw(imprint())).saturated == 0


def test_reader_keeps_tracked_contact_until_reset():
    reader = FeatureReader(CALIBRATION, ARRAY, FeatureOptions(hysteresis=0.5))
    left, right = imprint(-0.02, long=0.005), imprint(0.02, long=0.006)
    assert reader.read(PAD.raw(left)).centre[0] < -0.015
    assert reader.read(PAD.raw(left + right)).centre[0] < -0.015
    reader.reset()
    assert reader.read(PAD.raw(left + right)).centre[0] > 0.015
    reader.read(PAD.raw(np.zeros(256)))
    assert reader.read(PAD.raw(left)).centre[0] < -0.015
    assert reader.image.pressures.max() > 2000.0


def test_returned_features_are_not_overwritten_by_next_read():
    reader = FeatureReader(CALIBRATION, ARRAY)
    first = reader.read(PAD.raw(imprint(0.01)))
    centre = first.centre.copy()
    reader.read(PAD.raw(imprint(-0.01)))
    assert np.array_equal(first.centre, centre)


def test_reader_supports_fingertip_array():
    pad, tip = SyntheticPad.draw(12), TactileArray.fingertip()
    reader = FeatureReader(calibrate(pad.bench()), tip, FeatureOptions(min_tactels=1))
    pressures = np.zeros(12)
    pressures[10] = 2000.0
    found = reader.read(pad.raw(pressures))
    assert found.force == pytest.approx(2000.0 * tip.areas[10], rel=0.02)
    assert np.allclose(found.normal, tip.normals[10])


def test_hough_orientation_requires_grid_array():
    options = FeatureOptions(orientation="hough")
    found = FeatureReader(CALIBRATION, ARRAY, options).read(PAD.raw(imprint(angle=np.pi / 4)))
    assert found.orientation == pytest.approx(np.pi / 4, abs=0.2)
    pad = SyntheticPad.draw(12)
    with pytest.raises(InputError, match="grid"):
        FeatureReader(calibrate(pad.bench()), TactileArray.fingertip(), options)


def test_centre_does_not_trail_behind_a_contact_that_moves_on_foam_with_memory():
    share, period = 0.1, 0.004
    reader = FeatureReader(CALIBRATION, ARRAY, memory=FoamMemory(share, 2.0), period=period)
    plain = FeatureReader(CALIBRATION, ARRAY)
    rng, load, trailing, errors = np.random.default_rng(0), np.zeros(256), [], []
    for x in np.linspace(-0.01, 0.01, 200):
        true = imprint(x, long=0.006)
        load = np.maximum(load + (true - load) * (1.0 - np.exp(-period / 2.0)), true)
        raw = PAD.raw((1.0 - share) * true + share * load, rng)
        trailing.append(plain.read(raw).centre[0] - x)
        errors.append(reader.read(raw).centre[0] - x)
    assert np.mean(trailing[100:]) < -4e-4
    assert abs(np.mean(errors[100:])) < 0.2 * abs(np.mean(trailing[100:]))
    with pytest.raises(InputError, match="period > 0"):
        FeatureReader(CALIBRATION, ARRAY, memory=FoamMemory(share, 2.0))


def test_reader_rejects_mismatched_readings_and_arrays():
    reader = FeatureReader(CALIBRATION, ARRAY)
    with pytest.raises(InputError, match="256"):
        reader.read(np.zeros(12, np.uint16))
    with pytest.raises(InputError, match="uint16"):
        reader.read(np.zeros(256))  # pyright: ignore[reportArgumentType] - the invalid argument under test
    with pytest.raises(InputError, match="12 tactels"):
        FeatureReader(CALIBRATION, TactileArray.fingertip())


def test_readings_above_converter_range_are_saturated_and_finite():
    found = FeatureReader(CALIBRATION, ARRAY).read(np.full(256, 65535, np.uint16))
    assert found.saturated == 256
    assert np.isfinite(found.force)


def test_read_time_is_bounded():
    reader, raw = FeatureReader(CALIBRATION, ARRAY), PAD.raw(imprint(angle=0.3))
    reader.read(raw)
    times = []
    for _ in range(20):
        start = time.perf_counter()
        for _ in range(50):
            reader.read(raw)
        times.append(1e6 * (time.perf_counter() - start) / 50)
    assert min(times) < MAX_READ_US


def test_benchmark_read(benchmark):
    reader, raw = FeatureReader(CALIBRATION, ARRAY), PAD.raw(imprint(angle=0.3))
    found: ContactFeatures = benchmark(reader.read, raw)
    assert found
