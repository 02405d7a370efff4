"""A short run of the experiment `track`, and the definition of the response time."""

import csv
import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from eyehand.apps.touch.track_trial import (
    TARGETS,
    TrackTrial,
    _row,
    converged,
    track_once,
    track_rows,
)
from eyehand.errors import DeviceError


def test_one_setting_tracks_pen_box_and_ball(tmp_path, run_experiment):
    code, out, _ = run_experiment("track", "--quick", "--json", "--out", tmp_path)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_track/1"
    rows = {row["name"]: row for row in report["rows"]}
    assert list(rows) == ["Rigid pen", "Toy box", "Soft ball", "X", "Y"]
    for row in rows.values():
        error, deviation, response = TARGETS["position" if row["unit"] == "px" else "force"]
        # The convergence weighs more in 2 s than in 20 s.
        assert row["steady_state_error"] <= 10 * error
        assert row["standard_deviation"] <= 3 * deviation
        assert row["response_time_s"] <= response
        assert row["converged"] == row["trials"]
    assert report["servo_cycle_us"] < 100
    assert (tmp_path / "track.png").stat().st_size > 20_000
    with (tmp_path / "table.csv").open() as file:
        assert [row["name"] for row in csv.DictReader(file)] == list(rows)


def test_converged_returns_start_of_lasting_small_error():
    time = np.linspace(0.0, 0.996, 250)
    error = np.where(time < 0.1, 1.0, 0.01)
    assert converged(time, error, 0.05) == pytest.approx(0.1)
    error[50] = 0.2
    assert converged(time, error, 0.05) == pytest.approx(0.204)
    assert np.isnan(converged(time, np.ones(250), 0.05))


def test_a_run_that_does_not_converge_is_counted_and_not_averaged():
    time = np.linspace(0.0, 0.996, 250)
    runs = [SimpleNamespace(time=time)] * 2
    errors = [np.where(time < 0.1, 1.0, 0.01), np.ones(250)]
    row = _row("X", cast("Any", runs), errors, 0.05, 0.5, "position")
    assert (row["converged"], row["trials"]) == (1, 2)
    assert row["slowest_response_s"] == row["response_time_s"] == pytest.approx(0.1, abs=0.005)
    with pytest.raises(DeviceError, match="none of 2"):
        _row("X", cast("Any", runs), errors[1:] * 2, 0.05, 0.5, "position")


def test_a_trial_that_ends_early_enters_only_the_peak():
    trial = track_once("Rigid pen", 0, 1.1)
    high = replace(trial.run, averaged=3 * trial.run.averaged, outcome="overload")
    row, *_ = track_rows([trial, TrackTrial("Rigid pen", high)], 0.1)
    assert (row["trials"], row["ended_early"], row["outcomes"]) == (1, 1, "overload")
    assert row["peak"] == pytest.approx(3e-3 * trial.run.averaged.max())
    assert row["steady_state_error"] < 0.02
