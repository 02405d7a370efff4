"""Settings chosen without a source: replaced constants, fitted log-odds, and the command."""

import json

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.segmentation import left_out, tuned_constants
from eyehand.apps.segmentation.kinds import JudgedFrame, KindOptions, Score, open_kinds
from eyehand.apps.segmentation.left_out import (
    LabelledEdges,
    edges_right,
    fit_log_odds,
    labelled_edges,
)
from eyehand.apps.segmentation.tuned_constants import (
    OTHERS,
    Constant,
    log_odds,
    replaced,
    stage_module,
)
from eyehand.data_synth import DepthNoise, TabletopOptions, make_scene, render_frame

PRIOR = Constant("join_patches", "PRIOR")


def test_every_constant_exists_and_is_a_number():
    assert PRIOR in log_odds()
    assert len(log_odds()) >= 8
    assert all(np.isfinite(constant.value()) for constant in (*log_odds(), *OTHERS))
    assert isinstance(Constant("support_plane", "CANDIDATES").scaled(1.33), int)


def test_constants_are_restored_after_an_error():
    before = PRIOR.value()
    seen = []

    def fail() -> None:
        with replaced({PRIOR: 99.0}):
            seen.append(PRIOR.value())
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert seen == [99.0]
    assert PRIOR.value() == before


def judged_stack() -> JudgedFrame:
    """Return a rendered frame of stacked objects, every pixel known."""
    scene = make_scene(4, TabletopOptions(family="stacked"))
    frame, labels = render_frame(scene, DepthNoise.realistic(), 4)
    truth = np.where(labels > 0, labels, -1).astype(np.int32)
    return JudgedFrame(frame, lambda _: Score(1.0, 1), truth)


def test_evidence_times_log_odds_is_the_weight_of_an_edge(monkeypatch):
    weights = []
    join = stage_module("join_patches")
    original = join.edge_weights

    def record(edges):
        weights.append(original(edges))
        return weights[-1]

    monkeypatch.setattr(join, "edge_weights", record)
    found = labelled_edges(judged_stack())
    present = [constant.value() for constant in log_odds()]
    assert len(found.same) > 3
    assert found.same.any()
    assert np.all(np.min(np.abs(found.evidence @ present - weights[0][:, None]), axis=0) < 1e-9)


def test_fit_separates_the_answers_of_both_sources():
    width = len(log_odds())
    rng = np.random.default_rng(0)

    def edges(count: int) -> LabelledEdges:
        evidence = np.hstack([np.ones((count, 1)), rng.uniform(0, 1, (count, width - 1))])
        return LabelledEdges(evidence, evidence[:, 1] > 0.3)

    sources = [[edges(30), edges(50)], [edges(500)]]
    odds = fit_log_odds(sources)
    values = list(odds.values())
    assert values[0] < 0 < values[1]
    assert values[1] > 3 * np.abs(values[2:]).max()
    assert edges_right([edges(200)], odds) > 0.9


def test_command_scores_each_source_with_settings_of_the_others(tmp_path, monkeypatch, capsys):
    frame, labels = render_frame(make_scene(3), DepthNoise.realistic(), 3)
    k = frame.intrinsics
    data = tmp_path / "mine"
    data.mkdir()
    camera = np.array([k.fx, k.fy, k.cx, k.cy])
    np.savez(data / "one.npz", depth=frame.depth, label=labels, intrinsics=camera)
    monkeypatch.setattr(left_out, "OTHERS", ())
    monkeypatch.setattr(left_out, "log_odds", lambda: (PRIOR,))
    words = ["--report", "left-out", "--groups", "mine", "stacked", "--dataset", str(data)]
    words += ["--frames", "1", "--out", str(tmp_path), "--json"]
    with pytest.raises(SystemExit) as ended:
        main(["evaluate", "segmentation", *words])
    assert ended.value.code == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert {(row["name"], row["source"]) for row in rows} == {
        ("mine", "mine"),
        ("stacked", "synthetic"),
    }
    assert all(0 <= row[key] <= 100 for row in rows for key in ("default_pct", "fitted_pct"))
    assert (tmp_path / "left_out.csv").is_file()


def test_one_source_is_refused(tmp_path, capsys):
    words = ["--report", "left-out", "--groups", "separate", "--frames", "1"]
    with pytest.raises(SystemExit) as ended:
        main(["evaluate", "segmentation", *words, "--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert "needs at least two sources" in capsys.readouterr().err


def test_only_changes_that_help_the_other_sources_are_chosen(monkeypatch):
    frames = open_kinds(KindOptions(kinds=("separate",), frames=1))
    other = tuned_constants.Constant("join_patches", "APART_GAIN")
    data = left_out._Data(frames, [], [])
    monkeypatch.setattr(left_out._Data, "mean_without", lambda _self, shares, _source: shares["x"])
    monkeypatch.setattr(left_out._Data, "scores", lambda _self, setting: {"x": 0.6})
    tried = {PRIOR: [(1.0, {"x": 0.4}), (2.0, {"x": 0.7})], other: [(3.0, {"x": 0.65})]}
    # Both help alone, but the second change lowers the mean when added to the first.
    assert left_out._choose(data, {"x": 0.5}, tried, "separate") == {PRIOR: 2.0}
