"""Simulated slip: when an alarm counts, rates, trials, and the command."""

import json

import numpy as np
import pytest

from eyehand.apps.touch.slip_bound import BOUND_ERRORS, bound_name, observed_slides
from eyehand.apps.touch.slip_detection import Alarms, alarm_level, detection_row, judge_alarms
from eyehand.apps.touch.slip_trials import SlipTrial, run_slip_trial
from eyehand.data_synth.pad import SENSORS
from eyehand.tactile.slip_features import FEATURES

TIME = np.arange(0.2, 0.5, 0.002)


def trial(start: float | None, event: str = "load") -> SlipTrial:
    """Return a trial that slides by 1 mm in 0.1 s from a time on, or not at all."""
    slide = np.zeros(len(TIME))
    if start is not None:
        slide = 0.01 * np.clip(TIME - start, 0.0, 0.1)
    count = len(TIME)
    return SlipTrial(
        event,
        TIME,
        np.zeros((count, FEATURES), np.float32),
        np.zeros((count, 16), np.float32),
        slide,
    )


def score_from(time: float) -> np.ndarray:
    return np.where(time <= TIME, 1.0, 0.0)


@pytest.mark.parametrize(
    ("alarm", "in_time"), [(0.28, False), (0.296, True), (0.33, True), (0.37, False)]
)
def test_alarm_counts_from_just_before_the_slide_until_shortly_after(alarm, in_time):
    alarms = judge_alarms([trial(0.3)], [score_from(alarm)], 0.5)
    assert alarms.detected.tolist() == [in_time]
    assert alarms.alarmed.tolist() == [True]


def test_latency_and_slide_are_those_of_the_first_alarm():
    alarms = judge_alarms([trial(0.3)], [score_from(0.33)], 0.5)
    # 0.1 mm have been slid at 0.31 s.
    assert alarms.latency == pytest.approx([0.02], abs=0.003)
    assert alarms.slide == pytest.approx([3e-4], abs=2e-5)


def test_an_observer_of_the_slide_is_as_late_as_the_sensor():
    (seen,) = observed_slides([trial(0.3)], wait=0.008, error=0.0, seed=0)
    alarms = judge_alarms([trial(0.3)], [seen], 1e-4)
    assert alarms.latency == pytest.approx([0.008], abs=0.003)
    (noisy,) = observed_slides([trial(None)], wait=0.008, error=2e-5, seed=0)
    assert noisy.std() == pytest.approx(2e-5, rel=0.2)


def test_rates_count_trials():
    trials = [trial(0.3), trial(0.3), trial(None, "knock"), trial(None, "unload")]
    alarms = Alarms(
        np.array([True, False, False, False]),
        np.array([True, False, True, False]),
        np.array([0.004]),
        np.array([2e-4]),
    )
    row = detection_row(trials, alarms)
    assert (row["slips"], row["calm"], row["knocks"]) == (2, 2, 1)
    assert (row["detected_pct"], row["false_pct"], row["false_knocks_pct"]) == (50, 50, 100)
    assert (row["latency_ms"], row["slide_mm"]) == pytest.approx((4.0, 0.2))


def test_level_leaves_one_of_a_hundred_calm_trials_above_it():
    trials = [trial(None)] * 101
    scores = [np.full(len(TIME), float(k)) for k in range(101)]
    assert alarm_level(trials, scores) == pytest.approx(99.0)


def test_rates_without_slips_are_none():
    row = detection_row([trial(None)], judge_alarms([trial(None)], [np.zeros(len(TIME))], 1.0))
    assert row["detected_pct"] is None
    assert row["latency_ms"] is None


def test_the_same_seed_gives_the_same_trial():
    first, again = (run_slip_trial("can", "pull", 3, SENSORS["real"], 20e3) for _ in range(2))
    assert np.array_equal(first.features, again.features)
    assert np.array_equal(first.slide, again.slide)
    assert np.isfinite(first.features).all()
    assert np.isfinite(first.spectra).all()


def test_unloading_causes_no_slip():
    assert run_slip_trial("bar", "unload", 5, SENSORS["good"], 5e3).slide[-1] < 5e-5


def test_command_measures_all_detectors(tmp_path, run_experiment):
    code, out, _ = run_experiment(
        "slip", "--quick", "--trials", 2, "--json", "--out", tmp_path / "out"
    )
    assert code == 0
    rows = json.loads(out)["rows"]
    assert [row["name"] for row in rows] == [
        "Fourier (chapter)",
        "pressure patterns",
        "with a shear array",
        *map(bound_name, BOUND_ERRORS),
    ]
    assert all(row["slips"] + row["calm"] == 16 for row in rows)
    assert (tmp_path / "out" / "slip.png").stat().st_size > 10_000
