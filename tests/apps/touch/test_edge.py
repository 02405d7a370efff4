"""The experiment `edge`: a pad that turns with an edge."""

import csv
import json

import pytest

from eyehand.apps.touch.edge_run import run_edge
from eyehand.errors import DeviceError


def test_pad_aligns_with_edge_and_follows_its_rotation(tmp_path, run_experiment):
    code, out, _ = run_experiment("edge", "--trials", 1, "--seed", 3, "--json", "--out", tmp_path)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_edge/1"
    trial, mean = report["rows"]
    assert trial["outcome"] == "done"
    assert trial["response_time_s"] < 1.2
    assert abs(trial["steady_state_error_deg"]) < 0.1
    assert trial["standard_deviation_deg"] < 0.1
    assert trial["turning_rms_deg"] < 4.0, "the delay is 1 / gain"
    assert trial["delay_ms"] == pytest.approx(1e3 / 8, rel=0.2)
    assert trial["force_mean_n"] == pytest.approx(3.0, rel=0.01)
    assert mean["turning_rms_deg"] == pytest.approx(trial["turning_rms_deg"])
    assert (tmp_path / "edge.png").stat().st_size > 20_000
    with (tmp_path / "edge.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 2


@pytest.mark.parametrize("option", [("--trials", 0), ("--seed", -1)])
def test_invalid_option_value_exits_with_code_2(option, run_experiment):
    code, _, err = run_experiment("edge", *option)
    assert code == 2
    assert option[0] in err


def test_servo_that_ends_early_is_named():
    with pytest.raises(DeviceError, match="ended early"):
        run_edge(1, "harsh")
