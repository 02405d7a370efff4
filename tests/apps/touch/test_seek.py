"""Edges and corners are sought by touch: the command as a person runs it, and the true places."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.touch.seek_shapes import SHAPES
from eyehand.data_synth.pad import top_surface


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["experiment", "seek", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_a_prism_and_a_ridge_are_gone_round(tmp_path, capsys):
    code, out, _ = run(
        "--only",
        "prism",
        "ridge",
        "--quick",
        "--seed",
        5,
        "--json",
        "--out",
        tmp_path,
        capsys=capsys,
    )
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_seek/1"
    prism, ridge = report["rows"]
    assert (prism["outcome"], ridge["outcome"]) == ("closed", "done")
    for row, true in ((prism, 5), (ridge, 2)):
        assert row["spots_found"] == row["spots_true"] == true
        assert row["spots_wrong"] == 0
        assert row["place_max_mm"] < 2.0
        assert row["line_max_mm"] < 1.0
        assert row["force_max_n"] < 10.0
    assert (tmp_path / "seek.png").stat().st_size > 20_000
    with (tmp_path / "seek.csv").open() as file:
        spots = list(csv.DictReader(file))
    assert [spot["kind"] for spot in spots] == ["edge", *["corner"] * 5, "ridge", "end", "end"]


@pytest.mark.parametrize("wrong", [("--only", "cow"), ("--seed", -1)])
def test_impossible_wishes_are_refused_in_one_line(wrong, capsys):
    code, _, err = run(*wrong, capsys=capsys)
    assert code == 2
    assert wrong[0] in err


@pytest.mark.parametrize("name", ["box", "prism", "bend", "disc"])
def test_the_outline_is_where_the_top_ends(name):
    shape = SHAPES[name]()
    ends = np.roll(shape.outline, -1, axis=0)
    way = ends - shape.outline
    middles = shape.outline + 0.5 * way
    outward = np.column_stack([way[:, 1], -way[:, 0]])
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    for places, there in ((middles - 1e-3 * outward, True), (middles + 1e-3 * outward, False)):
        heights = top_surface(shape.thing, *places.T)
        assert np.array_equal(np.isfinite(heights), np.full(len(places), there))
        assert not there or heights == pytest.approx(0.0, abs=1e-9)
    rng = np.random.default_rng(0)
    inside = shape.outline.mean(axis=0) + rng.uniform(-0.02, 0.02, (50, 2))
    assert name == "bend" or np.isfinite(top_surface(shape.thing, *inside.T)).all()


def test_places_are_held_to_the_nearest_truth():
    box = SHAPES["box"]()
    x, y = box.corners[0]
    assert box.nearest(np.array([x - 0.01, y + 0.002]), corner=True) == pytest.approx([x, y])
    assert box.nearest(np.array([x - 0.01, y + 0.002]), corner=False) == pytest.approx(
        [x - 0.01, y]
    )
