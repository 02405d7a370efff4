"""An unknown object is explored: the command as a person runs it, points from images, the truth."""

import json

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.touch.explore_truth import height_map, on_ridges, reachable_surface
from eyehand.apps.touch.felt_points import felt_points, unspread
from eyehand.data_synth.pad import (
    Foam,
    Part,
    TouchObject,
    spread_weights,
    surface_distance,
    unknown_object,
)
from eyehand.errors import InputError
from eyehand.perception.io import read_cloud
from eyehand.tactile import TactileArray, TactileImage

PAD, FOAM, SPREAD = TactileArray.flat(), Foam(), 0.0025


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["experiment", "explore", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_the_cloud_lies_on_the_surface(tmp_path, capsys):
    code, out, _ = run("--quick", "--json", "--out", tmp_path, capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_explore/1"
    assert report["outcomes"] == ["done", "done"]
    *_, blurred, both = report["rows"]
    assert both["surface_rms_mm"] < 0.15
    assert both["ridges_rms_mm"] < 0.5 * blurred["ridges_rms_mm"]
    assert both["covered_pct"] > 85.0, "of what 40° reach, in a few lanes"
    assert 1.2 < report["force_mean_n"] < 3.1, "less than 3 N on ridges and corners"
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


def felt_as(pressure_of_x) -> TactileImage:
    """What a pad feels of a pressure that varies along x alone."""
    cells = (np.arange(32) + 0.5) * 0.0025 - 0.04
    fine = np.tile(pressure_of_x(cells), (32, 1))
    weights = spread_weights(16, 0.005, SPREAD) / 2
    return TactileImage((weights @ fine @ weights.T).ravel(), PAD)


def test_a_face_stays_as_it_is_when_the_spread_is_undone():
    image = felt_as(lambda x: np.full_like(x, 1500.0))
    depth = float(FOAM.compression(np.array([1500.0]))[0])
    found = felt_points(image, FOAM, SPREAD)
    assert len(found) == 28 * 28
    assert found[:, 2] == pytest.approx(-depth, rel=1e-3)


@pytest.mark.parametrize("middle", [0.0, 0.0012, 0.005])
def test_a_ridge_is_as_high_as_it_is_when_the_spread_is_undone(middle):
    depth, radius = 0.0012, 0.012
    image = felt_as(lambda x: FOAM.pressure(depth - (x - middle) ** 2 / (2 * radius)))
    low = felt_points(image, FOAM)[:, 2]
    found = felt_points(image, FOAM, SPREAD)
    true = -(depth - (found[:, 0] - middle) ** 2 / (2 * radius))
    assert np.sqrt(np.mean((found[:, 2] - true) ** 2)) < 1e-4
    assert low.min() > found[:, 2].min() + 2e-4, "blurred, the ridge looks lower"


def test_undoing_the_spread_keeps_the_force_and_makes_nothing_negative():
    image = felt_as(lambda x: np.where(np.abs(x) < 0.004, 3000.0, 0.0))
    sought = unspread(image.pressures.reshape(16, 16), 0.005, SPREAD)
    assert sought.min() >= 0.0
    assert sought.mean() == pytest.approx(image.pressures.mean(), rel=0.01)


@pytest.mark.parametrize("seed", range(6))
def test_unknown_objects_differ_and_stand_out_a_little(seed):
    thing = unknown_object(seed)
    _, _, heights = height_map(thing)
    assert 0.0 < np.nanmax(heights) < 0.006, "the pads start 8 mm over the top"
    assert thing != unknown_object(seed + 1)
    assert np.abs(surface_distance(thing, [[0.0, 0.0, 0.0]])) < 0.006


def test_ridges_are_told_from_what_is_smooth():
    points = [[-0.04, 0.01, 0.0], [0.0, -0.03, -0.003], [0.045, -0.012, 0.0013]]
    assert on_ridges(unknown_object(), np.array(points)).tolist() == [True, False, False]


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
