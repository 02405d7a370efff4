"""The experiment `cop`: position of a thin probe between tactels."""

import csv
import json
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from eyehand.apps.touch.cop import PRESSURE, ProbePath, follow_probe, probe_row
from eyehand.apps.touch.servo_run import lasting
from eyehand.errors import DeviceError


def test_probe_position_between_tactels_is_accurate(tmp_path, run_experiment):
    code, out, _ = run_experiment("cop", "--quick", "--json", "--out", tmp_path)
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


def test_thin_probe_does_not_overload_real_pad():
    # The mean pressure on a probe stays low until the foam stiffens within half a millimetre.
    run = follow_probe(3, "real").run
    assert run.outcome is None
    assert run.averaged.max() < 2.5 * PRESSURE


def _run(outcome: str | None) -> Any:
    return cast("Any", SimpleNamespace(outcome=outcome))


def test_probe_row_summarises_errors_of_the_paths_that_lasted():
    real = np.zeros((2, 2))
    one = ProbePath(real, np.array([[3e-5, 4e-5], [0.0, 0.0]]), np.ones(2), _run(None))
    other = ProbePath(real, np.array([[0.0, 0.0], [0.0, 1e-4]]), np.ones(2), _run(None))
    ended = ProbePath(real[:0], real[:0], np.ones(0), _run("overload"))
    paths, counts = lasting([one, other, ended])
    assert (counts["trials"], counts["ended_early"], counts["outcomes"]) == (2, 1, "overload")
    row = probe_row(paths)
    assert row["error_max_mm"] == pytest.approx(0.1)
    assert row["error_rms_mm"] == pytest.approx(np.sqrt((0.05**2 + 0.1**2) / 4))
    assert row["along_rms_mm"] == pytest.approx(0.015)
    with pytest.raises(DeviceError, match="all 1 trials ended early: overload"):
        lasting([ended])
