"""Accuracy of perception on synthetic scenes with fixed seeds."""

import numpy as np
import pytest

from eyehand.apps.segmentation.score import score_segmentation
from eyehand.data_synth import DepthNoise, TabletopOptions, make_scene, render_frame
from eyehand.perception import perceive

SEEDS = range(100, 120)
FIVE = TabletopOptions(count_range=(5, 5))


def perceive_scene(seed, noise):
    scene = make_scene(seed, FIVE)
    frame, truth = render_frame(scene, noise, seed, colour=False)
    return scene, perceive(frame), truth


@pytest.mark.parametrize(
    ("noise", "min_f"), [(DepthNoise.none(), 0.85), (DepthNoise.realistic(), 0.85)]
)
def test_separate_objects_are_segmented(noise, min_f):
    scores = []
    for seed in SEEDS:
        _, perceived, truth = perceive_scene(seed, noise)
        scores.append(score_segmentation(perceived.segmentation.labels, truth).f)
        for item in perceived.objects:
            if item.fit:
                assert item.fit.superquadric is not None
                assert np.all(np.isfinite(item.fit.superquadric.pose.as_matrix()))
    assert np.mean(scores) >= min_f
    assert min(scores) > 0.6


def test_solids_have_the_size_and_position_of_the_objects():
    size, place = [], []
    for seed in SEEDS[:8]:
        scene, perceived, truth = perceive_scene(seed, DepthNoise.realistic())
        for item in perceived.objects:
            number = int(np.bincount(truth[perceived.segmentation.mask(item.label)]).argmax())
            solid = item.fit.superquadric
            if number == 0 or solid is None or item.visible_share < 0.7:
                continue
            true = scene.objects[number - 1].shape
            size.append(abs(np.cbrt(solid.volume / true.volume) - 1))
            place.append(float(np.linalg.norm(solid.centre - true.centre)))
    assert len(size) >= 30
    assert np.median(size) < 0.06
    assert np.median(place) < 0.006


@pytest.mark.parametrize(("family", "min_share"), [("separate", 1.0), ("stacked", 0.85)])
def test_supporting_object_is_reported(family, min_share):
    right = total = 0
    for seed in range(300, 306):
        scene = make_scene(seed, TabletopOptions(family=family, count_range=(6, 6)))
        frame, truth = render_frame(scene, DepthNoise.realistic(), seed, colour=False)
        perceived = perceive(frame)
        for item in perceived.objects:
            number = int(np.bincount(truth[perceived.segmentation.mask(item.label)]).argmax())
            if number == 0:
                continue
            bottom = -float(scene.objects[number - 1].shape.support([0.0, 0.0, -1.0]))
            right += ((item.rests_on or 0) > 0) == (bottom > 0.01)
            total += 1
    assert total >= 30
    assert right / total >= min_share
