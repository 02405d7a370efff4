"""Caliper widths against lengths known by construction."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.grasping.extents import measure_extents
from eyehand.perception import Superquadric

UP = np.array([0.0, 0.0, 1.0])


def test_extents_of_ellipsoid_are_its_axes():
    solid = Superquadric(np.array([0.05, 0.03, 0.02]), (1.0, 1.0), RigidTransform.identity())
    found = measure_extents(solid, UP)
    assert found.height == pytest.approx(0.04)
    assert found.width == pytest.approx(0.06, abs=1e-4)
    assert found.length == pytest.approx(0.10, abs=1e-4)
    assert abs(found.closing[1]) > 0.999
    assert not found.round


def test_cylinder_is_round_only_along_its_axis():
    can = Superquadric(np.array([0.03, 0.03, 0.06]), (0.1, 1.0), RigidTransform.identity())
    lying = RigidTransform.from_rotation(Rotation.from_euler("x", 90, degrees=True))
    assert measure_extents(can, UP).round
    assert not measure_extents(Superquadric(can.semi_axes, can.exponents, lying), UP).round


@given(seed=st.integers(0, 10_000))
def test_extents_do_not_depend_on_world_frame(seed):
    rng = np.random.default_rng(seed)
    pose = RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
    solid = Superquadric(rng.uniform(0.02, 0.1, 3), (0.4, 1.1), pose)
    turn = RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
    here = measure_extents(solid, UP)
    there = measure_extents(
        Superquadric(solid.semi_axes, solid.exponents, turn * pose), turn.rotation.apply(UP)
    )
    # Directions are tried every 2 degrees: widths agree to second order in that.
    assert there.height == pytest.approx(here.height, rel=1e-9)
    assert there.width == pytest.approx(here.width, rel=5e-3)
