"""Every staged task can be done: what is to be found is in view, and stands where it should."""

import time

import cv2
import numpy as np
import pytest

from eyehand.apps.bench import Sweep
from eyehand.apps.bench.sweep import select_sweeps
from eyehand.apps.segmentation.stress_sweeps import SEGMENTATION_SWEEPS
from eyehand.apps.segmentation.stress_trial import TrialPicture
from eyehand.data_synth.render import StagedScene
from eyehand.errors import InputError
from eyehand.perception import DepthFrame, Segmentation

LEAST_PX = 25
"""Pixels that every object of a task within its bound shows at least."""
COUNTS = {"empty": 0, "grazing": 3, "in-bowl": 3} | dict.fromkeys(
    ("noise", "kinect", "dropout", "holes", "image-size", "repeat"), 5
)
"""Objects of a sweep's scenes; others have two."""
STAGED = [
    sweep
    for sweep in SEGMENTATION_SWEEPS
    if sweep.name
    not in ("millimetres", "nan", "readings", "tiny-image", "tiny-objects", "chaos", "repeat")
]


def nothing(frame: DepthFrame) -> Segmentation:
    """Find no object."""
    return Segmentation(np.zeros(frame.depth.shape, np.int32), None, 0.001, {})


def look(sweep: Sweep, value: float, seed: int = 0) -> TrialPicture:
    """What a trial shows to the method."""
    picture = sweep.attempt(value, seed, nothing).picture
    assert isinstance(picture, TrialPicture)
    return picture


def scene_of(name: str, value: float, seed: int = 0) -> StagedScene:
    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, [name])
    scene = look(sweep, value, seed).scene
    assert scene is not None
    return scene


def test_sweeps_have_unique_names_and_state_what_is_right():
    sweeps = SEGMENTATION_SWEEPS
    assert len({sweep.name for sweep in sweeps}) == len(sweeps) >= 25
    assert all(sweep.axis and sweep.right for sweep in sweeps)


def test_sweeps_can_be_chosen_by_name_and_unknown_ones_are_refused():
    selected = select_sweeps(SEGMENTATION_SWEEPS, ["mug", "noise"])
    assert [sweep.name for sweep in selected] == ["noise", "mug"]
    with pytest.raises(InputError, match=r"'cup'.*noise, kinect"):
        select_sweeps(SEGMENTATION_SWEEPS, ["cup"])


@pytest.mark.parametrize("sweep", STAGED, ids=lambda sweep: sweep.name)
def test_all_objects_are_in_view_wherever_the_bound_asks_for_them(sweep: Sweep):
    bound = (*sweep.values[:1], *sweep.required_values())[-1]
    for seed, value in ((0, sweep.values[0]), (1, bound)):
        truth = look(sweep, value, seed).truth
        sizes = np.bincount(truth.ravel())[1:]
        assert len(sizes) == COUNTS.get(sweep.name, 2)
        assert np.all(sizes >= LEAST_PX)


@pytest.mark.parametrize("sweep", STAGED[:3], ids=lambda sweep: sweep.name)
def test_trial_depends_on_value_and_seed_only(sweep: Sweep):
    first, again = (look(sweep, sweep.values[1], 3) for _ in range(2))
    assert np.array_equal(first.frame.depth, again.frame.depth)
    assert not np.array_equal(first.frame.depth, look(sweep, sweep.values[1], 4).frame.depth)


@pytest.mark.parametrize("gap", [0, 6])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_leaning_box_ends_at_the_gap_beside_the_other_and_stands_on_the_table(gap, seed):
    leaning, upright = scene_of("lean", gap, seed).objects
    tall = leaning.solid.height
    top = leaning.rotation.apply([0.015, 0.0, tall]) + leaning.at
    foot = leaning.rotation.apply([0.015, 0.0, 0.0]) + leaning.at
    assert upright.at[0] - 0.03 - top[0] == pytest.approx(gap * 1e-3, abs=1e-9)
    assert foot[2] == pytest.approx(0.0, abs=1e-9)
    assert top[2] < upright.solid.height


@pytest.mark.parametrize("diameter", [80, 60, 30, 10])
def test_a_ball_touches_its_bowl_and_does_not_enter_it(diameter):
    inner = scene_of("in-bowl", diameter).objects[2]
    middle = inner.at[2] + diameter * 5e-4
    angle = np.linspace(0, np.pi / 2, 100_000)
    across, up = 0.076 * np.sin(angle), 0.05 - 0.046 * np.cos(angle)
    nearest = np.hypot(across, up - middle).min()
    assert nearest == pytest.approx(diameter * 5e-4, abs=2e-6)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_border_cuts_off_the_share_asked_for(seed):
    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, ["border"])
    whole = np.count_nonzero(look(sweep, 0, seed).truth == 1)
    for share in (40, 80):
        truth = look(sweep, share, seed).truth
        left = np.count_nonzero(truth == 1)
        assert left / whole == pytest.approx(1 - share / 100, abs=0.03)
        # What stands beside it stays whole.
        assert np.count_nonzero(truth == 2) == np.count_nonzero(look(sweep, 0, seed).truth == 2)


def test_a_bar_cuts_what_is_behind_it_in_two():
    for name in ("occluded-box", "occluded-roll"):
        (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, [name])
        for value in sweep.values[::3]:
            behind = (look(sweep, value).truth == 1).astype(np.uint8)
            assert cv2.connectedComponents(behind)[0] - 1 == 2


def test_flush_boxes_differ_in_colour_only_where_they_should():
    same, other = select_sweeps(SEGMENTATION_SWEEPS, ["flush", "flush-colour"])
    for sweep, differs in ((same, False), (other, True)):
        picture = look(sweep, 0)
        assert picture.frame.colour is not None
        assert picture.scene is not None
        one, two = picture.scene.objects
        assert (one.colour != two.colour) == differs
        # Fronts and tops are flush.
        assert one.at[1] == two.at[1]
        assert one.solid.height == two.solid.height


def test_studs_are_as_many_as_asked_for():
    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, ["tiny-objects"])
    for count in (100, 1000, 16_000):
        assert len(np.unique(look(sweep, count).truth)) - 1 == count


def test_slow_clutter_fails_its_sweep():
    def slow_on_clutter(frame: DepthFrame) -> Segmentation:
        # Ordinary frames here have a place in the world, clutter has none.
        time.sleep(0.001 if frame.T_world_camera is not None else 0.8)
        return nothing(frame)

    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, ["chaos"])
    trial = sweep.attempt(100, 0, slow_on_clutter)
    assert not trial.passed
    assert trial.clean
    assert "times as long" in trial.note


def test_objects_made_up_from_few_readings_fail_their_sweep():
    def everything(frame: DepthFrame) -> Segmentation:
        return Segmentation(np.ones(frame.depth.shape, np.int32), None, 0.001, {})

    (sweep,) = select_sweeps(SEGMENTATION_SWEEPS, ["readings"])
    trial = sweep.attempt(10, 0, everything)
    assert (trial.passed, trial.note) == (False, "1 false objects")
