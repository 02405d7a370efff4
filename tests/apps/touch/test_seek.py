"""The experiment `seek`, and the true outlines of its objects."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.touch.seek_shapes import SHAPES
from eyehand.data_synth.pad import top_surface


def test_corners_of_prism_and_ends_of_ridge_are_found(tmp_path, run_experiment):
    code, out, _ = run_experiment(
        "seek", "--only", "prism", "ridge", "--quick", "--seed", 5, "--json", "--out", tmp_path
    )
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_seek/1"
    prism, ridge = report["rows"]
    assert (prism["outcome"], ridge["outcome"]) == ("closed", "done")
    for row, count in ((prism, 5), (ridge, 2)):
        assert row["spots_found"] == row["spots_true"] == count
        assert row["spots_wrong"] == 0
        assert row["place_max_mm"] < 2.0
        assert row["line_max_mm"] < 1.0
        assert row["force_max_n"] < 10.0
    assert (tmp_path / "seek.png").stat().st_size > 20_000
    with (tmp_path / "seek.csv").open() as file:
        spots = list(csv.DictReader(file))
    assert [spot["kind"] for spot in spots] == ["edge", *["corner"] * 5, "ridge", "end", "end"]


@pytest.mark.parametrize("name", ["box", "prism", "bend", "disc"])
def test_outline_is_border_of_top_face(name):
    shape = SHAPES[name]()
    sides = np.roll(shape.outline, -1, axis=0) - shape.outline
    middles = shape.outline + 0.5 * sides
    outward = np.column_stack([sides[:, 1], -sides[:, 0]])
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    for points, is_inside in ((middles - 1e-3 * outward, True), (middles + 1e-3 * outward, False)):
        heights = top_surface(shape.touch_object, *points.T)
        assert np.array_equal(np.isfinite(heights), np.full(len(points), is_inside))
        assert not is_inside or heights == pytest.approx(0.0, abs=1e-9)
    rng = np.random.default_rng(0)
    inside = shape.outline.mean(axis=0) + rng.uniform(-0.02, 0.02, (50, 2))
    assert name == "bend" or np.isfinite(top_surface(shape.touch_object, *inside.T)).all()


def test_nearest_returns_closest_corner_or_rim_point():
    box = SHAPES["box"]()
    x, y = box.corners[0]
    assert box.nearest(np.array([x - 0.01, y + 0.002]), corner=True) == pytest.approx([x, y])
    assert box.nearest(np.array([x - 0.01, y + 0.002]), corner=False) == pytest.approx(
        [x - 0.01, y]
    )
