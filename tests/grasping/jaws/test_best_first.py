"""Grasps that are found best first equal those of an exhaustive test of all candidates."""

from __future__ import annotations

import numpy as np
import pytest
from jaw_scenes import bowl, box, can, scene_of
from scipy.spatial.transform import Rotation

from eyehand.grasping import JawOptions, load_hand, plan_grasps
from eyehand.grasping.jaws import best_first
from eyehand.grasping.jaws.symmetry import distinct, repeats

PANDA = load_hand("panda")


@pytest.mark.parametrize(
    "options", [JawOptions(), JawOptions(full_opening=True, guarded=True, depth_error=0.005)]
)
def test_few_at_once_find_the_best_of_all_at_once(options, monkeypatch):
    scene = scene_of(
        box((0.05, 0.06, 0.08)),
        can(0.03, 0.1, (0.09, 0.0), label=2),
        bowl(0.05, 0.07, 0.004, (-0.13, 0.02), label=3),
    )
    monkeypatch.setattr(best_first, "STEP", 10**6)
    exhaustive = plan_grasps(scene, PANDA, options)
    monkeypatch.setattr(best_first, "STEP", 4)
    found = plan_grasps(scene, PANDA, options)
    for label in (1, 2, 3):
        expected = next(grasp for grasp in exhaustive if grasp.object_label == label)
        first = next(grasp for grasp in found if grasp.object_label == label)
        # Only the estimate of the depth error is no strict bound.
        assert first.success > expected.success - 0.01


def _poses(count, seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.02, 0.02, (count, 3)), Rotation.random(count, rng=rng).as_matrix()


def test_close_poses_are_one_grasp_and_the_better_stays():
    tips = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.05, 0.0, 0.0]])
    turned = Rotation.from_euler("z", [[0], [20], [0]], degrees=True).as_matrix()
    total = np.array([0.5, 0.7, 0.6])
    none = np.zeros((0, 2, 3))
    np.testing.assert_array_equal(distinct(tips, turned, total, none, 3, 0.02), [1, 2])
    np.testing.assert_array_equal(distinct(tips, turned, total, none, 1, 0.02), [1])
    np.testing.assert_array_equal(distinct(tips, turned, total, none, 3, 0.65), [1])
    far = Rotation.from_euler("z", [[0], [30], [0]], degrees=True).as_matrix()
    np.testing.assert_array_equal(distinct(tips, far, total, none, 3, 0.02), [1, 2, 0])
    # A jaw that is turned by half a turn closes on the same faces.
    half = Rotation.from_euler("z", [[0], [180], [0]], degrees=True).as_matrix()
    np.testing.assert_array_equal(distinct(tips, half, total, none, 3, 0.02), [1, 2])


@pytest.mark.parametrize("angle", [0.3, 1.5, 3.0])
def test_turns_about_an_axis_of_symmetry_are_one_grasp(angle):
    axis = np.array([[[0.1, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    tips, rotations = _poses(5, 0)
    turn = Rotation.from_rotvec([0.0, 0.0, angle])
    moved = axis[0, 0] + turn.apply(tips - axis[0, 0])
    turned = (turn * Rotation.from_matrix(rotations)).as_matrix()
    others = moved, np.ascontiguousarray(turned), np.full(5, 0.5)
    assert repeats(tips, rotations, np.full(5, 0.4), others, axis).all()
    assert not repeats(tips, rotations, np.full(5, 0.6), others, axis).any()
