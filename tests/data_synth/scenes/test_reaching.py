"""Reaching scenes: stored scenes, feasible start and goal, and blocked paths."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.scenes import PLACES, ArmClearance
from eyehand.data_synth.scenes.reaching import (
    MIN_CLEARANCE_M,
    MIN_TRAVEL_M,
    ReachingObstacle,
    ReachingScene,
    make_reaching_scene,
    passes_base,
    straight_path_is_blocked,
)
from eyehand.errors import InputError

GOLDEN = json.loads(Path(__file__).with_name("golden_reaching.json").read_text())
SCENES = [make_reaching_scene(seed) for seed in range(40)]


@pytest.mark.parametrize("stored", GOLDEN, ids=lambda stored: f"{stored['seed']}-{stored['boxes']}")
def test_reaching_scene_equals_stored_scene(stored: dict[str, Any]):
    scene = make_reaching_scene(stored["seed"], boxes=stored["boxes"])
    assert np.allclose(scene.start, stored["start"], rtol=0, atol=1e-9)
    assert np.allclose(scene.goal, stored["goal"], rtol=0, atol=1e-9)
    assert [item.name for item in scene.obstacles] == stored["names"]
    poses = [item.T_world_shape.as_matrix()[:3] for item in scene.obstacles]
    assert np.allclose([item.size for item in scene.obstacles], stored["sizes"], rtol=0, atol=1e-9)
    assert np.allclose(poses, stored["poses"], rtol=0, atol=1e-9)


def test_start_and_goal_are_collision_free_and_distant():
    for scene in SCENES:
        clearance = ArmClearance(scene.obstacles)
        assert clearance.at(scene.start) >= MIN_CLEARANCE_M
        assert clearance.at(scene.witness) >= MIN_CLEARANCE_M
        assert np.allclose(clearance.tool(scene.witness), scene.goal, rtol=0, atol=1e-12)
        travel = np.linalg.norm(clearance.tool(scene.start) - scene.goal)
        assert travel >= MIN_TRAVEL_M
        lower, upper = clearance.joint_range
        assert ((scene.start > lower) & (scene.start < upper)).all()


def test_about_half_of_scenes_have_blocked_straight_path():
    assert 0.3 < np.mean([straight_path_is_blocked(scene) for scene in SCENES]) < 0.7


def test_blocked_path_agrees_with_sampling():
    for scene in SCENES:
        first = ArmClearance(scene.obstacles).tool(scene.start)
        points = first + (scene.goal - first) * np.linspace(0, 1, 2000)[:, None]
        inside = [
            (np.abs(item.T_world_shape.inv().apply(points)) < item.size).all(axis=1).any()
            for item in scene.obstacles
        ]
        assert straight_path_is_blocked(scene) == any(inside)


@pytest.mark.parametrize(("height", "blocked"), [(0.0, True), (0.2, False)])
def test_path_along_box_axis_is_classified_exactly(height: float, blocked: bool):
    start = np.array([0.0, 0.6, 0.0, -1.8, 0.0, 0.74, 0.0])
    tool = ArmClearance().tool(start)
    middle = RigidTransform.from_components(np.add(tool, [0.0, 0.3, height]), Rotation.identity())
    box = ReachingObstacle("box", "box", (0.1, 0.1, 0.1), middle)
    scene = ReachingScene(0, start, np.add(tool, [0.0, 0.6, 0.0]), (box,), start, np.eye(3))
    assert straight_path_is_blocked(scene) == blocked


@pytest.mark.parametrize(
    ("place", "travel", "through"),
    [
        ([0.16, -0.7, 0.25], [0.0, 1.4, 0.0], True),
        ([0.16, -0.7, 0.25], [0.0, 0.4, 0.0], False),
        ([0.26, -0.7, 0.25], [0.0, 1.4, 0.0], False),
        ([0.0, -0.7, 0.75], [0.0, 1.4, 0.0], False),
        ([0.0, 0.0, 1.2], [0.0, 0.0, -0.7], True),
    ],
)
def test_moving_box_that_enters_the_column_of_the_base_is_found(place, travel, through):
    middle = RigidTransform.from_translation(place)
    box = ReachingObstacle("box", "box", (0.05, 0.05, 0.05), middle)
    assert passes_base(box, np.array(travel)) == through


def test_zero_boxes_give_no_obstacles():
    assert make_reaching_scene(3, boxes=0).obstacles == ()


@pytest.mark.parametrize(("seed", "boxes"), [(-1, 5), (0, -1), (0, 13)])
def test_reaching_scene_rejects_invalid_numbers(seed: int, boxes: int):
    with pytest.raises(InputError, match="must be a whole number"):
        make_reaching_scene(seed, boxes=boxes)


@pytest.mark.parametrize("place", PLACES[1:])
def test_tight_place_surrounds_a_goal_that_can_be_reached(place):
    for seed in range(3):
        scene = make_reaching_scene(seed, place=place)
        clearance = ArmClearance(scene.obstacles)
        for q in (scene.start, scene.witness):
            assert clearance.at(q) >= MIN_CLEARANCE_M
        np.testing.assert_allclose(clearance.tool(scene.witness), scene.goal, atol=1e-12)
        np.testing.assert_allclose(clearance.tool_axes(scene.witness), scene.goal_axes, atol=1e-12)
        sides = []
        for box in scene.obstacles:
            centre = box.T_world_shape.translation - scene.goal
            assert np.linalg.norm(centre) < 0.6
            sides.append(centre[:2])
        # Some solids lie on opposite sides of the goal.
        assert min(a @ b for a in sides for b in sides) < -0.001
        again = make_reaching_scene(seed, place=place)
        np.testing.assert_array_equal(scene.start, again.start)


def test_unknown_place_is_refused():
    with pytest.raises(InputError, match="one of boxes, shelf, bin, neighbours, got 'attic'"):
        make_reaching_scene(0, place="attic")  # pyright: ignore[reportArgumentType]
