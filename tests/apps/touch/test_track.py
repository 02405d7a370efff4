"""A short run of the experiment `track`, and the definition of the response time."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.touch.track_trial import TARGETS, converged


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
