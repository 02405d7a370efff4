"""The files of a scene: reading back, and errors for invalid files."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from eyehand.data_synth import (
    FurnishedOptions,
    TabletopOptions,
    TabletopScene,
    ViewOptions,
    make_furnished_scene,
    make_scene,
    read_ground_truth,
    read_labels,
    render_frame,
    write_scene,
)
from eyehand.data_synth.scenes import SCHEMA, read_background
from eyehand.errors import InputError
from eyehand.perception import DepthFrame
from eyehand.perception.io import read_frame

VIEW = ViewOptions(image_size=(160, 120))


@cache
def rendered_scene() -> tuple[TabletopScene, DepthFrame, NDArray[np.int32]]:
    options = TabletopOptions(family="stacked", count_range=(4, 4), view=VIEW, table_height=0.4)
    scene = make_scene(2, options)
    return (scene, *render_frame(scene))


def write_rendered_scene(folder: Path) -> TabletopScene:
    write_scene(folder, *rendered_scene())
    return rendered_scene()[0]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_rendered_scene(tmp_path / "new" / "scene")
    return tmp_path / "new" / "scene"


def test_ground_truth_is_read_back_exactly(tmp_path: Path):
    scene = write_rendered_scene(tmp_path)
    loaded = read_ground_truth(tmp_path)
    assert (loaded.seed, loaded.family, loaded.table) == (scene.seed, scene.family, scene.table)
    assert loaded.intrinsics == scene.intrinsics
    assert np.allclose(
        loaded.T_world_camera.as_matrix(), scene.T_world_camera.as_matrix(), atol=1e-15
    )
    for one, other in zip(scene.objects, loaded.objects, strict=True):
        assert (one.name, one.kind, one.mass) == (other.name, other.kind, other.mass)
        assert one.colour == other.colour
        assert one.shape.exponents == other.shape.exponents
        assert np.array_equal(one.shape.semi_axes, other.shape.semi_axes)
        assert np.array_equal(one.shape.centre, other.shape.centre)
        assert np.allclose(one.shape.rotation, other.shape.rotation, atol=1e-15)


def test_depth_and_labels_are_read_back(tmp_path: Path):
    scene, frame, labels = rendered_scene()
    files = write_scene(tmp_path, scene, frame, labels)
    loaded = read_frame(tmp_path / "depth.png")

    assert {path.name for path in files} == {path.name for path in tmp_path.iterdir()}
    assert np.abs(loaded.depth - frame.depth).max() <= 0.00051
    assert loaded.intrinsics == frame.intrinsics
    assert loaded.T_world_camera is not None
    assert loaded.colour is not None
    assert frame.colour is not None
    assert np.array_equal(loaded.colour, frame.colour)
    assert np.array_equal(read_labels(tmp_path), labels)
    assert read_labels(tmp_path / "true_labels.png").dtype == np.int32


def test_background_is_read_back_with_its_legend(tmp_path: Path):
    scene, frame, labels = rendered_scene()
    background = np.where(labels > 0, 0, 2).astype(np.uint8)
    files = write_scene(tmp_path, scene, frame, labels, background)
    read = read_background(tmp_path)
    assert read is not None
    assert np.array_equal(read, background)
    legend = json.loads((tmp_path / "ground_truth.json").read_text())["background"]["legend"]
    assert legend["2"] == "table"
    assert {path.name for path in files} == {path.name for path in tmp_path.iterdir()}
    write_scene(tmp_path, scene, frame, labels, background + 90)
    with pytest.raises(InputError, match=r"must lie in 0\.\.8, got 9"):
        read_background(tmp_path)


def test_furnished_scene_is_written_without_a_table(tmp_path: Path):
    scene = make_furnished_scene(0, FurnishedOptions("bin", (2, 2), image_size=(160, 120)))
    frame, labels = render_frame(scene)
    write_scene(tmp_path, scene, frame, labels)
    content = json.loads((tmp_path / "ground_truth.json").read_text())
    assert content["family"] == "bin"
    assert "table" not in content
    assert read_background(tmp_path) is None
    with pytest.raises(InputError, match="family must be one of"):
        read_ground_truth(tmp_path)


def test_json_names_its_schema_and_units(folder: Path):
    content = json.loads((folder / "ground_truth.json").read_text())
    assert content["schema"] == SCHEMA == "eyehand.ground_truth/1"
    assert content["seed"] == 2
    assert content["units"]["length"] == "m"
    assert [entry["label"] for entry in content["objects"]] == [1, 2, 3, 4]
    assert set(content["objects"][0]) == {
        "label",
        "name",
        "kind",
        "semi_axes_m",
        "exponents",
        "position_m",
        "quat_wxyz",
        "mass_kg",
        "colour_rgb",
    }


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (["schema"], "eyehand.ground_truth/9", "schema is 'eyehand.ground_truth/9', expected"),
        (
            ["family"],
            "heap",
            "family must be one of separate, touching, .*piled, got 'heap'",
        ),
        (["seed"], "2", "seed must be a JSON int"),
        (["objects"], {}, "objects must be a JSON list"),
        (["objects", 1], 5, "objects must hold JSON objects"),
        (["objects", 0, "semi_axes_m"], [0.1, -0.1, 0.1], "semi_axes must be 3 finite lengths"),
        (["objects", 0, "quat_wxyz"], [2, 0, 0, 0], "quat_wxyz has length 2, expected 1"),
        (["objects", 0, "position_m"], [0, 0], "must be a list of 3 finite numbers"),
        (["objects", 0, "kind"], "cone", "kind must be one of"),
        (["objects", 0, "mass_kg"], None, "mass_kg must be a number"),
        (["camera", "fx"], 0, "focal lengths must be 0.01"),
        (["camera", "T_world_camera"], None, "T_world_camera must be"),
        (["table"], None, "table must be a JSON dict"),
    ],
)
def test_invalid_entry_raises_with_file(folder: Path, path: list[Any], value: Any, message: str):
    file = folder / "ground_truth.json"
    content = json.loads(file.read_text())
    entry = content
    for key in path[:-1]:
        entry = entry[key]
    entry[path[-1]] = value
    file.write_text(json.dumps(content))
    with pytest.raises(InputError, match=message) as caught:
        read_ground_truth(file)
    assert str(file) in str(caught.value)


@pytest.mark.parametrize("text", ["", "{", "[]", "null"])
def test_file_without_ground_truth_raises(tmp_path: Path, text: str):
    file = tmp_path / "ground_truth.json"
    file.write_text(text)
    with pytest.raises(InputError, match=r"ground_truth\.json"):
        read_ground_truth(file)
    with pytest.raises(InputError, match="no such file"):
        read_ground_truth(tmp_path / "missing.json")


def test_invalid_labels_raise_before_writing(tmp_path: Path):
    scene, frame, labels = rendered_scene()
    for invalid in (labels[:-1], labels.astype(float), labels + 1, labels - 1):
        with pytest.raises(InputError, match="labels must"):
            write_scene(tmp_path / "out", scene, frame, invalid)
    assert not (tmp_path / "out").exists()


def test_file_at_path_of_folder_raises(tmp_path: Path):
    scene, frame, labels = rendered_scene()
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="cannot make the folder"):
        write_scene(tmp_path / "taken", scene, frame, labels)
