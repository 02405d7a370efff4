"""`eyehand synth`: families, empty tables and rejected input."""

import json

import numpy as np
import pytest

from eyehand.data_synth.scenes import hull_mesh, read_background
from eyehand.perception import read_frame

from .command_line import run_command as run


@pytest.mark.parametrize("family", ["dropped", "piled"])
def test_synth_makes_the_named_family(tmp_path, capsys, family):
    arguments = ["synth", "--family", family, "--objects", "2", "--out", tmp_path, "--json"]
    code, out, _ = run(*arguments, capsys=capsys)
    assert code == 0
    assert len(json.loads(out)["rows"]) == 2
    assert json.loads((tmp_path / "ground_truth.json").read_text())["family"] == family


def test_zero_objects_give_an_empty_table(tmp_path, capsys):
    code, out, _ = run("synth", "--objects", "0", "--out", tmp_path, "--json", capsys=capsys)
    assert code == 0
    assert json.loads(out)["rows"] == []


def test_furnished_scene_has_background_and_sensor(tmp_path, capsys):
    arguments = ["synth", "--family", "tray", "--sensor", "stereo", "--out", tmp_path, "--json"]
    code, out, _ = run(*arguments, capsys=capsys)
    assert code == 0
    assert 3 <= len(json.loads(out)["rows"]) <= 9
    truth = json.loads((tmp_path / "ground_truth.json").read_text())
    legend = truth["background"]["legend"]
    background = read_background(tmp_path)
    assert background is not None
    numbers = set(np.unique(background))
    assert {legend[str(n)] for n in numbers - {0}} >= {"table", "container_floor"}
    depth = read_frame(tmp_path / "depth.png").depth
    # Active stereo reads nothing at the left edge, the default noise does.
    assert np.all(depth[:, :5] == 0)


def test_meshes_take_the_place_of_solids(tmp_path, capsys):
    folder = tmp_path / "meshes"
    folder.mkdir()
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.05
    faces = hull_mesh(corners)
    lines = [f"v {x} {y} {z}" for x, y, z in faces[0]]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces[1]]
    (folder / "cube.obj").write_text("\n".join(lines))
    arguments = ["synth", "--family", "small-table", "--objects", "2", "--meshes", folder]
    code, out, _ = run(*arguments, "--out", tmp_path / "new", "--json", capsys=capsys)
    assert code == 0
    rows = json.loads(out)["rows"]
    assert [row["kind"] for row in rows] == ["mesh", "mesh"]
    assert rows[0]["size_mm"] == pytest.approx([50, 50, 50])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--family", "piled", "--objects", "1"], "2 to 15 for the family piled, got 1"),
        (["--family", "dropped", "--objects", "0"], "1 to 15 for the family dropped, got 0"),
        (["--family", "heaped"], "heaped"),
        (["--family", "bin", "--objects", "99"], "0 to 40 for the family bin, got 99"),
        (["--arm"], "--arm needs a family of bin"),
        (["--meshes", "."], "--meshes needs a family of bin"),
        (["--sensor", "lidar"], "lidar"),
    ],
)
def test_invalid_family_or_count_is_rejected(tmp_path, capsys, arguments, message):
    code, out, err = run("synth", *arguments, "--out", tmp_path / "none", capsys=capsys)
    assert code == 2
    assert out == ""
    assert message in err
    assert not (tmp_path / "none").exists()
