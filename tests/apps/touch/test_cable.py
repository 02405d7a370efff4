"""The experiment `cable`, and the shapes of its cables."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.touch.cable_run import CableRun, cable_row, run_cable, speed_row
from eyehand.apps.touch.cable_shapes import MAX_CURVATURE, SPACING, cable_shape
from eyehand.errors import DeviceError, InputError


def test_path_follows_cable_to_its_end(tmp_path, run_experiment):
    code, out, _ = run_experiment("cable", "--quick", "--json", "--seed", 1, "--out", tmp_path)
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


def test_press_of_a_plate_before_work_keeps_the_path_straight():
    # Without the gains of the press, the path is 0.23 mm off.
    assert run_cable(3, 0.05, "real").rms < 0.15e-3


def test_cable_that_is_lost_at_once_leaves_the_others():
    none = np.zeros(0)
    lost = CableRun(3, cable_shape(3), 0.05, np.zeros((0, 2)), none, none, none, "overload")
    assert cable_row(lost) == {"name": "cable 3", "speed_mm_s": 50.0, "outcome": "overload"}
    one = np.full(2, 1e-3)
    kept = CableRun(0, cable_shape(0), 0.05, np.zeros((2, 2)), one, one, one, "end of the cable")
    row = speed_row([lost, kept])
    assert (row["path_rms_mm"], row["outcome"]) == (pytest.approx(1.0), "1 of 2 to the end")
    with pytest.raises(DeviceError, match="all 1 cables"):
        speed_row([lost])


@pytest.mark.parametrize("seed", range(4))
def test_cable_line_has_stated_spacing_and_curvature(seed):
    shape, again = cable_shape(seed), cable_shape(seed)
    assert np.array_equal(shape.line, again.line)
    steps = np.diff(shape.line, axis=0)
    assert np.linalg.norm(steps, axis=1) == pytest.approx(SPACING)
    turning = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))) / SPACING
    assert turning == pytest.approx(shape.curvature[2:], abs=1e-6)
    assert np.abs(shape.curvature).max() == pytest.approx(MAX_CURVATURE)
    assert steps[:, 1].min() > 0, "the cable runs along +y"


def test_cable_shape_rejects_negative_seed():
    with pytest.raises(InputError, match="seed"):
        cable_shape(-1)
