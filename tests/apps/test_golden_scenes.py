"""Synthetic scenes by seed: what a whole look finds, held to what was promised."""

import numpy as np
import pytest

from eyehand.apps.segmentation.score import score_segmentation
from eyehand.data_synth import DepthNoise, TabletopOptions, make_scene, render_frame
from eyehand.perception import perceive

SEEDS = range(100, 120)
FIVE = TabletopOptions(count_range=(5, 5))


def look(seed, noise):
    scene = make_scene(seed, FIVE)
    frame, truth = render_frame(scene, noise, seed, colour=False)
    return scene, perceive(frame), truth


@pytest.mark.parametrize(
    ("noise", "least_f"), [(DepthNoise.none(), 0.85), (DepthNoise.realistic(), 0.85)]
)
def test_twenty_scenes_of_five_separate_objects_are_found(noise, least_f):
    scores = []
    for seed in SEEDS:
        _, seen, truth = look(seed, noise)
        scores.append(score_segmentation(seen.segmentation.labels, truth).f)
        for item in seen.objects:
            if item.fit:
                assert item.fit.superquadric is not None
                assert np.all(np.isfinite(item.fit.superquadric.pose.as_matrix()))
    assert np.mean(scores) >= least_f
    assert min(scores) > 0.6


def test_solids_have_the_size_and_place_of_the_objects_they_stand_for():
    size, place = [], []
    for seed in SEEDS[:8]:
        scene, seen, truth = look(seed, DepthNoise.realistic())
        for item in seen.objects:
            number = int(np.bincount(truth[seen.segmentation.mask(item.label)]).argmax())
            solid = item.fit.superquadric
            if number == 0 or solid is None or item.visible_share < 0.7:
                continue
            true = scene.objects[number - 1].shape
            size.append(abs(np.cbrt(solid.volume / true.volume) - 1))
            place.append(float(np.linalg.norm(solid.centre - true.centre)))
    assert len(size) >= 30
    assert np.median(size) < 0.06
    assert np.median(place) < 0.006


@pytest.mark.parametrize(("family", "least"), [("separate", 1.0), ("stacked", 0.85)])
def test_what_stands_on_what_is_told(family, least):
    right = total = 0
    for seed in range(300, 306):
        scene = make_scene(seed, TabletopOptions(family=family, count_range=(6, 6)))
        frame, truth = render_frame(scene, DepthNoise.realistic(), seed, colour=False)
        seen = perceive(frame)
        for item in seen.objects:
            number = int(np.bincount(truth[seen.segmentation.mask(item.label)]).argmax())
            if number == 0:
                continue
            bottom = -float(scene.objects[number - 1].shape.support([0.0, 0.0, -1.0]))
            right += ((item.rests_on or 0) > 0) == (bottom > 0.01)
            total += 1
    assert total >= 30
    assert right / total >= least
