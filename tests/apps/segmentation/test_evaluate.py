"""`eyehand evaluate segmentation`: output, files and rejected arguments."""

import csv
import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from eyehand.data_synth import DepthNoise, TabletopOptions, make_scene, render_frame

from ..command_line import run_command

run = partial(run_command, "evaluate", "segmentation")


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    """Write three archives of one scene: two with different noise, one with wrong labels."""
    folder = tmp_path_factory.mktemp("frames")
    scene = make_scene(3, TabletopOptions(count_range=(4, 4)))
    for number in range(3):
        frame, labels = render_frame(scene, DepthNoise.realistic(0.5), number)
        if number == 2:
            labels = np.where(np.arange(640) < 320, 1, 2) * np.ones_like(labels)
        k = frame.intrinsics
        assert frame.colour is not None
        np.savez_compressed(
            folder / f"frame{number}.npz",
            depth=frame.depth,
            label=labels,
            colour=frame.colour,
            intrinsics=np.array([k.fx, k.fy, k.cx, k.cy]),
        )
    return folder


def test_scores_folder_of_frames(dataset, tmp_path, capsys):
    code, out, err = run(
        "--dataset", dataset, "--worst", 1, "--out", tmp_path, "--json", capsys=capsys
    )
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.evaluate_segmentation/1"
    assert report["seed"] is None
    assert report["options"]["window"] == 9
    (row,) = report["rows"]
    assert (row["name"], row["frames"], row["objects"]) == (dataset.name, 3, 4 + 4 + 2)
    assert 0 < row["median_ms"] <= row["p90_ms"]
    assert 1 < row["peak_mb"] < 200
    # Only the frame with wrong labels has its own line and picture.
    assert "frame2: F" in err
    assert "frame0: F" not in err
    assert [path.name for path in (tmp_path / "worst").iterdir()] == ["01_frame2.png"]
    assert (tmp_path / "worst.png").is_file()
    with (tmp_path / "frames.csv").open() as file:
        frames = {frame["name"]: frame for frame in csv.DictReader(file)}
    assert sorted(frames) == ["frame0", "frame1", "frame2"]
    assert float(frames["frame0"]["overlap_f_pct"]) > 90
    assert float(frames["frame2"]["overlap_f_pct"]) < 50
    assert "local_planes_ms" in frames["frame0"]


def test_passes_options_and_selects_frames(dataset, tmp_path, capsys):
    code, out, _ = run(
        *("--dataset", dataset, "--frames", 1, "--worst", 0, "--out", tmp_path),
        *("--min-object", 100000, "--no-join-open", "--json"),
        capsys=capsys,
    )
    assert code == 0
    report = json.loads(out)
    assert (report["options"]["min_object"], report["options"]["join_open"]) == (100000, False)
    (row,) = report["rows"]
    assert (row["frames"], row["objects"], row["found_pct"], row["missed"]) == (1, 4, 0.0, 4)
    assert not (tmp_path / "worst.png").exists()


def test_scores_synthetic_frames_by_group(tmp_path, capsys):
    code, out, err = run(
        *("--groups", "empty", "separate/1mm", "--noise", "none", "1mm"),
        *("--frames", 1, "--seed", 5, "--worst", 0, "--out", tmp_path, "--json"),
        capsys=capsys,
    )
    assert code == 0
    report = json.loads(out)
    names = [row["name"] for row in report["rows"]]
    assert names == ["empty/none", "empty/1mm", "separate/1mm", "total"]
    assert report["seed"] == 5
    assert report["rows"][0]["false"] == 0
    assert report["rows"][2]["overlap_f_pct"] > 90
    assert "separate/1mm" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--dataset", "absent"), "absent"),
        (("--groups", "floating"), "floating"),
        (("--noise", "loud"), "loud"),
        (("--frames", "0"), "--frames"),
        (("--worst", "-1"), "--worst"),
        (("--window", "8"), "window"),
        (("--labels", "other"), "labels"),
        (("--dataset", "{data}", "--groups", "no"), "no"),
        (("--dataset", "{data}", "--frames", "0"), "--frames"),
        (("--dataset", "{data}", "--depth-scale-mm", "1"), "metres"),
        (("--dataset", "{data}", "--depth-scale-mm", "-1"), "--depth-scale-mm"),
        (("--dataset", "{data}", "--camera", "absent.json"), "absent.json"),
    ],
)
def test_invalid_arguments_give_one_line_error(arguments, message, dataset, tmp_path, capsys):
    words = [word.format(data=dataset) for word in arguments]
    code, out, err = run(*words, "--out", tmp_path, "--json", capsys=capsys)
    assert (code, out) == (2, "")
    assert message in err
    lines = [line for line in err.splitlines() if line.startswith("eyehand: ")]
    assert len(lines) == 1
    assert "Traceback" not in err
