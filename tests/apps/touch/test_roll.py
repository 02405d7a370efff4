"""The experiment `roll`, evaluated by the true tilt."""

import csv
import json

import pytest

from eyehand.apps.touch.roll_trial import roll_once, roll_row
from eyehand.apps.touch.servo_run import lasting


def test_tilted_pad_rolls_flat_twice_and_keeps_contact(tmp_path, run_experiment):
    code, out, _ = run_experiment("roll", "--quick", "--json", "--seed", 2, "--out", tmp_path)
    assert code == 0
    (row,) = json.loads(out)["rows"]
    assert 0 < row["time_to_flat_s"] <= 0.3
    assert row["time_to_flat_again_s"] <= 0.3
    assert max(row["settled_tilt_deg"], row["settled_tilt_again_deg"]) < 0.5
    assert row["contact_losses"] == 0
    assert row["least_force_n"] > 0
    assert (tmp_path / "roll.png").stat().st_size > 20_000
    with (tmp_path / "roll.csv").open() as file:
        tilts = [float(point["tilt_deg"]) for point in csv.DictReader(file)]
    assert tilts[0] == pytest.approx(6.0, abs=0.3)
    # The face turns to the other side, and the pad lags behind it.
    assert min(tilts) < -1.0


def test_landing_that_ends_early_leaves_the_others():
    ended = roll_once(6, "harsh")
    assert ended.run.outcome == "oscillation"
    trials, counts = lasting([roll_once(2), ended])
    assert (counts["trials"], counts["ended_early"]) == (1, 1)
    assert roll_row(trials)["contact_losses"] == 0
