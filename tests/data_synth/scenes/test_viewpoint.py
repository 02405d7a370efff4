"""Camera viewpoints: target on the optical axis, level rows, and visible objects."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import ViewOptions, look_at
from eyehand.data_synth.scenes.viewpoint import MIN_VISIBLE_SHARE, camera_intrinsics, draw_viewpoint
from eyehand.errors import InputError
from eyehand.perception.superquadric import Superquadric

coordinate = st.floats(-2, 2)


@given(
    eye=st.tuples(coordinate, coordinate, coordinate),
    azimuth=st.floats(0, 6.28),
    elevation=st.floats(-1.5, 1.5),
)
def test_target_is_on_optical_axis_and_rows_are_level(
    eye: tuple[float, float, float], azimuth: float, elevation: float
):
    level = np.cos(elevation)
    view_direction = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
    target = np.array(eye) + 0.8 * np.array(view_direction)
    pose = look_at(eye, target)
    assert np.allclose(pose.inv().apply(target), [0, 0, 0.8], atol=1e-9)
    axes = pose.rotation.as_matrix()
    assert abs(axes[2, 0]) < 1e-12
    assert axes[2, 1] <= 1e-12
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_look_at_rejects_vertical_direction():
    with pytest.raises(InputError, match="must not be vertical"):
        look_at([0, 0, 1], [0, 0, 0])


def test_viewpoint_with_hidden_object_is_rejected():
    ball = Superquadric(
        np.full(3, 0.03), (1, 1), RigidTransform.from_translation([0, 0, 0.03]), "sphere"
    )
    options, rng = ViewOptions(), np.random.default_rng(0)
    pixels = camera_intrinsics(options)
    min_pixels = int(MIN_VISIBLE_SHARE * pixels.width * pixels.height / 16) + 1
    assert draw_viewpoint([ball], options, rng, lambda *_: np.array([min_pixels])) is not None
    assert draw_viewpoint([ball], options, rng, lambda *_: np.array([0])) is None


def test_object_larger_than_image_has_no_viewpoint():
    long = Superquadric(np.array([1.0, 0.02, 0.02]), (0.1, 0.1), RigidTransform.identity())
    rng = np.random.default_rng(0)
    assert draw_viewpoint([long], ViewOptions(), rng, lambda *_: np.array([9999])) is None
