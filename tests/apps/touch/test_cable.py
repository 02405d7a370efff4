"""A cable of unknown shape is followed: the command as a person runs it, and the shapes."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.touch.cable_shapes import MAX_CURVATURE, SPACING, cable_shape
from eyehand.errors import InputError


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["experiment", "cable", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_the_path_is_the_cable(tmp_path, capsys):
    code, out, _ = run("--quick", "--json", "--seed", 1, "--out", tmp_path, capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_cable/1"
    slow, fast, *_ = report["rows"]
    assert slow["path_rms_mm"] < 0.3
    assert fast["path_rms_mm"] < 1.0
    for row in (slow, fast):
        assert row["outcome"] == "end of the cable"
        assert row["followed_pct"] > 97.0
        assert row["force_mean_n"] == pytest.approx(2.0, rel=0.1)
    assert (tmp_path / "cable.png").stat().st_size > 20_000
    with (tmp_path / "cable.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 4


@pytest.mark.parametrize("wrong", [("--trials", 0), ("--seed", -1)])
def test_impossible_wishes_are_refused_in_one_line(wrong, capsys):
    code, _, err = run(*wrong, capsys=capsys)
    assert code == 2
    assert wrong[0] in err


@pytest.mark.parametrize("seed", range(4))
def test_cables_bend_as_they_say(seed):
    shape, again = cable_shape(seed), cable_shape(seed)
    assert np.array_equal(shape.line, again.line)
    steps = np.diff(shape.line, axis=0)
    assert np.linalg.norm(steps, axis=1) == pytest.approx(SPACING)
    turning = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))) / SPACING
    assert turning == pytest.approx(shape.curvature[2:], abs=1e-6)
    assert np.abs(shape.curvature).max() == pytest.approx(MAX_CURVATURE)
    assert steps[:, 1].min() > 0, "on the whole it runs along y"


def test_a_cable_needs_a_seed():
    with pytest.raises(InputError, match="seed"):
        cable_shape(-1)
