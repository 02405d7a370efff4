"""Tabletop scenes: repeatable with the seed, valid for their family, and at rest."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import KDTree

from eyehand.data_synth import TabletopOptions, TabletopScene, ViewOptions, make_scene
from eyehand.data_synth.scenes import MAX_OBJECTS, Family, placement, tabletop
from eyehand.data_synth.scenes.tabletop import MAX_DRIFT_M
from eyehand.data_synth.scenes.tabletop_physics import TabletopPhysics
from eyehand.errors import InputError
from eyehand.perception.superquadric import Kind, sample_surface

FAMILIES: tuple[Family, ...] = ("separate", "touching", "stacked")
SEEDS = range(4)


@cache
def scene_of(family: Family, seed: int) -> TabletopScene:
    return make_scene(seed, TabletopOptions(family=family, count_range=(4, 7)))


def physics_of(scene: TabletopScene) -> TabletopPhysics:
    physics = TabletopPhysics(scene.objects, scene.table)
    for index, item in enumerate(scene.objects):
        physics.put(index, item.shape.pose)
    return physics


def gaps_of(scene: TabletopScene) -> list[float]:
    """Return the distance from each object to its closest neighbour, m."""
    physics = physics_of(scene)
    every = range(len(scene.objects))
    return [physics.nearest_gap(k, [j for j in every if j != k]) for k in every]


@pytest.mark.parametrize("family", FAMILIES)
def test_scene_is_bitwise_repeatable(family: Family):
    first = scene_of(family, 1)
    again = make_scene(1, TabletopOptions(family=family, count_range=(4, 7)))

    assert first.T_world_camera.as_matrix().tobytes() == again.T_world_camera.as_matrix().tobytes()
    assert len(first.objects) == len(again.objects)
    for one, other in zip(first.objects, again.objects, strict=True):
        assert (one.name, one.mass, one.colour) == (other.name, other.mass, other.colour)
        assert one.shape.exponents == other.shape.exponents
        assert one.shape.semi_axes.tobytes() == other.shape.semi_axes.tobytes()
        assert one.shape.pose.as_matrix().tobytes() == other.shape.pose.as_matrix().tobytes()


def test_different_seeds_give_different_scenes():
    one, other = scene_of("separate", 1), scene_of("separate", 2)
    assert not np.allclose(one.objects[0].shape.semi_axes, other.objects[0].shape.semi_axes)


@pytest.mark.parametrize("seed", SEEDS)
def test_separate_objects_keep_min_gap(seed: int):
    assert min(gaps_of(scene_of("separate", seed))) >= TabletopOptions().min_gap


def test_separate_objects_keep_min_gap_between_surface_samples():
    scene = scene_of("separate", 0)
    rng = np.random.default_rng(5)
    clouds = [sample_surface(item.shape, 4000, rng) for item in scene.objects]
    smallest_gap = min(
        KDTree(one).query(other)[0].min()
        for k, one in enumerate(clouds)
        for other in clouds[k + 1 :]
    )
    assert smallest_gap >= TabletopOptions().min_gap


@pytest.mark.parametrize("seed", SEEDS)
def test_each_touching_object_touches_another(seed: int):
    gaps = gaps_of(scene_of("touching", seed))
    assert max(gaps) < 1e-3
    assert min(gaps) > -1e-3


@pytest.mark.parametrize("seed", SEEDS)
def test_stacked_scene_has_supported_objects(seed: int):
    scene = scene_of("stacked", seed)
    physics = physics_of(scene)
    physics.run(0.1)
    carried = set(range(len(scene.objects))) - physics.on_table()
    assert len(carried) >= (len(scene.objects) + 1) // 3
    for index in carried:
        shape = scene.objects[index].shape
        lowest = -float(shape.support([0.0, 0.0, -1.0]))
        assert lowest > scene.table.height + 0.02


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", SEEDS)
def test_objects_stay_at_rest_for_half_a_second(family: Family, seed: int):
    scene = scene_of(family, seed)
    physics = physics_of(scene)
    physics.run(0.5)
    for index, item in enumerate(scene.objects):
        moved = physics.pose(index).translation - item.shape.pose.translation
        assert np.linalg.norm(moved) < 1e-3, item.name


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", SEEDS)
def test_objects_are_on_table_in_work_area(family: Family, seed: int):
    scene = scene_of(family, seed)
    half = np.array(TabletopOptions().work_area) / 2
    for item in scene.objects:
        sides = [item.shape.support(d) for d in ([1.0, 0, 0], [0, 1.0, 0])]
        sides += [item.shape.support(d) for d in ([-1.0, 0, 0], [0, -1.0, 0])]
        assert np.all(np.array(sides) <= np.tile(half, 2) + MAX_DRIFT_M)
        lowest = -float(item.shape.support([0.0, 0.0, -1.0]))
        assert lowest > -2e-4


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", SEEDS)
def test_sizes_masses_and_shapes_follow_options(family: Family, seed: int):
    options = TabletopOptions()
    for item in scene_of(family, seed).objects:
        a1, a2, a3 = item.shape.semi_axes
        low, high = options.width_range
        assert low / 2 <= a2 <= a1 <= high / 2
        assert a3 <= options.height_range[1] / 2
        density = item.mass / item.shape.volume
        assert options.density_range[0] * 0.98 <= density <= options.density_range[1] * 1.02
        expected = {"box": (0.02, 0.02), "cylinder": (0.02, 1.0)}
        if item.kind in ("sphere", "ellipsoid"):
            assert item.shape.exponents == (1.0, 1.0)
        elif item.kind in expected:
            assert item.shape.exponents == expected[item.kind]


@pytest.mark.parametrize("seed", SEEDS)
def test_objects_are_fully_in_image_from_requested_range(seed: int):
    scene = scene_of("separate", seed)
    centres = np.array([item.shape.centre for item in scene.objects])
    target = (centres.min(axis=0) + centres.max(axis=0)) / 2
    view_direction = scene.T_world_camera.translation - target
    distance = np.linalg.norm(view_direction)
    assert 0.6 <= distance <= 1.1
    assert np.deg2rad(29.9) <= np.arcsin(view_direction[2] / distance) <= np.deg2rad(65.1)
    rng = np.random.default_rng(0)
    for item in scene.objects:
        points = sample_surface(item.shape, 500, rng)
        pixels = scene.intrinsics.project(scene.T_world_camera.inv().apply(points))
        assert pixels.min() >= 0
        assert np.all(pixels <= [scene.intrinsics.width - 1, scene.intrinsics.height - 1])


@pytest.mark.parametrize("kind", ["sphere", "cylinder", "ellipsoid", "box", "superquadric"])
def test_single_kind_gives_objects_of_that_kind(kind: Kind):
    scene = make_scene(0, TabletopOptions(kinds=(kind,), count_range=(3, 3)))
    assert [item.kind for item in scene.objects] == [kind] * 3
    assert [item.name for item in scene.objects] == [f"{kind}_{k}" for k in (1, 2, 3)]


@pytest.mark.parametrize("family", FAMILIES)
def test_scene_with_max_objects_can_be_made(family: Family):
    scene = make_scene(0, TabletopOptions(family=family, count_range=(MAX_OBJECTS, MAX_OBJECTS)))
    assert len(scene.objects) == MAX_OBJECTS


def test_objects_follow_table_height():
    low = make_scene(3, TabletopOptions(count_range=(3, 3)))
    high = make_scene(3, TabletopOptions(count_range=(3, 3), table_height=0.75))
    for one, other in zip(low.objects, high.objects, strict=True):
        assert np.allclose(other.shape.centre - one.shape.centre, [0, 0, 0.75], atol=1e-3)


@pytest.mark.parametrize("size", [(320, 240), (1280, 720)])
def test_image_size_keeps_field_of_view(size: tuple[int, int]):
    view = ViewOptions(image_size=size)
    intrinsics = make_scene(0, TabletopOptions(count_range=(1, 1), view=view)).intrinsics
    assert (intrinsics.width, intrinsics.height) == size
    assert intrinsics.fx / size[0] == pytest.approx(525 / 640)
    assert (intrinsics.cx, intrinsics.cy) == ((size[0] - 1) / 2, (size[1] - 1) / 2)


def test_scene_without_space_raises_with_reason(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(tabletop, "MAX_DRAWS", 2)
    options = TabletopOptions(count_range=(15, 15), work_area=(0.1, 0.1))
    with pytest.raises(InputError, match=r"in 2 draws \(2x too full\): ask for fewer"):
        make_scene(0, options)


def test_scene_without_settling_time_raises(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(tabletop, "MAX_DRAWS", 2)
    monkeypatch.setattr(tabletop, "MAX_SETTLE_S", 0.2)
    monkeypatch.setattr(placement, "_RELEASE_HEIGHT_M", 0.1)
    options = TabletopOptions(count_range=(2, 2))
    with pytest.raises(InputError, match="never at rest"):
        make_scene(0, options)


@pytest.mark.parametrize("seed", [-1, 1.5, "7", True, None])
def test_make_scene_rejects_invalid_seed(seed: object):
    with pytest.raises(InputError, match="seed must be a whole number >= 0"):
        make_scene(seed)  # type: ignore[arg-type]  # the invalid type under test
