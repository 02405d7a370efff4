"""The experiment `edge`: a pad that turns with an edge."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.touch.edge import edge_picture
from eyehand.apps.touch.edge_run import DONE, EdgeRun, edge_row, mean_row, run_edge

TIMES = np.arange(0.0, 12.0, 0.004)


def test_pad_aligns_with_edge_and_follows_its_rotation(tmp_path, run_experiment):
    code, out, _ = run_experiment("edge", "--trials", 1, "--seed", 3, "--json", "--out", tmp_path)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_edge/1"
    trial, mean = report["rows"]
    assert trial["outcome"] == "done"
    assert trial["response_time_s"] < 1.2
    assert abs(trial["steady_state_error_deg"]) < 0.1
    assert trial["standard_deviation_deg"] < 0.1
    assert trial["turning_rms_deg"] < 4.0, "the delay is 1 / gain"
    assert trial["delay_ms"] == pytest.approx(1e3 / 8, rel=0.2)
    assert trial["force_mean_n"] == pytest.approx(3.0, rel=0.01)
    assert mean["turning_rms_deg"] == pytest.approx(trial["turning_rms_deg"])
    assert (tmp_path / "edge.png").stat().st_size > 20_000
    with (tmp_path / "edge.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 2


def test_trial_that_ends_early_is_named_and_leaves_the_others():
    lasted = EdgeRun(20.0, 0.1, TIMES, TIMES, 20.0 * np.exp(-9 * TIMES), TIMES, DONE)
    ended = run_edge(1, "harsh")
    assert ended.outcome == "unsteady_contact"
    rows = [edge_row(lasted), edge_row(ended)]
    assert rows[1]["outcome"] == "unsteady_contact"
    assert rows[1]["turning_rms_deg"] is None
    mean = mean_row(rows)
    assert mean["outcome"] == "1 of 2 done"
    assert mean["response_time_s"] == rows[0]["response_time_s"]
    assert mean_row(rows[1:])["response_time_s"] is None


@pytest.mark.parametrize("outcomes", [(DONE, "oscillation"), ("oscillation",)])
def test_picture_shows_trials_that_ended_early(outcomes):
    runs = [EdgeRun(20.0, 0.1, TIMES, TIMES, TIMES, TIMES, outcome) for outcome in outcomes]
    assert len(edge_picture(runs, 0).axes) == 2
