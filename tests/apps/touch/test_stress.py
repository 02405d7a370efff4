"""The stress sweeps of the tactile servo: passed bounds, and clean failures beyond them."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.bench import StressArguments
from eyehand.apps.bench.sweep import select_sweeps
from eyehand.apps.touch.stress import HOLDS_TO, stress_touch, touch_sweeps
from eyehand.apps.touch.stress_trial import ContactFigures, evaluate_contact
from eyehand.data_synth.pad import SENSORS

QUIET = ContactFigures(None, False, 2.0, 0.0, 1.0, 1000.0, 1000.0, 10.0, 0.0, 0.0, 0.0, 0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value"),
    [("gain-box", 0.5), ("landing-pen", 50.0), ("round", 10.0), ("right-angle", 2.0),
     ("light", 5.0), ("dead", 5.0), ("coming", 5.0)],
)  # fmt: skip
def test_contact_is_held_within_bounds(name, value):
    (sweep,) = select_sweeps(touch_sweeps(), (name,))
    trial = sweep.attempt(value, 0, SENSORS["good"])
    assert trial.passed, trial.note


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value", "outcome"),
    [("gain-box", 4.0, "oscillation"), ("landing-box", 200.0, "overload"),
     ("border", 42.0, "at_border"), ("blobs", 1.0, "unsteady_contact"),
     ("saturated", 30.0, "tactels_lost"), ("dead", 95.0, "tactels_lost"),
     ("lag", 200.0, "oscillation"),
     ("coming", 20.0, "steady_miss")],
)  # fmt: skip
def test_failure_beyond_limit_has_outcome_and_pad_retracts(name, value, outcome):
    (sweep,) = select_sweeps(touch_sweeps(), (name,))
    trial = sweep.attempt(value, 0, SENSORS["good"])
    assert isinstance(trial.picture, ContactFigures)
    assert trial.picture.outcome == outcome
    assert trial.picture.ended
    assert trial.picture.last_force == 0.0
    assert trial.clean


@pytest.mark.parametrize("name", ["dead", "saturated"])
def test_pad_without_working_tactel_is_rejected_before_motion(name):
    (sweep,) = select_sweeps(touch_sweeps(), (name,))
    trial = sweep.attempt(100.0, 0, SENSORS["good"])
    assert (trial.passed, trial.refused, trial.clean) == (False, True, True)
    assert trial.note == "0 of 256 tactels work"


@pytest.mark.parametrize("sensor", HOLDS_TO)
def test_bounds_of_the_other_sensors_are_values_of_sweeps(sensor):
    sweeps = {sweep.name: sweep for sweep in touch_sweeps()}
    for name, value in HOLDS_TO[sensor].items():
        required = sweeps[name].required_values()
        assert value in required, f"{name}: a worse sensor cannot hold to more than the good one"


@pytest.mark.parametrize("seed", [400, 401])
def test_object_that_leaves_and_comes_back_is_met_gently(seed):
    """The foam remembers the object, so the pad follows it without noticing that it has left."""
    (sweep,) = select_sweeps(touch_sweeps(), ("lost-rolling",))
    trial = sweep.attempt(5.0, seed, SENSORS["real"])
    assert isinstance(trial.picture, ContactFigures)
    assert trial.clean
    assert trial.picture.peak_force < 30.0


def test_evaluate_contact_distinguishes_harm_from_missed_goal():
    assert evaluate_contact(QUIET, 1000.0).passed
    for change in ({"pressure": 500.0}, {"peak_pressure": 1300.0}, {"swing": 100.0}):
        missed = evaluate_contact(replace(QUIET, **change), 1000.0)
        assert not missed.passed
        assert missed.clean
    for harm in (
        replace(QUIET, peak_force=np.nan),
        replace(QUIET, peak_force=100.0),
        replace(QUIET, outcome="overload", growth=2.0, ended=True, last_force=0.0),
        replace(QUIET, outcome="overload", ended=True, last_force=1.0),
        replace(QUIET, outcome="overload", ended=False, last_force=0.0),
    ):
        assert not evaluate_contact(harm, 1000.0).clean


def test_stress_command_writes_chart_of_sweep(tmp_path, capsys):
    assert stress_touch(StressArguments(only=["border"], quick=True, json=True, out=tmp_path)) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["broken_bounds"] == []
    assert [row["name"] for row in report["rows"]] == ["border"]
    assert (tmp_path / "stress.png").stat().st_size > 0
    assert (tmp_path / "stress.csv").stat().st_size > 0
