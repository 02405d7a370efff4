"""Kinds of development data: their frames, scores by kind, and the command."""

import json
from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.segmentation.kinds import (
    KindFrame,
    KindOptions,
    Score,
    open_kinds,
    score_by_kind,
    worst_kinds_mean,
)
from eyehand.apps.segmentation.point_frames import PointFrame, frames_by_camera
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame

CAMERA = CameraIntrinsics(50.0, 50.0, 10.0, 5.0, 20, 10)


def of_kind(kind: str) -> KindFrame:
    return KindFrame("frame", kind, kind, lambda: pytest.fail("not needed"))


def test_scores_are_shares_of_all_objects_of_a_kind_worst_first():
    frames = [of_kind("table"), of_kind("bin"), of_kind("bin")]
    shares = score_by_kind(frames, [Score(0.9, 1), Score(3, 4), Score(0, 6)])
    assert list(shares.items()) == [("bin", 0.3), ("table", 0.9)]


def test_accuracy_is_the_mean_of_the_three_worst_kinds():
    assert worst_kinds_mean({"a": 0.9, "b": 0.3, "c": 0.5, "d": 0.7}) == pytest.approx(0.5)
    assert worst_kinds_mean({"a": 0.9}) == 0.9


def test_annotated_frames_of_one_camera_are_one_kind():
    other = replace(CAMERA, fx=60.0)
    frames = [
        PointFrame(name, DepthFrame(np.ones((10, 20), np.float32), camera), None, {},
                   np.zeros((0, 2), np.intp), np.zeros((10, 20), bool))
        for name, camera in (("cell_a_0", CAMERA), ("cell_b_3", CAMERA), ("room7", other))
    ]  # fmt: skip
    names = {kind: [f.name for f in own] for kind, own in frames_by_camera(frames).items()}
    assert names == {"cell": ["cell_a_0", "cell_b_3"], "room": ["room7"]}


def test_kinds_without_data_are_left_out_and_unknown_ones_refused():
    frames = open_kinds(KindOptions(kinds=("separate", "empty"), frames=2))
    assert [frame.kind for frame in frames] == ["separate"] * 2 + ["empty"] * 2
    assert {frame.source for frame in frames} == {"synthetic"}
    judged = frames[0].load()
    assert judged.judge(np.maximum(judged.truth, 0)) == (1.0, 1)
    with pytest.raises(InputError, match="--kinds gq_phoxi: no such kind"):
        open_kinds(KindOptions(kinds=("gq_phoxi",)))
    with pytest.raises(InputError, match="--frames"):
        KindOptions(frames=0)


def test_command_reports_every_kind_worst_first(tmp_path, capsys):
    words = ["--report", "kinds", "--groups", "separate", "empty", "--frames", "1"]
    with pytest.raises(SystemExit) as ended:
        main(["evaluate", "segmentation", *words, "--out", str(tmp_path), "--json"])
    assert ended.value.code == 0
    report = json.loads(capsys.readouterr().out)
    assert report["schema"] == "eyehand.evaluate_segmentation_kinds/1"
    names = [row["name"] for row in report["rows"]]
    assert names == ["separate", "empty", "mean of the three worst", "mean of all kinds"]
    assert report["rows"][1]["score_pct"] == 100.0
    assert (tmp_path / "kinds.csv").is_file()
    lines = (tmp_path / "kinds.md").read_text().splitlines()
    assert lines[0].startswith("| kind | source | frames | score % |")
    assert lines[3].startswith("| empty | synthetic | 1 | 100.0 | 100.0 |")
