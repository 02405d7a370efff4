"""The probe between tactels as a person runs it."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.touch.cop import probe_row
from eyehand.apps.touch.probe_path import ProbePath


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["experiment", "cop", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_a_probe_is_placed_between_tactels(tmp_path, capsys):
    code, out, _ = run("--quick", "--json", "--out", tmp_path, capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_cop/1"
    (row,) = report["rows"]
    assert 0 < row["error_rms_mm"] <= 0.05
    assert row["error_max_mm"] <= 0.12
    assert (tmp_path / "cop.png").stat().st_size > 20_000
    with (tmp_path / "cop.csv").open() as file:
        points = list(csv.DictReader(file))
    real = [float(point["real_x_mm"]) for point in points if point["way"] == "0"]
    assert max(real) - min(real) == pytest.approx(5.0, abs=0.05)


@pytest.mark.parametrize("wrong", [("--trials", 0), ("--seed", -1)])
def test_impossible_wishes_are_refused_in_one_line(wrong, capsys):
    code, _, err = run(*wrong, capsys=capsys)
    assert code == 2
    assert wrong[0] in err


def test_errors_are_distances_over_all_ways():
    real = np.zeros((2, 2))
    one = ProbePath(real, np.array([[3e-5, 4e-5], [0.0, 0.0]]), np.ones(2))
    other = ProbePath(real, np.array([[0.0, 0.0], [0.0, 1e-4]]), np.ones(2))
    row = probe_row([one, other])
    assert row["error_max_mm"] == pytest.approx(0.1)
    assert row["error_rms_mm"] == pytest.approx(np.sqrt((0.05**2 + 0.1**2) / 4))
    assert row["along_rms_mm"] == pytest.approx(0.015)
