"""`eyehand stress segmentation`: output, files and exit codes."""

import json

import pytest

from eyehand.apps.main import main

FILES = ["breaking.png", "stress.csv", "stress.png"]


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Run the command; return exit code, stdout and stderr."""
    with pytest.raises(SystemExit) as exit_info:
        main(["stress", "segmentation", *map(str, arguments)])
    printed = capsys.readouterr()
    return int(exit_info.value.code or 0), printed.out, printed.err


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
    code, out, err = run(*arguments, "--out", tmp_path / "none", capsys=capsys)
    assert (code, out) == (2, "")
    assert message in err
    assert len(err.strip().splitlines()) == 1
    assert not (tmp_path / "none").exists()
