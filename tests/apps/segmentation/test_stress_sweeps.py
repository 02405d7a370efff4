"""Test that every staged scene is solvable: its objects are visible and placed as specified."""

import time

import cv2
import numpy as np
import pytest

from eyehand.apps.bench import Sweep
from eyehand.apps.bench.sweep import select_sweeps
from eyehand.apps.segmentation.camera_sweeps import AGREEMENT_SWEEPS
from eyehand.apps.segmentation.furnished_sweeps import FURNISHED_SWEEPS
from eyehand.apps.segmentation.stress import SEGMENTATION_SWEEPS
from eyehand.apps.segmentation.stress_trial import TrialPicture
from eyehand.data_synth.render import StagedScene
from eyehand.errors import InputError
from eyehand.perception import DepthFrame, Segmentation

MIN_VISIBLE_PX = 25
"""Minimum number of visible pixels of every object within the bound."""
COUNTS = {"empty": 0, "grazing": 3, "in-bowl": 3} | dict.fromkeys(
    ("noise", "kinect", "dropout", "holes", "image-size", "repeat"), 5
)
"""Number of objects in the scenes of a sweep. The others have two."""
STAGED = [
    sweep
    for sweep in SEGMENTATION_SWEEPS
    if sweep not in (*AGREEMENT_SWEEPS, *FURNISHED_SWEEPS)
    and sweep.name
    not in ("millimetres", "nan", "readings", "tiny-image", "tiny-objects", "chaos", "repeat")
]


def find_nothing(frame: DepthFrame) -> Segmentation:
    """Find no object."""
    return Segmentation(np.zeros(frame.depth.shape, np.int32), None, 0.001, {})


def trial_picture(sweep: Sweep, value: float, seed: int = 0) -> TrialPicture:
    """Return frame and truth of a trial."""
    picture = sweep.attempt(value, seed, find_nothing).picture
    assert isinstance(picture, TrialPicture)
    return picture


def scene_of(name: str, value: float, seed: int = 0) -> StagedScene:
    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, [name])
    scene = trial_picture(sweep, value, seed).scene
    assert scene is not None
    return scene


def test_sweeps_have_unique_names_and_descriptions():
    sweeps = SEGMENTATION_SWEEPS
    assert len({sweep.name for sweep in sweeps}) == len(sweeps) >= 25
    assert all(sweep.axis and sweep.right for sweep in sweeps)


def test_selects_sweeps_by_name_and_rejects_unknown_names():
    selected = select_sweeps(SEGMENTATION_SWEEPS, ["mug", "noise"])
    assert [sweep.name for sweep in selected] == ["noise", "mug"]
    with pytest.raises(InputError, match=r"'cup'.*noise, kinect"):
        select_sweeps(SEGMENTATION_SWEEPS, ["cup"])


@pytest.mark.parametrize("sweep", STAGED, ids=lambda sweep: sweep.name)
def test_all_objects_are_visible_within_bound(sweep: Sweep):
    bound = (*sweep.values[:1], *sweep.required_values())[-1]
    for seed, value in ((0, sweep.values[0]), (1, bound)):
        truth = trial_picture(sweep, value, seed).truth
        sizes = np.bincount(truth.ravel())[1:]
        assert len(sizes) == COUNTS.get(sweep.name, 2)
        assert np.all(sizes >= MIN_VISIBLE_PX)


@pytest.mark.parametrize("sweep", STAGED[:3], ids=lambda sweep: sweep.name)
def test_trial_depends_on_value_and_seed_only(sweep: Sweep):
    first, again = (trial_picture(sweep, sweep.values[1], 3) for _ in range(2))
    assert np.array_equal(first.frame.depth, again.frame.depth)
    assert not np.array_equal(
        first.frame.depth, trial_picture(sweep, sweep.values[1], 4).frame.depth
    )


@pytest.mark.parametrize("gap", [0, 6])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_leaning_box_leaves_gap_and_touches_table(gap, seed):
    leaning, upright = scene_of("lean", gap, seed).objects
    tall = leaning.solid.height
    top = leaning.rotation.apply([0.015, 0.0, tall]) + leaning.at
    foot = leaning.rotation.apply([0.015, 0.0, 0.0]) + leaning.at
    assert upright.at[0] - 0.03 - top[0] == pytest.approx(gap * 1e-3, abs=1e-9)
    assert foot[2] == pytest.approx(0.0, abs=1e-9)
    assert top[2] < upright.solid.height


@pytest.mark.parametrize("diameter", [80, 60, 30, 10])
def test_ball_touches_bowl_without_penetration(diameter):
    inner = scene_of("in-bowl", diameter).objects[2]
    middle = inner.at[2] + diameter * 5e-4
    angle = np.linspace(0, np.pi / 2, 100_000)
    across, up = 0.076 * np.sin(angle), 0.05 - 0.046 * np.cos(angle)
    nearest = np.hypot(across, up - middle).min()
    assert nearest == pytest.approx(diameter * 5e-4, abs=2e-6)


@pytest.mark.parametrize("seed", [0, 1])
def test_border_cuts_requested_share(seed):
    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, ["border"])
    whole = np.count_nonzero(trial_picture(sweep, 0, seed).truth == 1)
    for share in (40, 80):
        truth = trial_picture(sweep, share, seed).truth
        left = np.count_nonzero(truth == 1)
        assert left / whole == pytest.approx(1 - share / 100, abs=0.03)
        # The other object stays complete.
        assert np.count_nonzero(truth == 2) == np.count_nonzero(
            trial_picture(sweep, 0, seed).truth == 2
        )


def test_bar_splits_hidden_object_in_two():
    for name in ("occluded-box", "occluded-roll"):
        (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, [name])
        for value in sweep.values[::3]:
            behind = (trial_picture(sweep, value).truth == 1).astype(np.uint8)
            assert cv2.connectedComponents(behind)[0] - 1 == 2


def test_flush_boxes_have_specified_colours():
    same, other = select_sweeps(SEGMENTATION_SWEEPS, ["flush", "flush-colour"])
    for sweep, differs in ((same, False), (other, True)):
        picture = trial_picture(sweep, 0)
        assert picture.frame.colour is not None
        assert picture.scene is not None
        one, two = picture.scene.objects
        assert (one.colour != two.colour) == differs
        # Fronts and tops are flush.
        assert one.at[1] == two.at[1]
        assert one.solid.height == two.solid.height


def test_number_of_studs_is_as_requested():
    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, ["tiny-objects"])
    for count in (100, 1000, 16_000):
        assert len(np.unique(trial_picture(sweep, count).truth)) - 1 == count


def test_slow_cluttered_frame_fails():
    def segment_slowly(frame: DepthFrame) -> Segmentation:
        # Ordinary frames have a camera pose, cluttered frames have none.
        time.sleep(0.001 if frame.T_world_camera is not None else 0.8)
        return find_nothing(frame)

    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, ["chaos"])
    trial = sweep.attempt(100, 0, segment_slowly)
    assert not trial.passed
    assert trial.clean
    assert "times as long" in trial.note


def test_false_objects_from_few_readings_fail():
    def find_one(frame: DepthFrame) -> Segmentation:
        return Segmentation(np.ones(frame.depth.shape, np.int32), None, 0.001, {})

    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, ["readings"])
    trial = sweep.attempt(10, 0, find_one)
    assert (trial.passed, trial.note) == (False, "1 false objects")


@pytest.mark.parametrize(("name", "value", "count"), [("rim", 10, 4), ("table-size", 150, 1)])
def test_boxes_on_furniture_are_visible(name, value, count):
    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, [name])
    sizes = np.bincount(trial_picture(sweep, value).truth.ravel())
    assert len(sizes) == count + 1
    assert sizes[1:].min() > MIN_VISIBLE_PX
