"""Tracking as a person runs it, in short, and the rule for response times."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.touch.track_trial import TARGETS, converged


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["experiment", "track", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_one_setting_holds_pen_box_and_ball(tmp_path, capsys):
    code, out, _ = run("--quick", "--json", "--out", tmp_path, capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_track/1"
    rows = {row["name"]: row for row in report["rows"]}
    assert list(rows) == ["Rigid pen", "Toy box", "Soft ball", "X", "Y"]
    for row in rows.values():
        error, deviation, response = TARGETS["position" if row["unit"] == "px" else "force"]
        # The way from the band's border to the goal weighs more in 2 s than in 20 s.
        assert row["steady_state_error"] <= 10 * error
        assert row["standard_deviation"] <= 3 * deviation
        assert row["response_time_s"] <= response
    assert report["servo_cycle_us"] < 100
    assert (tmp_path / "track.png").stat().st_size > 20_000
    with (tmp_path / "table.csv").open() as file:
        assert [row["name"] for row in csv.DictReader(file)] == list(rows)


@pytest.mark.parametrize("wrong", [("--trials", 0), ("--seed", -1)])
def test_impossible_wishes_are_refused_in_one_line(wrong, capsys):
    code, _, err = run(*wrong, capsys=capsys)
    assert code == 2
    assert wrong[0] in err


def test_convergence_is_where_the_error_stays_small():
    time = np.linspace(0.0, 0.996, 250)
    error = np.where(time < 0.1, 1.0, 0.01)
    assert converged(time, error, 0.05) == pytest.approx(0.1)
    error[50] = 0.2
    assert converged(time, error, 0.05) == pytest.approx(0.204)
    assert np.isnan(converged(time, np.ones(250), 0.05))
