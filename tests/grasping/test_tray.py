"""Trays: places on the floor, distance, and obstacles of the walls."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.control import Cylinder
from eyehand.errors import InputError
from eyehand.grasping.tray import Tray
from eyehand.grasping.tray_plan import (
    HeldSize,
    TrayItem,
    added_items,
    content_obstacles,
    plan_place,
)

TRAY = Tray(np.array([0.4, -0.1, 0.01]), (0.2, 0.3), 0.06)


@given(st.floats(0.01, 0.09), st.floats(0.02, 0.25), st.integers(0, 8))
def test_every_place_lies_on_floor(radius, height, count):
    size = HeldSize(radius, 2.0 * radius, 0.5 * height, height)
    content: list[TrayItem] = []
    for _ in range(count + 1):
        place = plan_place(TRAY, content, size)
        assert TRAY.contains(place.position)
        assert place.position[2] == TRAY.centre[2]
        content += added_items(size, place.position, place.below)


def test_small_objects_lie_apart_before_one_lies_on_another():
    size = HeldSize(0.02, 0.04, 0.02, 0.04)
    content: list[TrayItem] = []
    for _ in range(6):
        place = plan_place(TRAY, content, size)
        assert place.below == 0.0
        content += added_items(size, place.position, place.below)


def test_tall_object_falls_into_the_tray_not_over_its_wall():
    size = HeldSize(0.03, 0.05, 0.1, 0.2)
    place = plan_place(TRAY, (), size)
    room = 0.5 * np.array(TRAY.size) - np.abs(place.position[:2] - TRAY.centre[:2])
    assert (room >= 0.1 - 1e-9).all()
    standing, fallen = added_items(size, place.position, place.below)
    assert (standing.top, fallen.top, fallen.radius) == (0.2, 0.05, 0.2)


def test_object_on_another_is_released_above_it():
    narrow = replace(TRAY, size=(0.12, 0.12))
    size = HeldSize(0.03, 0.06, 0.03, 0.06)
    place = plan_place(narrow, (), size)
    content = added_items(size, place.position, place.below)
    assert plan_place(narrow, content, size).below == pytest.approx(0.06)


@pytest.mark.parametrize(("radius", "below"), [(0.044, 0.0), (0.047, 0.1)])
def test_object_stands_beside_discs_that_it_overlaps_little(radius, below):
    long = replace(TRAY, size=(0.3, 0.12))
    content = [TrayItem(long.centre[:2] + np.array([x, 0.0]), 0.06, 0.1) for x in (-0.1, 0.1)]
    size = HeldSize(radius, 2.0 * radius, 0.03, 0.06)
    assert plan_place(long, content, size).below == below


def test_place_is_free_of_what_stands_where_a_tall_object_may_have_fallen():
    tray, size = replace(TRAY, size=(0.25, 0.3)), HeldSize(0.034, 0.05, 0.06, 0.118)
    standing = [
        TrayItem(tray.centre[:2] + at, radius, top)
        for at, radius, top in [((-0.05, -0.07), 0.025, 0.16), ((0.05, 0.075), 0.04, 0.145)]
    ]
    fallen = TrayItem(standing[0].place, 0.25, 0.049, stands=False)
    place = plan_place(tray, [*standing, fallen], size, 0.075)
    assert place.below == pytest.approx(0.049)
    gaps = [np.linalg.norm(place.position[:2] - one.place) - one.radius for one in standing]
    assert min(gaps) - size.radius >= 0.02


def test_only_what_stands_is_an_obstacle_of_a_hand_that_reaches_into_the_tray():
    content = added_items(HeldSize(0.03, 0.05, 0.1, 0.2), TRAY.centre + 0.1, 0.0)
    (body,) = content_obstacles(TRAY, content)
    assert isinstance(body.shape, Cylinder)
    np.testing.assert_allclose(body.pose.translation, [0.5, 0.0, TRAY.centre[2] + 0.1])
    assert body.shape.half_length == pytest.approx(0.1)


def test_distance_is_horizontal_from_edge_of_floor():
    assert TRAY.distance(np.array([0.45, -0.2, 0.5])) == 0.0
    assert TRAY.distance(np.array([0.53, -0.1, 0.0])) == pytest.approx(0.03)
    assert TRAY.distance(np.array([0.53, 0.09, 0.0])) == pytest.approx(0.05)


def test_walls_surround_floor():
    parts = {part.name: part for part in TRAY.obstacles()}
    assert len(parts) == 5
    assert parts["tray +x"].pose.translation[0] == pytest.approx(0.4 + 0.1 + 0.003)
    assert parts["tray floor"].pose.translation[2] == pytest.approx(0.01 - 0.003)


@pytest.mark.parametrize(
    "wrong",
    [
        {"size": (0.0, 0.3)},
        {"wall_height": -1.0},
        {"size": (np.inf, 0.3)},
        {"centre": np.array([np.nan, 0.0, 0.0])},
        {"centre": np.zeros(2)},
    ],
)
def test_invalid_trays_are_rejected(wrong):
    given = {"centre": np.zeros(3), "size": (0.2, 0.3), "wall_height": 0.05} | wrong
    with pytest.raises(InputError):
        Tray(**given)


def test_wide_jaws_stay_farther_from_the_walls():
    """Between a can and a wall, the jaws of a Panda could not open."""
    size = HeldSize(0.03, 0.06, 0.05, 0.1)
    for distance in (0.055, 0.07):
        place = plan_place(TRAY, (), size, distance)
        room = 0.5 * np.array(TRAY.size) - np.abs(place.position[:2] - TRAY.centre[:2])
        assert room.min() == pytest.approx(distance, abs=0.01)
        assert (room >= distance - 1e-9).all()
