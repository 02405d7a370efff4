"""Depth frames of synthetic scenes: points, labels and noise."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.data_synth import DepthNoise, TabletopOptions, ViewOptions, make_scene, render_frame
from eyehand.errors import InputError

OPTIONS = TabletopOptions(count_range=(2, 3), view=ViewOptions(image_size=(160, 120)))


def test_frame_has_camera_pose_and_colour():
    scene = make_scene(0, OPTIONS)
    frame, labels = render_frame(scene)
    assert frame.T_world_camera is scene.T_world_camera
    assert frame.intrinsics == scene.intrinsics
    assert frame.colour is not None
    assert frame.depth.shape == labels.shape == (120, 160)
    assert set(np.unique(labels)) == set(range(len(scene.objects) + 1))


def test_points_of_object_lie_inside_solid():
    scene = make_scene(1, OPTIONS)
    frame, labels = render_frame(scene, colour=False)
    for label, item in enumerate(scene.objects, start=1):
        points = scene.T_world_camera.apply(frame.points()[labels == label].astype(float))
        assert np.all(item.shape.radial_scale(points) < 1.02)


def test_noise_is_repeatable_with_seed():
    scene = make_scene(0, OPTIONS)
    clean, _ = render_frame(scene, colour=False)
    one, _ = render_frame(scene, DepthNoise.realistic(), 1, colour=False)
    same, _ = render_frame(scene, DepthNoise.realistic(), 1, colour=False)
    other, _ = render_frame(scene, DepthNoise.realistic(), 2, colour=False)
    assert np.array_equal(one.depth, same.depth)
    assert not np.array_equal(one.depth, other.depth)
    assert not np.array_equal(one.depth, clean.depth)


def test_negative_seed_is_rejected():
    with pytest.raises(InputError, match="seed must be a whole number >= 0, got -1"):
        render_frame(make_scene(0, OPTIONS), seed=-1)
