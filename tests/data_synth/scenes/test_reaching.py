"""Reaching scenes: what a seed gives, and that start and goal can be taken up."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.scenes import ArmClearance
from eyehand.data_synth.scenes.reaching import (
    MIN_CLEARANCE_M,
    MIN_TRAVEL_M,
    ReachingObstacle,
    ReachingScene,
    make_reaching_scene,
    straight_path_is_blocked,
)
from eyehand.errors import InputError

GOLDEN = json.loads(Path(__file__).with_name("golden_reaching.json").read_text())
SCENES = [make_reaching_scene(seed) for seed in range(40)]


@pytest.mark.parametrize("was", GOLDEN, ids=lambda was: f"{was['seed']}-{was['boxes']}")
def test_a_seed_gives_the_scene_that_it_always_gave(was: dict[str, Any]):
    scene = make_reaching_scene(was["seed"], boxes=was["boxes"])
    assert np.allclose(scene.start, was["start"], rtol=0, atol=1e-9)
    assert np.allclose(scene.goal, was["goal"], rtol=0, atol=1e-9)
    assert [item.name for item in scene.obstacles] == was["names"]
    poses = [item.T_world_shape.as_matrix()[:3] for item in scene.obstacles]
    assert np.allclose([item.size for item in scene.obstacles], was["sizes"], rtol=0, atol=1e-9)
    assert np.allclose(poses, was["poses"], rtol=0, atol=1e-9)


def test_start_and_goal_are_clear_of_everything_and_apart():
    for scene in SCENES:
        clearance = ArmClearance(scene.obstacles)
        assert clearance.at(scene.start) >= MIN_CLEARANCE_M
        assert clearance.at(scene.witness) >= MIN_CLEARANCE_M
        assert np.allclose(clearance.tool(scene.witness), scene.goal, rtol=0, atol=1e-12)
        way = np.linalg.norm(clearance.tool(scene.start) - scene.goal)
        assert way >= MIN_TRAVEL_M
        lower, upper = clearance.joint_range
        assert ((scene.start > lower) & (scene.start < upper)).all()


def test_about_half_of_the_scenes_have_a_box_in_the_straight_way():
    assert 0.3 < np.mean([straight_path_is_blocked(scene) for scene in SCENES]) < 0.7


def test_a_blocked_way_is_told_as_sampling_tells_it():
    for scene in SCENES:
        first = ArmClearance(scene.obstacles).tool(scene.start)
        points = first + (scene.goal - first) * np.linspace(0, 1, 2000)[:, None]
        inside = [
            (np.abs(item.T_world_shape.inv().apply(points)) < item.size).all(axis=1).any()
            for item in scene.obstacles
        ]
        assert straight_path_is_blocked(scene) == any(inside)


@pytest.mark.parametrize(("height", "blocked"), [(0.0, True), (0.2, False)])
def test_a_way_along_a_box_axis_is_told_exactly(height: float, blocked: bool):
    start = np.array([0.0, 0.6, 0.0, -1.8, 0.0, 0.74, 0.0])
    tool = ArmClearance().tool(start)
    middle = RigidTransform.from_components(np.add(tool, [0.0, 0.3, height]), Rotation.identity())
    box = ReachingObstacle("box", "box", (0.1, 0.1, 0.1), middle)
    scene = ReachingScene(0, start, np.add(tool, [0.0, 0.6, 0.0]), (box,), start)
    assert straight_path_is_blocked(scene) == blocked


def test_no_boxes_make_an_empty_scene():
    assert make_reaching_scene(3, boxes=0).obstacles == ()


@pytest.mark.parametrize(("seed", "boxes"), [(-1, 5), (0, -1), (0, 13)])
def test_numbers_out_of_range_are_refused(seed: int, boxes: int):
    with pytest.raises(InputError, match="must be a whole number"):
        make_reaching_scene(seed, boxes=boxes)
