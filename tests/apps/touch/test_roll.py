"""Rolling as a person runs it, judged by the true tilt."""

import csv
import json

import pytest

from eyehand.apps.main import main


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["experiment", "roll", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_a_pad_rolls_flat_and_back_and_keeps_contact(tmp_path, capsys):
    code, out, _ = run("--quick", "--json", "--seed", 2, "--out", tmp_path, capsys=capsys)
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
    # The face turns the other way, and the pad lags behind it.
    assert min(tilts) < -1.0


@pytest.mark.parametrize("wrong", [("--trials", 0), ("--seed", -1)])
def test_impossible_wishes_are_refused_in_one_line(wrong, capsys):
    code, _, err = run(*wrong, capsys=capsys)
    assert code == 2
    assert wrong[0] in err
