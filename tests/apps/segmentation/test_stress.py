"""`eyehand stress segmentation`: output, files and exit codes."""

import json
from functools import partial

import pytest

from ..command_line import check_refusal, run_command

FILES = ["breaking.png", "stress.csv", "stress.png"]


run = partial(run_command, "stress", "segmentation")


def test_command_reports_break_points_and_writes_files(tmp_path, capsys):
    code, out, err = run(
        *(
            "--only",
            "nan",
            "empty",
            "millimetres",
            "--quick",
            "--seeds",
            1,
            "--json",
            "--out",
            tmp_path / "new",
        ),
        capsys=capsys,
    )
    assert code == 0, err
    report = json.loads(out)
    assert report["schema"] == "eyehand.stress_segmentation/1"
    assert (report["seed"], report["seeds"], report["broken_bounds"]) == (0, 1, [])
    empty, millimetres, nan = report["rows"]
    assert [empty["name"], millimetres["name"], nan["name"]] == ["empty", "millimetres", "nan"]
    assert (millimetres["breaks_at"], millimetres["wrong"]) == (20, "not rejected")
    assert (nan["breaks_at"], nan["bound_kept"]) == (None, True)
    assert len(report["points"]) == 3 + 3 + 2
    assert "breaks at" in err
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == FILES


def test_broken_bound_is_named_and_gives_exit_code_1(tmp_path, capsys):
    code, out, err = run(
        *("--only", "flat", "--quick", "--seeds", 1, "--min-object", 100_000, "--out", tmp_path),
        capsys=capsys,
    )
    assert code == 1
    assert "flat" in out
    assert "broken bound: flat at 20 mm: 0 of 1 right; 0 segments for 2 objects: 2 missed" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--only", "cup"), "'cup'"),
        (("--seeds", 0), "--seeds"),
        (("--seed", -1), "--seed"),
        (("--window", 4), "window"),
    ],
)
def test_invalid_arguments_give_one_line_error(arguments, message, tmp_path, capsys):
    check_refusal(run, arguments, message, tmp_path / "none", capsys)
