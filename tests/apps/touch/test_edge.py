"""The pad turns with an edge: the command as a person runs it."""

import csv
import json

import pytest

from eyehand.apps.main import main


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["experiment", "edge", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_the_pad_comes_into_line_and_turns_with_the_edge(tmp_path, capsys):
    code, out, _ = run("--trials", 1, "--seed", 3, "--json", "--out", tmp_path, capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_edge/1"
    trial, mean = report["rows"]
    assert trial["outcome"] == "done"
    assert trial["response_time_s"] < 1.2
    assert abs(trial["steady_state_error_deg"]) < 0.1
    assert trial["standard_deviation_deg"] < 0.1
    assert trial["turning_rms_deg"] < 4.0, "it is late by one over its gain"
    assert trial["delay_ms"] == pytest.approx(1e3 / 8, rel=0.2)
    assert trial["force_mean_n"] == pytest.approx(3.0, rel=0.01)
    assert mean["turning_rms_deg"] == pytest.approx(trial["turning_rms_deg"])
    assert (tmp_path / "edge.png").stat().st_size > 20_000
    with (tmp_path / "edge.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 2


@pytest.mark.parametrize("wrong", [("--trials", 0), ("--seed", -1)])
def test_impossible_wishes_are_refused_in_one_line(wrong, capsys):
    code, _, err = run(*wrong, capsys=capsys)
    assert code == 2
    assert wrong[0] in err
