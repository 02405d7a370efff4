"""Dropped and piled objects: on the table, at rest, and without penetration."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from eyehand.data_synth import TabletopObject, TabletopOptions, TabletopScene, make_scene
from eyehand.data_synth.render import RenderedView, render_scene
from eyehand.data_synth.scenes import Family, tabletop
from eyehand.data_synth.scenes.tabletop import TOUCH_GAP_M, carried_count
from eyehand.data_synth.scenes.tabletop_physics import TabletopPhysics
from eyehand.data_synth.scenes.viewpoint import MIN_VISIBLE_SHARE
from eyehand.errors import InputError
from eyehand.perception.superquadric import sample_surface

FALLEN: tuple[Family, ...] = ("dropped", "piled")
SEEDS = range(3)
UP = np.array([0.0, 0.0, 1.0])


def options_of(family: Family) -> TabletopOptions:
    return TabletopOptions(family=family, count_range=(4, 5))


@cache
def scene_of(family: Family, seed: int) -> TabletopScene:
    return make_scene(seed, options_of(family))


@cache
def view_of(family: Family, seed: int) -> RenderedView:
    return render_scene(scene_of(family, seed), colour=False)


def physics_of(scene: TabletopScene) -> TabletopPhysics:
    physics = TabletopPhysics(scene.objects, scene.table, no_creep=True)
    for index, item in enumerate(scene.objects):
        physics.put(index, item.shape.pose)
    return physics


def depth_inside(item: TabletopObject, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the depth of points inside the exact solid, m.

    For round solids, the depth is measured along the ray to the centre.
    """
    local = item.shape.pose.inv().apply(points)
    a = item.shape.semi_axes
    if item.kind == "box":
        return np.min(a - np.abs(local), axis=1)
    if item.kind == "cylinder":
        level = a[0] - np.hypot(local[:, 0], local[:, 1])
        return np.minimum(level, a[2] - np.abs(local[:, 2]))
    e1, e2 = item.shape.exponents
    x, y, z = np.abs(local / a).T
    gauge = ((x ** (2 / e2) + y ** (2 / e2)) ** (e2 / e1) + z ** (2 / e1)) ** (e1 / 2)
    return np.linalg.norm(local, axis=1) * (1 / gauge - 1)


@pytest.mark.parametrize("family", FALLEN)
def test_dropped_scene_is_bitwise_repeatable(family: Family):
    first, again = scene_of(family, 1), make_scene(1, options_of(family))
    assert first.T_world_camera.as_matrix().tobytes() == again.T_world_camera.as_matrix().tobytes()
    for one, other in zip(first.objects, again.objects, strict=True):
        assert one.shape.pose.as_matrix().tobytes() == other.shape.pose.as_matrix().tobytes()


@pytest.mark.parametrize("family", FALLEN)
@pytest.mark.parametrize("seed", SEEDS)
def test_dropped_objects_are_at_rest(family: Family, seed: int):
    scene = scene_of(family, seed)
    physics = physics_of(scene)
    physics.run(1.0)
    assert physics.max_speed() < 5e-3
    for index, item in enumerate(scene.objects):
        moved = physics.pose(index).translation - item.shape.pose.translation
        assert np.linalg.norm(moved) < 2e-4, item.name


@pytest.mark.parametrize("family", FALLEN)
@pytest.mark.parametrize("seed", SEEDS)
def test_penetration_is_below_one_millimetre(family: Family, seed: int):
    scene = scene_of(family, seed)
    rng = np.random.default_rng(seed)
    clouds = [sample_surface(item.shape, 3000, rng) for item in scene.objects]
    for k, item in enumerate(scene.objects):
        for j, cloud in enumerate(clouds):
            assert j == k or depth_inside(item, cloud).max() < 1e-3, (k, j)
        assert clouds[k][:, 2].min() > -1e-3
    assert physics_of(scene).max_penetration() < 1e-3


@pytest.mark.parametrize("family", FALLEN)
@pytest.mark.parametrize("seed", SEEDS)
def test_dropped_objects_are_on_table_and_fully_in_image(family: Family, seed: int):
    scene = scene_of(family, seed)
    half = np.array(scene.table.size) / 2
    last = [scene.intrinsics.width - 1, scene.intrinsics.height - 1]
    rng = np.random.default_rng(seed)
    for item in scene.objects:
        points = sample_surface(item.shape, 500, rng)
        assert np.all(np.abs(points[:, :2]) <= half)
        pixels = scene.intrinsics.project(scene.T_world_camera.inv().apply(points))
        assert pixels.min() >= 0
        assert np.all(pixels <= last)
    labels = view_of(family, seed).labels
    visible = np.bincount(labels.ravel(), minlength=len(scene.objects) + 1)[1:]
    # The share is checked on every second column and row. The full image may have slightly less.
    assert visible.min() >= 0.8 * MIN_VISIBLE_SHARE * labels.size


@pytest.mark.parametrize("seed", SEEDS)
def test_dropped_objects_touch_table(seed: int):
    scene = scene_of("dropped", seed)
    physics = physics_of(scene)
    physics.run(0.1)
    assert physics.on_table() == set(range(len(scene.objects)))


def test_dropped_cylinders_lie_more_often_than_placed_ones():
    def count_lying(family: Family) -> int:
        options = TabletopOptions(family=family, kinds=("cylinder",), count_range=(8, 8))
        items = make_scene(0, options).objects + make_scene(1, options).objects
        return sum(abs(float(item.shape.rotation[2, 2])) < 0.5 for item in items)

    assert count_lying("dropped") > count_lying("separate")
    assert 8 <= count_lying("dropped") < 16


@pytest.mark.parametrize("seed", SEEDS)
def test_piled_objects_touch_and_rest_on_each_other(seed: int):
    scene = scene_of("piled", seed)
    physics = physics_of(scene)
    count = len(scene.objects)
    gaps = [physics.nearest_gap(k, [j for j in range(count) if j != k]) for k in range(count)]
    physics.run(0.1)
    assert np.mean(np.array(gaps) <= TOUCH_GAP_M) >= 0.75
    assert count - len(physics.on_table()) >= carried_count(count) >= 1


def test_pile_is_smaller_than_dropped_scene():
    def spread(family: Family) -> float:
        positions = [
            np.array([item.shape.centre[:2] for item in scene_of(family, k).objects]) for k in SEEDS
        ]
        return float(np.median([np.ptp(position, axis=0).max() for position in positions]))

    assert spread("piled") < 0.6 * spread("dropped")


def test_pile_follows_table_height():
    low = make_scene(1, TabletopOptions(family="piled", count_range=(3, 3)))
    high = make_scene(1, TabletopOptions(family="piled", count_range=(3, 3), table_height=0.5))
    for scene, height in ((low, 0.0), (high, 0.5)):
        lowest = min(-float(item.shape.support(-UP)) for item in scene.objects)
        assert lowest == pytest.approx(height, abs=5e-4)


@pytest.mark.parametrize(
    ("family", "changes", "limits", "message"),
    [
        ("dropped", {"table_size": (0.2, 0.2), "work_area": (0.2, 0.2)}, {}, "too full"),
        ("dropped", {}, {"settle": 0.2}, "never at rest"),
        ("piled", {"table_size": (0.1, 0.1), "work_area": (0.1, 0.1)}, {}, "off the table"),
        ("piled", {"pile_spread": 2.0}, {"contact": 1.0}, "scattered|no pile|never at rest"),
    ],
)
def test_impossible_dropped_scene_raises_with_reason(
    family: Family, changes: dict, limits: dict, message: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(tabletop, "MAX_DRAWS", 2)
    monkeypatch.setattr(tabletop, "MAX_SETTLE_S", limits.get("settle", tabletop.MAX_SETTLE_S))
    share = limits.get("contact", tabletop.PILE_CONTACT_SHARE)
    monkeypatch.setattr(tabletop, "PILE_CONTACT_SHARE", share)
    options = TabletopOptions(family=family, count_range=(9, 9), **changes)
    with pytest.raises(InputError, match=message):
        make_scene(0, options)


def test_contact_share_of_one_gives_pile_in_full_contact(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(tabletop, "PILE_CONTACT_SHARE", 1.0)
    options = TabletopOptions(family="piled", count_range=(4, 4))
    scene = make_scene(0, options)
    physics = physics_of(scene)
    assert max(physics.nearest_gap(k, [j for j in range(4) if j != k]) for k in range(4)) <= 1e-3
