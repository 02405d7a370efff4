"""Calibration from a made-up bench: curves, noise, and tactels that cannot be trusted."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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

from .made_up_pad import MadeUpPad

PAD = MadeUpPad.draw()
FULL, LINEAR = calibrate(PAD.bench()), calibrate_linear(PAD.bench())


def rms_pct(calibration, pressure: float) -> float:
    """Error of readings of one pressure on all tactels, per cent."""
    raw = PAD.raw(np.full(256, pressure), np.random.default_rng(7))
    error = calibration.to_pressure(raw) / pressure - 1.0
    return 100.0 * float(np.sqrt((error**2).mean()))


@pytest.mark.parametrize(("pressure", "most"), [(100.0, 4), (500.0, 1), (2000.0, 1), (8000.0, 1)])
def test_the_full_curve_gives_the_pressure_back_from_one_end_to_the_other(pressure, most):
    assert rms_pct(FULL, pressure) < most


def test_the_line_is_good_in_its_range_only():
    assert rms_pct(LINEAR, 500.0) < 8
    assert rms_pct(LINEAR, 8000.0) > 30
    assert rms_pct(LINEAR, 8000.0) > 30 * rms_pct(FULL, 8000.0)


def test_a_line_of_a_straight_tactel_is_exact():
    loads = np.linspace(0.0, 2000.0, 21)
    raw = np.rint(100.0 + 0.5 * loads[:, None] * np.ones(4)).astype(np.uint16)
    found = calibrate_linear(BenchRun(loads, raw))
    assert np.allclose(found.to_pressure(np.full(4, 350, np.uint16)), 500.0, rtol=1e-6)
    assert found.to_pressure(np.full(4, 20, np.uint16)).max() == 0.0


def test_noise_and_rest_are_found():
    assert np.median(FULL.noise) == pytest.approx(2.0, rel=0.1)
    assert np.allclose(FULL.rest, PAD.offset, atol=1.5)


@settings(deadline=None)
@given(st.integers(0, 255), st.integers(0, 4094))
def test_pressures_never_fall_with_the_reading(tactel, reading):
    for calibration in (FULL, LINEAR):
        assert 0.0 <= calibration.table[tactel, reading] <= calibration.table[tactel, reading + 1]


def test_thresholds_are_above_the_noise_and_only_just():
    rng = np.random.default_rng(3)
    rests = np.array([FULL.to_pressure(PAD.raw(np.zeros(256), rng)) for _ in range(400)])
    assert (rests > FULL.threshold(4.0)).mean() < 2e-4
    assert (rests > FULL.threshold(1.0)).mean() > 0.01
    assert FULL.threshold(4.0).max() < 20.0


def test_dead_and_stuck_tactels_are_marked_and_read_as_nothing():
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
def test_what_works_is_calibrated_however_little_it_is(make, alive):
    run, rng = PAD.bench(), np.random.default_rng(alive)
    broken = rng.permutation(256)[alive:]
    raw = run.raw.copy()
    raw[:, broken[::2]] = rng.integers(0, 4, (len(raw), len(broken[::2])))
    raw[:, broken[1::2]] = 4095
    found, whole = make(BenchRun(run.pressures, raw)), make(run)
    assert np.array_equal(np.flatnonzero(found.dead), np.sort(broken))
    assert found.working == alive
    assert np.array_equal(found.table[~found.dead], whole.table[~found.dead])
    # Nothing is felt where nothing works, whatever the broken ones read.
    readings = PAD.raw(np.full(256, 3000.0), rng)
    readings[broken] = rng.choice([0, 4095], len(broken))
    assert not found.to_pressure(readings)[broken].any()
    features = FeatureReader(found, TactileArray.flat()).read(readings)
    assert features.force <= 3500.0 * TactileArray.flat().area * 9 * alive


def test_a_half_broken_tactel_is_dead_even_where_most_others_are():
    run = PAD.bench()
    raw = run.raw.copy()
    raw[:, :200] = 4095
    raw[:, 220] = (100 + 0.05 * (raw[:, 220].astype(float) - raw[0, 220])).astype(np.uint16)
    found = calibrate(BenchRun(run.pressures, raw))
    assert np.flatnonzero(found.dead).tolist() == [*range(200), 220]


def test_a_pad_without_a_living_tactel_is_refused_with_the_count():
    run = PAD.bench()
    flat = BenchRun(run.pressures, np.full_like(run.raw, 100))
    for make in (calibrate, calibrate_linear):
        with pytest.raises(InputError, match="0 of 256 tactels work"):
            make(flat)


def test_a_wire_that_breaks_later_is_seen_in_its_reading():
    readings = PAD.raw(np.full(256, 1000.0))
    readings[33] = 0
    assert np.flatnonzero(FULL.is_dead(readings)).tolist() == [33]


def test_readings_above_what_the_bench_had_shown_are_saturated():
    assert not FULL.is_saturated(PAD.raw(np.full(256, 9000.0))).any()
    assert FULL.is_saturated(PAD.raw(np.full(256, 12e3))).all()
    assert FULL.is_saturated(np.full(256, 65535, np.uint16)).all()
    assert np.allclose(FULL.to_pressure(np.full(256, 65535, np.uint16)), 1e4)


def test_tactels_that_feel_something_at_rest_are_marked_by_a_recheck():
    rests = np.array([PAD.raw(np.zeros(256), np.random.default_rng(k)) for k in range(20)])
    assert not FULL.mark_dead_at_rest(rests).dead.any()
    rests[:, 77] = 4095
    assert np.flatnonzero(FULL.mark_dead_at_rest(rests).dead).tolist() == [77]


def test_a_probes_place_is_better_by_the_full_curve():
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


@pytest.mark.parametrize("made", [FULL, LINEAR])
def test_a_calibration_comes_back_from_its_file_as_it_was(made, tmp_path):
    path = tmp_path / "pad.npz"
    save_calibration(made, path)
    assert [child.name for child in tmp_path.iterdir()] == ["pad.npz"]
    found = load_calibration(path)
    for name in ("raws", "pressures", "rest", "noise", "ceiling", "dead", "table", "limits"):
        assert np.array_equal(getattr(found, name), getattr(made, name))


def test_files_that_are_no_calibration_are_refused_in_one_line(tmp_path):
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


def test_impossible_bench_runs_are_refused():
    run = PAD.bench()
    with pytest.raises(InputError, match="different pressures"):
        BenchRun(np.zeros(20), np.zeros((20, 4), np.uint16))
    with pytest.raises(InputError, match="finite"):
        BenchRun(np.full(len(run.pressures), np.nan), run.raw)
    with pytest.raises(InputError, match=r"in 0\.\.4095"):
        BenchRun(run.pressures, run.raw + np.uint16(5000))
    with pytest.raises(InputError, match="whole numbers"):
        BenchRun(run.pressures, run.raw.astype(float))
    with pytest.raises(InputError, match="linear calibration"):
        calibrate_linear(BenchRun(np.linspace(2e3, 1e4, 20), run.raw[:20]))


def test_impossible_calibrations_and_readings_are_refused():
    with pytest.raises(InputError, match="fall"):
        replace(FULL, raws=FULL.raws[:, ::-1])
    with pytest.raises(InputError, match="finite"):
        replace(FULL, noise=np.full(256, np.nan))
    with pytest.raises(InputError, match="256"):
        FULL.to_pressure(np.zeros(16, np.uint16))
    with pytest.raises(InputError, match="256"):
        FULL.to_pressure(np.zeros(256))  # pyright: ignore[reportArgumentType] - that is what is refused
