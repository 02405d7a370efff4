"""Staged scenes: rendered points against exact geometry, to the micrometre."""

from dataclasses import replace

import numpy as np
import pytest

from eyehand.data_synth import DepthNoise, Table
from eyehand.data_synth.render import (
    StagedObject,
    StagedScene,
    StagedView,
    axial_sigma,
    noise_at_one_metre,
    render_staged,
    staged_frame,
)
from eyehand.data_synth.scenes import staged_solids as shapes
from eyehand.errors import InputError

SMALL = StagedView(image_size=(320, 240))
SCENE = StagedScene(
    (
        StagedObject(shapes.box(0.06, 0.05, 0.08), (-0.15, 0.0, 0.0), yaw=0.5, lean=0.2),
        StagedObject(shapes.ball(0.04), (0.0, 0.05, 0.0)),
        StagedObject(shapes.cylinder(0.03, 0.07), (0.12, -0.03, 0.01)),
        StagedObject(shapes.bowl(0.06, 0.04), (0.02, -0.12, 0.0)),
    ),
    SMALL,
)


def visible_points(scene: StagedScene, label: int) -> np.ndarray:
    """Return the world points (n, 3) of the pixels with a label."""
    frame, labels = staged_frame(scene)
    assert frame.T_world_camera is not None
    return frame.T_world_camera.apply(frame.points()[labels == label].astype(np.float64))


def test_points_of_rotated_box_lie_on_its_faces():
    item = SCENE.objects[0]
    local = item.rotation.inv().apply(visible_points(SCENE, 1) - item.at)
    # The distance to the surface is the largest distance to the three pairs of faces.
    outside = np.abs(local - [0, 0, 0.04]) - np.array([0.03, 0.025, 0.04])
    assert len(local) > 300
    assert np.abs(outside.max(axis=1)).max() < 1e-6


def test_points_of_ball_and_cylinder_lie_on_surface():
    on_ball = np.linalg.norm(visible_points(SCENE, 2) - [0.0, 0.05, 0.04], axis=1)
    assert np.abs(on_ball - 0.04).max() < 1e-6
    local = visible_points(SCENE, 3) - [0.12, -0.03, 0.01]
    top = np.abs(local[:, 2] - 0.07) < 1e-6
    assert top.any()
    # The facets lie up to 30 mm (1 - cos 1°) inside the cylinder.
    radius = np.hypot(*local[~top, :2].T)
    assert np.abs(radius - 0.03).max() < 6e-6


def test_points_of_bowl_lie_on_inside_and_outside():
    local = visible_points(SCENE, 4) - [0.02, -0.12, 0.0]
    across = np.hypot(local[:, 0], local[:, 1])
    inside = (across / 0.056) ** 2 + ((local[:, 2] - 0.04) / 0.036) ** 2
    outside = (across / 0.06) ** 2 + ((local[:, 2] - 0.04) / 0.04) ** 2
    rim = np.abs(local[:, 2] - 0.04) < 1e-6
    on_inside, on_outside = np.abs(inside - 1) < 0.01, np.abs(outside - 1) < 0.01
    assert on_inside.sum() > 300
    assert on_outside.sum() > 50
    # The other points lie on the small step to the foot.
    assert np.mean(on_inside | on_outside | rim) > 0.97


def test_unlabelled_points_lie_on_table_and_floor():
    scene = replace(SCENE, table=Table(size=(0.5, 0.4), floor_drop=0.3))
    z = visible_points(scene, 0)[:, 2]
    flat = np.minimum(np.abs(z), np.abs(z + 0.3)) < 1e-5
    # The other points lie on the edge of the table.
    assert flat.mean() > 0.95
    assert np.all((z < 1e-5) & (z > -0.3 - 1e-5))


def test_mug_and_handle_have_one_label():
    view = replace(SMALL, distance=0.4)
    scene = StagedScene((StagedObject(shapes.mug(0.04, 0.09)),), view)
    local = visible_points(scene, 1)
    assert np.hypot(local[:, 0], local[:, 1]).max() > 0.06
    assert set(np.unique(render_staged(scene).labels)) == {0, 1}
    rotated = StagedScene((StagedObject(shapes.mug(0.04, 0.09), yaw=np.pi),), view)
    # The image of the rotated mug is the mirrored image.
    same = render_staged(rotated).labels[:, ::-1] == render_staged(scene).labels
    assert same.mean() > 0.999


def test_closer_object_hides_farther_one():
    front = StagedObject(shapes.box(0.2, 0.02, 0.2), (0.0, -0.1, 0.0))
    behind = StagedObject(shapes.tapered_box((0.05, 0.05), (0.02, 0.02), 0.05), (0.0, 0.1, 0.0))
    scene = StagedScene((behind, front), replace(SMALL, elevation=0.3))
    labels = render_staged(scene).labels
    assert np.any(labels == 2)
    assert not np.any(labels == 1)


def test_view_shift_moves_image_by_whole_pixels():
    clean = render_staged(SCENE)
    shifted = render_staged(replace(SCENE, view=replace(SMALL, shift=(-40.0, 10.0))))
    assert np.array_equal(shifted.labels[10:, :-40], clean.labels[:-10, 40:])
    assert np.allclose(shifted.depth[10:, :-40], clean.depth[:-10, 40:], atol=1e-6)


def test_noise_has_requested_sigma_and_is_repeatable():
    noise = noise_at_one_metre(0.002)
    assert noise.axial * axial_sigma(np.array(1.0)) == pytest.approx(0.002)
    clean, labels = staged_frame(SCENE)
    noisy, same = staged_frame(SCENE, noise, 3)
    again, _ = staged_frame(SCENE, noise, 3)
    assert np.array_equal(labels, same)
    assert np.array_equal(noisy.depth, again.depth)
    error = (noisy.depth - clean.depth)[clean.valid] / axial_sigma(clean.depth[clean.valid])
    assert error.std() * axial_sigma(np.array(1.0)) == pytest.approx(0.002, rel=0.02)


def test_colour_is_rendered_on_request():
    red = StagedObject(shapes.box(0.1, 0.1, 0.1), colour=(0.9, 0.1, 0.1))
    scene = StagedScene((red,), SMALL)
    frame, labels = staged_frame(scene, colour=True)
    assert frame.colour is not None
    r, g, b = frame.colour[labels == 1].astype(float).mean(axis=0)
    assert r > 2 * max(g, b)
    assert staged_frame(scene)[0].colour is None


def test_views_are_cached_and_read_only():
    first = render_staged(SCENE)
    assert render_staged(SCENE) is first
    with pytest.raises(ValueError, match="read-only"):
        first.depth[0, 0] = 1.0


@pytest.mark.parametrize(
    "fields", [{"elevation": np.pi / 2}, {"distance": 0.0}, {"distance": np.nan}]
)
def test_staged_view_rejects_invalid_values(fields):
    with pytest.raises(InputError):
        StagedView(**fields)


def test_staged_frame_rejects_negative_seed():
    with pytest.raises(InputError, match="seed"):
        staged_frame(SCENE, DepthNoise.none(), -1)
