"""An unknown object is explored: the command as a person runs it, points from images, the truth."""

import json

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.touch.explore_truth import reachable_surface
from eyehand.apps.touch.felt_points import felt_points
from eyehand.data_synth.foam import Foam
from eyehand.data_synth.touch_objects import Part, TouchObject
from eyehand.errors import InputError
from eyehand.perception.cloud_io import read_cloud
from eyehand.tactile import TactileArray, TactileImage

PAD, FOAM = TactileArray.flat(), Foam()


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["touch", "explore", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_the_cloud_lies_on_the_surface(tmp_path, capsys):
    code, out, _ = run("--quick", "--json", "--out", tmp_path, capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.touch_explore/1"
    assert report["outcomes"] == ["done", "done"]
    both = report["rows"][-1]
    assert both["surface_rms_mm"] < 0.3
    assert both["covered_pct"] > 85.0
    assert report["force_mean_n"] == pytest.approx(3.0, rel=0.15)
    assert (tmp_path / "explore.png").stat().st_size > 20_000
    assert len(read_cloud(tmp_path / "explore.ply")) == both["points"]


def test_impossible_wishes_are_refused_in_one_line(capsys):
    code, _, err = run("--seed", -1, capsys=capsys)
    assert code == 2
    assert "--seed" in err


def test_a_face_gives_its_own_depth_at_every_tactel():
    depth = 0.0004
    pressure = float(FOAM.pressure(np.array([depth]))[0])
    found = felt_points(TactileImage(np.full(256, pressure), PAD), FOAM)
    inner = PAD.positions.reshape(16, 16, 3)[1:-1, 1:-1].reshape(-1, 3)
    assert found[:, :2] == pytest.approx(inner[:, :2], abs=1e-9)
    assert found[:, 2] == pytest.approx(-depth, rel=1e-6)


def test_an_edge_between_two_rows_is_found_there():
    across = PAD.positions[:, 1]
    pressures = 2000.0 * np.exp(-0.5 * (across / 0.003) ** 2)
    found = felt_points(TactileImage(pressures, PAD), FOAM)
    assert len(found) > 20
    assert np.abs(found[:, 1]).max() < 0.001, "tactels are 2.5 mm to either side"


def test_nothing_felt_is_no_point_and_a_pad_without_grid_is_refused():
    assert felt_points(TactileImage(np.zeros(256), PAD), FOAM).shape == (0, 3)
    fingertip = TactileArray.fingertip()
    with pytest.raises(InputError, match="grid"):
        felt_points(TactileImage(np.zeros(len(fingertip.positions)), fingertip), FOAM)


def test_what_is_reached_is_the_hull_that_is_not_steep():
    table = Part("box", (0.06, 0.04, 0.01), (0.0, 0.0, -0.01))
    pin = Part("box", (0.01, 0.01, 0.01), (0.0, 0.0, 0.0))
    flat = reachable_surface(TouchObject("flat", (table,)))
    assert flat[:, 2] == pytest.approx(0.0, abs=1e-9)
    assert len(flat) == pytest.approx(0.12 * 0.08 / 0.002**2, rel=0.1)
    both = reachable_surface(TouchObject("both", (table, pin)))
    around = both[(np.abs(both[:, :2]).max(axis=1) > 0.012) & (np.abs(both[:, 1]) < 0.03)]
    assert not len(around[np.abs(around[:, 0]) < 0.05]), "the pin keeps the pad off around it"
