"""The views and the residual colours of a picture."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.apps.fitting.fit_inputs import Cloud
from eyehand.apps.fitting.picture_scene import (
    colour_limit_mm,
    picture_scene,
    picture_views,
    residual_colours,
    residual_to,
)

coordinate = st.floats(-2.0, 2.0)
vector = st.tuples(coordinate, coordinate, coordinate).filter(lambda v: np.linalg.norm(v) > 0.1)


@given(origin=st.none() | vector, normal=st.none() | vector)
def test_views_are_right_handed_and_perpendicular(origin, normal):
    plane = None if normal is None else np.append(np.array(normal) / np.linalg.norm(normal), 0.0)
    place = None if origin is None else np.array(origin)
    cloud = Cloud("c", "c", np.random.default_rng(0).normal(size=(9, 3)) * 0.01, place, plane)
    front, side, top = picture_views(cloud)
    for view in (front, side, top):
        axes = np.array([view.right, view.up, view.towards])
        assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    assert np.allclose(side.towards, front.right)
    assert np.allclose(top.towards, front.up)


def test_front_view_faces_the_camera_with_support_below():
    cloud = Cloud(
        "c", "c", np.zeros((5, 3)), np.array([2.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0, 0.0])
    )
    front, _, _ = picture_views(cloud)
    assert front.towards == pytest.approx([1.0, 0.0, 0.0])
    assert front.up == pytest.approx([0.0, 0.0, 1.0])


def test_up_is_minus_y_in_a_camera_frame():
    front, _, _ = picture_views(Cloud("c", "c", np.full((5, 3), [0.0, 0.0, 0.7]), np.zeros(3)))
    assert front.up == pytest.approx([0.0, -1.0, 0.0])
    assert front.towards == pytest.approx([0.0, 0.0, -1.0])


def test_colours_are_blue_inside_grey_on_and_red_outside():
    inside, on, outside = residual_colours(np.array([-0.003, 0.0, 0.003]), 3.0)
    assert inside[2] > inside[0]
    assert outside[0] > outside[2]
    assert np.ptp(on) < 0.1
    assert np.array_equal(residual_colours(np.array([-0.9, 0.9]), 3.0), [inside, outside])


def test_colour_scale_ends_at_a_round_number():
    assert colour_limit_mm(np.full(9, 0.0017)) == 2.0
    assert colour_limit_mm(np.full(9, 9.0)) == 500


def test_residual_is_to_the_nearest_solid(can, lens):
    parts = (can.fit.superquadric, lens.fit.superquadric)
    nearest, residuals = residual_to(lens.cloud.points, parts)
    assert np.mean(nearest == 1) > 0.99
    assert np.abs(residuals).max() < 0.005


def test_scene_is_centred_and_contains_everything(lens, unfit):
    scene = picture_scene(lens)
    for vertices, _ in scene.surfaces:
        assert np.abs(vertices).max() < scene.half * np.sqrt(3)
    assert np.abs(scene.points).max() < scene.half
    assert 0 < scene.limit_mm <= 2.0
    bare = picture_scene(unfit)
    assert bare.surfaces == ()
    assert bare.limit_mm == 0.0
