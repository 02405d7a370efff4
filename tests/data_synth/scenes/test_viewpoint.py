"""The camera looks where it is told, with level rows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import ViewOptions, look_at
from eyehand.data_synth.scenes.viewpoint import (
    MIN_VISIBLE_SHARE,
    camera_intrinsics,
    draw_viewpoint,
)
from eyehand.errors import InputError
from eyehand.perception.superquadric import Superquadric

coordinate = st.floats(-2, 2)


@given(
    eye=st.tuples(coordinate, coordinate, coordinate),
    azimuth=st.floats(0, 6.28),
    elevation=st.floats(-1.5, 1.5),
)
def test_the_target_lies_on_the_optical_axis_and_rows_are_level(
    eye: tuple[float, float, float], azimuth: float, elevation: float
):
    level = np.cos(elevation)
    sight = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
    target = np.array(eye) + 0.8 * np.array(sight)
    pose = look_at(eye, target)
    assert np.allclose(pose.inv().apply(target), [0, 0, 0.8], atol=1e-9)
    axes = pose.rotation.as_matrix()
    assert abs(axes[2, 0]) < 1e-12
    assert axes[2, 1] <= 1e-12
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_a_vertical_line_of_sight_is_refused():
    with pytest.raises(InputError, match="must not be vertical"):
        look_at([0, 0, 1], [0, 0, 0])


def test_a_view_that_hides_an_object_is_not_taken():
    ball = Superquadric(
        np.full(3, 0.03), (1, 1), RigidTransform.from_translation([0, 0, 0.03]), "sphere"
    )
    options, rng = ViewOptions(), np.random.default_rng(0)
    pixels = camera_intrinsics(options)
    enough = int(MIN_VISIBLE_SHARE * pixels.width * pixels.height / 16) + 1
    assert draw_viewpoint([ball], options, rng, lambda *_: np.array([enough])) is not None
    assert draw_viewpoint([ball], options, rng, lambda *_: np.array([0])) is None


def test_what_does_not_fit_the_image_has_no_view():
    long = Superquadric(np.array([1.0, 0.02, 0.02]), (0.1, 0.1), RigidTransform.identity())
    rng = np.random.default_rng(0)
    assert draw_viewpoint([long], ViewOptions(), rng, lambda *_: np.array([9999])) is None
