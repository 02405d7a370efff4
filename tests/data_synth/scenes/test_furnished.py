"""Furnished scenes: repeatable with the seed, at rest, visible, and labelled with background."""

from __future__ import annotations

from functools import cache
from typing import get_args

import numpy as np
import pytest

from eyehand.data_synth import render_scene
from eyehand.data_synth.scenes import (
    BACKGROUND_LEGEND,
    COUNT_RANGES,
    FurnishedFamily,
    FurnishedOptions,
    FurnishedScene,
    make_furnished_scene,
)
from eyehand.data_synth.scenes.arm_in_view import FOOT_PARTS, MIN_SIDE, draw_arm
from eyehand.data_synth.scenes.fixture import BACKGROUND_NUMBER
from eyehand.data_synth.scenes.furnished import ARM_SHARES
from eyehand.data_synth.scenes.furnished_scene import object_pose
from eyehand.data_synth.scenes.furnished_settings import draw_setting
from eyehand.data_synth.scenes.pouring import REST_SPEED_M_S, FurnishedPhysics
from eyehand.errors import InputError

FAMILIES: tuple[FurnishedFamily, ...] = get_args(FurnishedFamily)
KINDS = {
    "bin": {"container_floor", "container_wall"},
    "tote": {"container_floor", "container_wall"},
    "shelf": {"board", "wall"},
    "tray": {"container_floor", "container_wall", "table"},
    "clutter": {"table"},
    "small-table": {"table", "floor"},
}
"""Kinds of background that every view of a family shows."""
COUNT = {"clutter": (8, 8), "bin": (6, 6), "tote": (6, 6)}
SMALL = (160, 120)


@cache
def scene_of(family: FurnishedFamily) -> FurnishedScene:
    options = FurnishedOptions(family, count_range=COUNT.get(family), image_size=SMALL)
    return make_furnished_scene(3, options)


def physics_of(scene: FurnishedScene) -> FurnishedPhysics:
    physics = FurnishedPhysics(scene.objects, scene.fixtures)
    for index, item in enumerate(scene.objects):
        physics.put(index, object_pose(item))
    return physics


@pytest.mark.parametrize("family", FAMILIES)
def test_objects_are_at_rest_on_the_furniture(family: FurnishedFamily):
    scene = scene_of(family)
    low, high = COUNT.get(family, COUNT_RANGES[family])
    assert low <= len(scene.objects) <= high

    physics = physics_of(scene)
    physics.run(0.3)
    for index, item in enumerate(scene.objects):
        moved = physics.pose(index).translation - object_pose(item).translation
        # Without a hold, a ball at `REST_SPEED_M_S` may still roll on.
        assert np.linalg.norm(moved) < 2 * 0.3 * REST_SPEED_M_S + 1e-3, item.name


@pytest.mark.parametrize("family", FAMILIES)
def test_view_shows_objects_and_kinds_of_background(family: FurnishedFamily):
    scene = scene_of(family)
    view = render_scene(scene, colour=False)
    assert view.background is not None
    seen = {BACKGROUND_LEGEND[n] for n in np.unique(view.background[view.background > 0])}
    assert seen >= KINDS[family]
    assert np.array_equal(view.background == 0, (view.labels > 0) | (view.depth == 0))
    assert 2 * len(np.unique(view.labels[view.labels > 0])) >= len(scene.objects)


def test_same_seed_gives_same_scene():
    first = scene_of("tray")
    again = make_furnished_scene(3, FurnishedOptions("tray", image_size=SMALL))
    assert first.T_world_camera.as_matrix().tobytes() == again.T_world_camera.as_matrix().tobytes()
    for one, other in zip(first.objects, again.objects, strict=True):
        assert one.name == other.name
        assert object_pose(one).as_matrix().tobytes() == object_pose(other).as_matrix().tobytes()


def test_zero_objects_leave_the_furniture_empty():
    scene = make_furnished_scene(0, FurnishedOptions("bin", (0, 0), image_size=SMALL))
    view = render_scene(scene, colour=False)
    assert scene.objects == ()
    assert view.labels.max() == 0
    assert view.background is not None
    assert {3, 4} <= set(np.unique(view.background))


def test_empty_bins_differ_in_size():
    options = FurnishedOptions("bin", (0, 0), image_size=SMALL)
    floors = [make_furnished_scene(seed, options).fixtures[0].half_size for seed in range(6)]
    widths = [half[0] for half in floors]
    assert max(widths) > 1.5 * min(widths)


@pytest.mark.slow
def test_full_bin_hides_its_floor():
    # This seed draws a full bin.
    scene = make_furnished_scene(918, FurnishedOptions("bin", image_size=SMALL))
    view = render_scene(scene, colour=False)
    assert len(scene.objects) > COUNT_RANGES["bin"][1]
    floor = np.count_nonzero(view.background == BACKGROUND_NUMBER["container_floor"])
    assert floor < 0.02 * np.count_nonzero(view.labels)


def test_shelf_objects_lie_below_the_board_above():
    scene = scene_of("shelf")
    boards = sorted(
        float(item.pose.translation[2] + item.half_size[2])
        for item in scene.fixtures
        if item.kind == "board"
    )
    for item in scene.objects:
        height = object_pose(item).translation[2]
        assert any(low < height < low + 0.34 for low in boards)


@pytest.mark.parametrize("family", ["bin", "shelf"])
def test_arm_reaches_into_the_view_without_contact(family: FurnishedFamily):
    options = FurnishedOptions(family, (3, 4), arm=True, image_size=SMALL)
    scene = make_furnished_scene(1, options)
    view = render_scene(scene, colour=False)
    assert view.background is not None
    low, high = ARM_SHARES
    assert 0.8 * low < np.mean(view.background == BACKGROUND_NUMBER["robot"]) < 1.2 * high
    robot = [k for k, item in enumerate(scene.fixtures) if item.kind == "robot"]
    assert not physics_of(scene).fixtures_touch(robot[FOOT_PARTS:], robot)


def test_arm_reaches_the_point_of_its_setting():
    setting = draw_setting("clutter", 8, np.random.default_rng(0))
    arm = draw_arm(setting, 0.0, np.random.default_rng(1))
    assert arm is not None
    middles = np.array([item.pose.translation for item in arm])
    away = np.abs(middles - setting.reach)
    # The fingertips are within the spread; the nearest geom's middle is a finger's.
    assert np.linalg.norm(away, axis=1).min() < np.linalg.norm(setting.reach_spread) + 0.05
    base = middles[0, :2] - np.array(setting.reach[:2])
    assert abs(np.arctan2(base[1], base[0])) > MIN_SIDE - 0.4


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"count_range": (3, 2)}, "count_range must be two rising values"),
        ({"count_range": (0, 99)}, r"count_range must be two rising values in \[0, 40\]"),
        ({"mesh_share": 1.5}, "mesh_share"),
        ({"image_size": (1, 1)}, "image_size"),
    ],
)
def test_invalid_options_raise(options: dict, message: str):
    with pytest.raises(InputError, match=message):
        FurnishedOptions(**options)
    with pytest.raises(InputError, match="seed"):
        make_furnished_scene(-1)
