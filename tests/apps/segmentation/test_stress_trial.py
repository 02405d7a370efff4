"""Trials of the segmentation: right, wrong and invalid answers."""

import re
from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.segmentation import stress_trial
from eyehand.apps.segmentation.stress_trial import (
    BASE_NOISE,
    TrialPicture,
    timed_segment,
    try_frame,
    try_scene,
)
from eyehand.data_synth import DepthNoise
from eyehand.data_synth.render import (
    StagedObject,
    StagedScene,
    StagedView,
    render_staged,
    staged_frame,
)
from eyehand.data_synth.scenes import staged_solids as shapes
from eyehand.perception import DepthFrame, Segmentation, SupportPlane

SCENE = StagedScene(
    (
        StagedObject(shapes.box(0.09, 0.08, 0.07), (-0.1, 0.0, 0.0)),
        StagedObject(shapes.ball(0.03), (0.1, 0.0, 0.0)),
    ),
    StagedView(image_size=(320, 240)),
)
TRUTH = render_staged(SCENE, colour=False).labels


def answer(labels: np.ndarray, **more) -> Segmentation:
    return Segmentation(
        **{"labels": labels.astype(np.int32), "support": None, "noise": 0.001, "timings": {}} | more
    )


def test_true_labels_pass():
    trial = try_scene(lambda frame: answer(TRUTH), SCENE, 0)
    assert trial.passed
    assert trial.clean
    assert (trial.note, trial.score) == ("", 1.0)
    assert trial.seconds is not None
    assert isinstance(trial.picture, TrialPicture)
    assert trial.picture.scene is SCENE


@pytest.mark.parametrize(
    ("labels", "note"),
    [
        (np.zeros_like(TRUTH), "0 segments for 2 objects: 2 missed"),
        ((TRUTH > 0).astype(int), "1 segments for 2 objects: 1 merged"),
        (np.where(TRUTH == 2, 0, TRUTH), "1 segments for 2 objects: 1 missed"),
    ],
)
def test_note_names_the_mistake(labels, note):
    trial = try_scene(lambda frame: answer(labels), SCENE, 0)
    assert not trial.passed
    assert trial.clean
    assert trial.note == note


def test_note_names_split_object():
    half = TRUTH.copy()
    rows = np.nonzero(TRUTH == 1)[0]
    half[(TRUTH == 1) & (np.arange(240)[:, None] > np.median(rows) + 5)] = 3
    # Largest first.
    order = np.argsort(-np.bincount(half.ravel())[1:]) + 1
    half = np.select([half == label for label in order], [1, 2, 3], 0)
    trial = try_scene(lambda frame: answer(half), SCENE, 0)
    assert trial.note == "3 segments for 2 objects: 1 split"


def test_pixels_without_reading_do_not_count():
    frame, truth = staged_frame(SCENE, BASE_NOISE, 0)
    lost = truth.copy()
    # The smaller object keeps only a few rows.
    rows = np.nonzero(truth == 2)[0]
    lost[: int(np.quantile(rows, 0.9))] = 0
    depth = np.where((truth == 2) & (lost == 0), np.float32(0), frame.depth)
    kept = np.where(depth > 0, truth, 0)
    assert try_frame(lambda _: answer(kept), replace(frame, depth=depth), truth).passed


def test_merged_pair_passes_only_if_allowed_and_marked_ambiguous():
    merged = (TRUTH > 0).astype(np.int32)
    marked = Segmentation(merged, None, 0.001, {}, {1: "flush faces"})
    assert try_scene(lambda frame: marked, SCENE, 0, ambiguous=True).passed
    assert not try_scene(lambda frame: marked, SCENE, 0).passed
    assert not try_scene(lambda frame: answer(merged), SCENE, 0, ambiguous=True).passed
    # The mark does not excuse a false object.
    extra = TRUTH.copy()
    extra[:5, :5] = 3
    false_object = Segmentation(extra, None, 0.001, {}, {1: "flush faces"})
    assert not try_scene(lambda frame: false_object, SCENE, 0, ambiguous=True).passed


def test_dropout_removes_requested_share():
    frames: list[DepthFrame] = []

    def record(frame: DepthFrame) -> Segmentation:
        frames.append(frame)
        return answer(TRUTH)

    try_scene(record, SCENE, 0, DepthNoise.none(), dropout=0.3)
    clean, _ = staged_frame(SCENE)
    assert frames[0].valid.sum() / clean.valid.sum() == pytest.approx(0.7, abs=0.01)


@pytest.mark.parametrize(
    ("found", "fault"),
    [
        (answer(TRUTH[:-1]), r"labels are \(239, 320\) int32"),
        (answer(TRUTH * 2), "labels are not 1..n"),
        (answer(3 - TRUTH), "labels are not 1..n"),
        (answer(-TRUTH), "labels are not 1..n"),
        (answer(TRUTH, noise=np.nan), "NaN"),
        (answer(TRUTH, timings={"grow": np.inf}), "NaN"),
        (answer(TRUTH, support=SupportPlane(np.full(3, np.nan), 0.0)), "NaN"),
    ],
)
def test_invalid_answer_is_unclean(found, fault):
    trial = try_scene(lambda frame: found, SCENE, 0)
    assert not trial.passed
    assert not trial.clean
    assert re.search(fault, trial.note)


def test_slow_answer_is_unclean(monkeypatch):
    monkeypatch.setattr(stress_trial, "MAX_SECONDS", -1.0)
    frame, _ = staged_frame(SCENE)
    _, seconds, fault = timed_segment(lambda frame: answer(TRUTH), frame)
    assert seconds >= 0
    assert fault.startswith("took")
