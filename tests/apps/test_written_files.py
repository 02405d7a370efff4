"""The JSON files that commands write are those of the documented schema."""

import json
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator, ValidationError

from eyehand.apps.main import main
from eyehand.perception import write_cloud

from ..file_schema import SCHEMA, check_file

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "apps" / "sample" / "depth.png"
HANDS = ROOT / "grasping" / "hands" / "descriptions"


def run(*words: object) -> None:
    with pytest.raises(SystemExit) as exit_info:
        main([*map(str, words)])
    assert exit_info.value.code in (0, 1)


@pytest.fixture(scope="module")
def tote(tmp_path_factory) -> Path:
    """Return the folder of a synthetic tote with objects."""
    folder = tmp_path_factory.mktemp("files") / "tote"
    run("synth", "--family", "tote", "--seed", 1, "--out", folder)
    return folder


def test_schema_is_valid():
    Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("family", ["dropped", "tote"])
def test_synthetic_scenes_have_their_schema(family, tmp_path):
    run("synth", "--family", family, "--seed", 1, "--out", tmp_path)
    check_file(tmp_path / "ground_truth.json", "ground_truth")
    check_file(tmp_path / "depth.json", "camera")


def test_perceived_scenes_have_their_schema(tote, tmp_path):
    run("perceive", SAMPLE, "--out", tmp_path / "sample")
    check_file(tmp_path / "sample" / "scene.json", "scene")
    run("perceive", tote / "depth.png", "--out", tmp_path / "tote")
    scene = json.loads((tmp_path / "tote" / "scene.json").read_text())
    assert scene["containers"]
    assert scene["objects"]
    check_file(scene, "scene")


def test_grasps_have_their_schema(tote, tmp_path, capsys):
    run("grasp", tote / "depth.png", "--hand", "panda", "--table-height", 0, "--out", tmp_path)
    grasps = json.loads((tmp_path / "grasps.json").read_text())
    assert grasps["rows"]
    check_file(grasps, "grasps")
    capsys.readouterr()
    run("grasp", SAMPLE, "--stroke", 85, "--json")
    check_file(json.loads(capsys.readouterr().out), "grasps")


def test_solids_have_their_schema(tmp_path):
    ball = np.random.default_rng(0).normal(size=(300, 3))
    write_cloud(tmp_path / "ball.ply", 0.04 * ball / np.linalg.norm(ball, axis=1, keepdims=True))
    for words in ([], ["--view-origin", 0, 0, 1, "--plane", 0, 0, 1, 0.04]):
        run("fit", tmp_path / "ball.ply", *words, "--out", tmp_path)
        check_file(tmp_path / "ball_solid.json", "solid_file")


def test_described_hands_have_their_schema():
    schema = json.loads((HANDS / "schema.json").read_text())
    for file in HANDS.glob("*.json"):
        if file.stem != "schema":
            Draft202012Validator(schema).validate(json.loads(file.read_text()))


def test_unknown_missing_and_odd_members_are_found(tote):
    truth = json.loads((tote / "ground_truth.json").read_text())
    check_file(truth, "ground_truth")
    odd = [
        {**truth, "more": 1},
        {**truth, "seed": "1"},
        {k: truth[k] for k in truth if k != "seed"},
    ]
    for content in odd:
        with pytest.raises(ValidationError):
            check_file(content, "ground_truth")


def test_published_schema_accepts_members_of_later_versions(tote):
    truth = json.loads((tote / "ground_truth.json").read_text())
    published = Draft202012Validator({"$ref": "#/$defs/ground_truth", "$defs": SCHEMA["$defs"]})
    published.validate({**truth, "more": 1})
