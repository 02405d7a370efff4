"""Conversion between a solid and the numbers of its sliders."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.solid_numbers import numbers_of, solid_numbers, solid_of
from eyehand.perception import Superquadric

POSE = RigidTransform.from_components([1.0, 2.0, 3.0], Rotation.from_rotvec([0.3, -0.2, 0.5]))
CAN = Superquadric(np.array([0.04, 0.04, 0.06]), (0.1, 1.0), POSE, "cylinder")
CUP = Superquadric(np.array([0.04, 0.03, 0.06]), (0.1, 1.0), POSE, "tapered", (0.2, -0.1))


@pytest.mark.parametrize("solid", [CAN, CUP])
def test_unchanged_numbers_give_the_same_solid(solid):
    again = solid_of(numbers_of(solid), solid)
    assert again.kind == solid.kind
    assert again.taper == solid.taper
    assert again.semi_axes == pytest.approx(solid.semi_axes)
    assert again.pose.as_matrix() == pytest.approx(solid.pose.as_matrix())


def test_slider_ranges_contain_the_solid():
    numbers = {number.name: number for number in solid_numbers(120.0)}
    assert len(numbers) == 13
    for solid in (CAN, CUP):
        for name, value in numbers_of(solid).items():
            assert numbers[name].low <= value <= numbers[name].high


def test_moves_and_rotations_are_in_the_axes_of_the_solid():
    moved = solid_of({**numbers_of(CAN), "cz": 10.0, "rx": 90.0}, CAN)
    assert moved.centre == pytest.approx(CAN.to_parent([0.0, 0.0, 0.01]))
    assert moved.rotation[:, 2] == pytest.approx(-CAN.rotation[:, 1])


@pytest.mark.parametrize(
    ("changes", "kind"),
    [
        ({}, "cylinder"),
        ({"a3": 60.0}, "cylinder"),
        ({"a1": 60.0}, "superquadric"),
        ({"eps1": 0.5}, "superquadric"),
        ({"k1": 0.3}, "tapered"),
    ],
)
def test_kind_follows_from_the_numbers(changes, kind):
    assert solid_of({**numbers_of(CAN), **changes}, CAN).kind == kind


def test_long_sphere_is_an_ellipsoid_and_straight_cup_a_superquadric():
    ball = Superquadric(np.full(3, 0.04), (1.0, 1.0), POSE, "sphere")
    assert solid_of({**numbers_of(ball), "a3": 100.0}, ball).kind == "ellipsoid"
    assert solid_of({**numbers_of(CUP), "k1": 0.0, "k2": 0.0}, CUP).kind == "superquadric"
