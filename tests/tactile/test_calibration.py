"""Calibration on a synthetic bench: characteristics, noise and faulty tactels."""

import tracemalloc
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator
from scipy.optimize import isotonic_regression

from eyehand.errors import InputError
from eyehand.tactile import (
    BenchRun,
    FeatureReader,
    TactileArray,
    calibrate,
    calibrate_linear,
    load_calibration,
    save_calibration,
)
from eyehand.tactile.calibration_curves import fit_curves
from eyehand.tactile.calibration_file import MAX_FILE_BYTES
from eyehand.tactile.curve_kernels import curve_pressure, make_monotone

from .synthetic_pad import SyntheticPad

PAD = SyntheticPad.draw()
FULL, LINEAR = calibrate(PAD.bench()), calibrate_linear(PAD.bench())


def rms_pct(calibration, pressure: float) -> float:
    """Return the rms error of the calibrated readings of one pressure on all tactels, per cent."""
    raw = PAD.raw(np.full(256, pressure), np.random.default_rng(7))
    error = calibration.to_pressure(raw) / pressure - 1.0
    return 100.0 * float(np.sqrt((error**2).mean()))


@pytest.mark.parametrize(
    ("pressure", "max_error"), [(100.0, 4), (500.0, 1), (2000.0, 1), (8000.0, 1)]
)
def test_full_calibration_is_accurate_over_whole_range(pressure, max_error):
    assert rms_pct(FULL, pressure) < max_error


def test_linear_calibration_is_accurate_in_its_range_only():
    assert rms_pct(LINEAR, 500.0) < 8
    assert rms_pct(LINEAR, 8000.0) > 30
    assert rms_pct(LINEAR, 8000.0) > 30 * rms_pct(FULL, 8000.0)


def test_linear_calibration_of_linear_tactel_is_exact():
    loads = np.linspace(0.0, 2000.0, 21)
    raw = np.rint(100.0 + 0.5 * loads[:, None] * np.ones(4)).astype(np.uint16)
    found = calibrate_linear(BenchRun(loads, raw))
    assert np.allclose(found.to_pressure(np.full(4, 350, np.uint16)), 500.0, rtol=1e-6)
    assert found.to_pressure(np.full(4, 20, np.uint16)).max() == 0.0


def test_calibration_estimates_noise_and_rest_reading():
    assert np.median(FULL.noise) == pytest.approx(2.0, rel=0.1)
    assert np.allclose(FULL.rest, PAD.offset, atol=1.5)


@settings(deadline=None)
@given(st.integers(0, 4094))
def test_calibrated_pressure_is_monotonic_in_the_reading(reading):
    for calibration in (FULL, LINEAR):
        low = calibration.to_pressure(np.full(256, reading, np.uint16))
        assert (low >= 0.0).all()
        # Knots are float32.
        high = calibration.to_pressure(np.full(256, reading + 1, np.uint16))
        assert (high >= low * (1 - 1e-6)).all()


def test_curves_are_monotone_cubics_through_isotonic_means():
    rng = np.random.default_rng(4)
    means, weights = rng.normal(np.arange(40.0), 6.0, (30, 40)), rng.uniform(1, 5, 40)
    rising = means.copy()
    make_monotone(rising, weights)
    for row, values in zip(rising, means, strict=True):
        assert np.allclose(row, isotonic_regression(values, weights=weights).x)
    pressures = np.tile(np.geomspace(5.0, 1e4, 40), (30, 1))
    curves, at = fit_curves(rising, pressures), np.linspace(rising.min() - 5, rising.max() + 5, 200)
    for number, raw in enumerate(rising):
        levels, where = np.unique(raw, return_inverse=True)
        expected = np.bincount(where, pressures[number]) / np.bincount(where)
        cubic = PchipInterpolator(levels, expected)(np.clip(at, levels[0], levels[-1]))
        found = [curve_pressure(curves, number, reading) for reading in at]
        assert np.allclose(found, np.maximum(cubic, 0.0), rtol=1e-4, atol=0.05)


def test_converter_with_16_bits_is_calibrated_to_its_last_counts():
    pad, rng = SyntheticPad.draw(16), np.random.default_rng(0)
    loads = np.concatenate([np.zeros(50), np.repeat(np.geomspace(5.0, 1e4, 100), 4)])

    def raw(pressure: float) -> np.ndarray:
        fine = 16.0 * (pad.offset + pad.span * pressure / (pressure + pad.half))
        return np.rint(fine + rng.normal(0, 8.0, 16)).astype(np.uint16)

    run = BenchRun(loads, np.array([raw(load) for load in loads]), bits=16)
    found = calibrate(run)
    assert run.raw.max() > 40000
    assert np.allclose(found.to_pressure(raw(3000.0)), 3000.0, rtol=0.01)
    features = FeatureReader(found, TactileArray.flat(4, 4)).read(raw(3000.0))
    assert features.pressure == pytest.approx(3000.0, rel=0.01)
    with pytest.raises(InputError, match="bits"):
        BenchRun(loads, run.raw, bits=17)


def test_thresholds_lie_just_above_the_noise():
    rng = np.random.default_rng(3)
    rests = np.array([FULL.to_pressure(PAD.raw(np.zeros(256), rng)) for _ in range(400)])
    assert (rests > FULL.threshold(4.0)).mean() < 2e-4
    assert (rests > FULL.threshold(1.0)).mean() > 0.01
    assert FULL.threshold(4.0).max() < 20.0


def test_dead_and_stuck_tactels_are_marked_and_read_zero():
    run = PAD.bench()
    raw = run.raw.copy()
    raw[:, 10], raw[:, 20] = 130, 4095
    found = calibrate(BenchRun(run.pressures, raw))
    assert np.flatnonzero(found.dead).tolist() == [10, 20]
    readings = PAD.raw(np.full(256, 3000.0))
    assert found.to_pressure(readings)[[10, 20]].tolist() == [0.0, 0.0]
    assert np.isfinite(found.threshold(4.0)).all()
    image = found.to_image(readings, TactileArray.flat())
    assert np.allclose(image.pressures, 3000.0, rtol=0.02)


@pytest.mark.parametrize("make", [calibrate, calibrate_linear])
@pytest.mark.parametrize("alive", [1, 3, 100, 200])
def test_working_tactels_are_calibrated_when_most_are_broken(make, alive):
    run, rng = PAD.bench(), np.random.default_rng(alive)
    broken = rng.permutation(256)[alive:]
    raw = run.raw.copy()
    raw[:, broken[::2]] = rng.integers(0, 4, (len(raw), len(broken[::2])))
    raw[:, broken[1::2]] = 4095
    found, reference = make(BenchRun(run.pressures, raw)), make(run)
    assert np.array_equal(np.flatnonzero(found.dead), np.sort(broken))
    assert found.working == alive
    assert np.array_equal(found.curves[~found.dead], reference.curves[~found.dead])
    # Broken tactels must read zero for every raw value.
    readings = PAD.raw(np.full(256, 3000.0), rng)
    readings[broken] = rng.choice([0, 4095], len(broken))
    assert not found.to_pressure(readings)[broken].any()
    features = FeatureReader(found, TactileArray.flat()).read(readings)
    assert features.force <= 3500.0 * TactileArray.flat().area * 9 * alive


def test_insensitive_tactel_is_dead_when_most_tactels_are_broken():
    run = PAD.bench()
    raw = run.raw.copy()
    raw[:, :200] = 4095
    raw[:, 220] = (100 + 0.05 * (raw[:, 220].astype(float) - raw[0, 220])).astype(np.uint16)
    found = calibrate(BenchRun(run.pressures, raw))
    assert np.flatnonzero(found.dead).tolist() == [*range(200), 220]


def test_calibration_without_working_tactel_raises_with_count():
    run = PAD.bench()
    flat = BenchRun(run.pressures, np.full_like(run.raw, 100))
    for make in (calibrate, calibrate_linear):
        with pytest.raises(InputError, match="0 of 256 tactels work"):
            make(flat)


def test_is_dead_detects_wire_that_breaks_after_calibration():
    readings = PAD.raw(np.full(256, 1000.0))
    readings[33] = 0
    assert np.flatnonzero(FULL.is_dead(readings)).tolist() == [33]


def test_readings_above_calibrated_range_are_saturated():
    assert not FULL.is_saturated(PAD.raw(np.full(256, 9000.0))).any()
    assert FULL.is_saturated(PAD.raw(np.full(256, 12e3))).all()
    assert FULL.is_saturated(np.full(256, 65535, np.uint16)).all()
    assert np.allclose(FULL.to_pressure(np.full(256, 65535, np.uint16)), 1e4)


def test_mark_dead_at_rest_marks_tactel_with_pressure_at_rest():
    rests = np.array([PAD.raw(np.zeros(256), np.random.default_rng(k)) for k in range(20)])
    assert not FULL.mark_dead_at_rest(rests).dead.any()
    rests[:, 77] = 4095
    assert np.flatnonzero(FULL.mark_dead_at_rest(rests).dead).tolist() == [77]


def test_full_calibration_locates_probe_better_than_linear():
    array, rng = TactileArray.flat(), np.random.default_rng(0)
    errors = {"full": [], "linear": []}
    readers = {"full": FeatureReader(FULL, array), "linear": FeatureReader(LINEAR, array)}
    for x in np.linspace(0.0025, 0.0075, 60):
        gaps = array.positions[:, :2] - [x, 0.0025]
        pressures = 4000.0 * np.exp(-0.5 * (gaps**2).sum(axis=1) / 0.003**2)
        raw = PAD.raw(pressures, rng)
        for name, reader in readers.items():
            errors[name].append(reader.read(raw).centre[0] - x)
    rms = {name: 1e3 * np.sqrt(np.mean(np.square(each))) for name, each in errors.items()}
    assert rms["full"] < 0.05
    assert rms["full"] < 0.6 * rms["linear"]


@pytest.mark.parametrize("calibration", [FULL, LINEAR])
def test_saved_calibration_loads_unchanged(calibration, tmp_path):
    path = tmp_path / "pad.npz"
    save_calibration(calibration, path)
    assert [child.name for child in tmp_path.iterdir()] == ["pad.npz"]
    found = load_calibration(path)
    for name in (
        "raws",
        "pressures",
        "rest",
        "noise",
        "ceiling",
        "dead",
        "bits",
        "curves",
        "limits",
    ):
        assert np.array_equal(getattr(found, name), getattr(calibration, name))


def test_load_calibration_rejects_invalid_files(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        load_calibration(tmp_path / "none.npz")
    wrong = tmp_path / "wrong.npz"
    wrong.write_bytes(b"PK nothing")
    with pytest.raises(InputError, match="not a calibration"):
        load_calibration(wrong)
    np.savez(wrong, schema=np.array("eyehand.calibration/9"))
    with pytest.raises(InputError, match="calibration/1"):
        load_calibration(wrong)
    save_calibration(FULL, wrong)
    wrong.write_bytes(wrong.read_bytes()[:-200])
    with pytest.raises(InputError, match="not a calibration"):
        load_calibration(wrong)
    with pytest.raises(InputError, match="npz"):
        save_calibration(FULL, tmp_path / "pad.txt")
    with pytest.raises(InputError, match="folder"):
        save_calibration(FULL, tmp_path / "nowhere" / "pad.npz")


def test_calibration_that_unpacks_to_too_much_is_refused_at_once(tmp_path):
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("rest.npy", bytes(MAX_FILE_BYTES + 1))
    tracemalloc.start()
    with pytest.raises(InputError, match=f"unpack to {MAX_FILE_BYTES + 1} bytes"):
        load_calibration(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10e6


def test_bench_run_rejects_invalid_data():
    run = PAD.bench()
    with pytest.raises(InputError, match="different pressures"):
        BenchRun(np.zeros(20), np.zeros((20, 4), np.uint16))
    with pytest.raises(InputError, match="finite"):
        BenchRun(np.full(len(run.pressures), np.nan), run.raw)
    with pytest.raises(InputError, match=r"in 0\.\.4095"):
        BenchRun(run.pressures, run.raw + np.uint16(5000))
    with pytest.raises(InputError, match="integers"):
        BenchRun(run.pressures, run.raw.astype(float))
    for factor, offset in ((1e-3, 0.0), (1 / 6895, 0.0), (1.0, 101325.0), (1.0, 500.0)):
        with pytest.raises(InputError, match=r"must be in Pa|and include 0"):
            BenchRun(run.pressures * factor + offset, run.raw)
    with pytest.raises(InputError, match="linear calibration"):
        calibrate_linear(BenchRun(np.linspace(0.0, 2e4, 20), run.raw[:20]))


def test_calibration_rejects_invalid_tables_and_readings():
    with pytest.raises(InputError, match="non-decreasing"):
        replace(FULL, raws=FULL.raws[:, ::-1])
    with pytest.raises(InputError, match="finite"):
        replace(FULL, noise=np.full(256, np.nan))
    with pytest.raises(InputError, match="256"):
        FULL.to_pressure(np.zeros(16, np.uint16))
    with pytest.raises(InputError, match="256"):
        FULL.to_pressure(np.zeros(256))  # pyright: ignore[reportArgumentType] - the invalid argument under test
