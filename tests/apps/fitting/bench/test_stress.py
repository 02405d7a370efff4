"""`eyehand stress fit`: output, files and exit codes."""

import json
from functools import partial

import pytest

from eyehand.apps.bench import SweepStep, Trial
from eyehand.apps.bench.shares import refused_pct
from eyehand.apps.fitting.bench.stress import fit_stage, silent_pct

from ...command_line import run_command

run = partial(run_command, "stress", "fit")


def test_command_reports_break_points_and_writes_files(tmp_path, capsys):
    code, out, err = run(
        *("--only", "points", "from-above", "--quick", "--seeds", 1, "--json"),
        *("--out", tmp_path / "new"),
        capsys=capsys,
    )
    assert code == 0, err
    report = json.loads(out)
    assert report["schema"] == "eyehand.stress_fit/2"
    assert (report["seed"], report["seeds"], report["broken_bounds"]) == (0, 1, [])
    assert [row["name"] for row in report["rows"]] == ["points", "from-above"]
    few = report["points"][2]
    assert (few["value"], few["right_pct"], few["refused_pct"]) == (10, 100.0, 100.0)
    assert few["iou_median_pct"] is None
    assert report["points"][0]["iou_median_pct"] > 90
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == [
        "stress.csv",
        "stress.png",
    ]


def test_baseline_has_no_bounds(tmp_path, capsys):
    code, out, err = run(
        *("--only", "noise", "--quick", "--seeds", 1, "--baseline", "ems"),
        *("--json", "--out", tmp_path),
        capsys=capsys,
    )
    assert code == 0, err
    report = json.loads(out)
    assert report["baseline"] == "ems"
    (noise,) = report["rows"]
    assert (noise["holds_to"], noise["bound_kept"]) == (None, True)
    assert report["points"][-1]["right_pct"] == 0
    assert "where ems breaks" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--only", "cup"), "from-above"),
        (("--baseline", "nobody"), "nobody"),
        (("--seeds", 0), "--seeds"),
        (("--seed", -1), "--seed"),
    ],
)
def test_invalid_input_is_rejected_in_one_line(arguments, message, tmp_path, capsys):
    code, out, err = run(*arguments, "--out", tmp_path / "none", capsys=capsys)
    assert (code, out) == (2, "")
    assert message in err
    assert len(err.strip().splitlines()) == 1
    assert not (tmp_path / "none").exists()


def test_figures_separate_silent_failures_and_refusals():
    trials = (
        Trial(True, score=0.9, seconds=0.01),
        Trial(False, "wrong", score=0.4, seconds=0.03),
        Trial(False, "refused: why", refused=True, seconds=0.02),
        Trial(False, "raised", clean=False),
    )
    step = SweepStep(3, trials)
    assert (silent_pct(step), refused_pct(step)) == (25.0, 25.0)
    assert fit_stage().report.figures(step) == {
        "iou_median_pct": 65.0,
        "iou_worst_pct": 40.0,
        "refused_pct": 25.0,
        "silent_pct": 25.0,
        "raised": 1,
        "fit_ms": 20.0,
    }
