"""Tests of perceiving a scene from one exact frame."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation
from synthetic_balls import CAMERA, UP, ball_centre, ball_frame

from eyehand.errors import InputError
from eyehand.perception import (
    SUPPORT,
    DepthFrame,
    PerceiveOptions,
    fit_region,
    perceive,
    region_evidence,
)

BALLS = [(-0.12, 0.62, 0.05), (0.0, 0.75, 0.04), (0.13, 0.6, 0.045)]


def test_balls_are_fitted_as_spheres():
    frame, truth = ball_frame(BALLS)
    scene = perceive(frame)
    assert scene.reference_frame == "camera"
    assert len(scene.objects) == 3
    for item in scene.objects:
        solid = item.fit.superquadric
        assert solid is not None
        assert solid.kind == "sphere"
        true_labels = truth[scene.segmentation.mask(item.label)]
        x, y, radius = BALLS[np.bincount(true_labels).argmax() - 1]
        assert solid.semi_axes[0] == pytest.approx(radius, abs=0.002)
        assert np.linalg.norm(solid.centre - ball_centre(x, y, radius)) < 0.004
        assert item.rests_on == SUPPORT
        assert item.visible_share > 0.9


def test_known_camera_pose_gives_world_frame():
    frame, _ = ball_frame(BALLS[:1])
    rotation = Rotation.align_vectors([[0.0, 0.0, 1.0]], [UP])[0]
    T = RigidTransform.from_components([0.3, -0.2, 0.6], rotation)
    scene = perceive(DepthFrame(frame.depth, CAMERA, T))
    assert scene.reference_frame == "world"
    assert np.allclose(scene.view_origin, [0.3, -0.2, 0.6])
    assert scene.support is not None
    assert scene.support.normal[2] > 0.9999
    assert scene.support.offset == pytest.approx(0.0, abs=2e-3)
    solid = scene.objects[0].fit.superquadric
    assert solid is not None
    assert solid.centre[2] == pytest.approx(0.05, abs=0.003)


def test_far_objects_are_segmented_but_not_fitted():
    frame, _ = ball_frame(BALLS)
    scene = perceive(frame, PerceiveOptions(max_distance=0.5))
    assert len(scene.objects) == 3
    assert all("not fitted" in item.fit.reason for item in scene.objects)
    assert all(item.fit.superquadric is None and not item.fit for item in scene.objects)


def test_occluded_object_has_smaller_visible_share():
    front, behind = (0.02, 0.5, 0.09), (0.07, 0.68, 0.05)
    frame, truth = ball_frame([front, behind])
    _, alone = ball_frame([behind])
    expected = np.count_nonzero(truth == 2) / np.count_nonzero(alone)
    shares = {}
    scene = perceive(frame)
    for item in scene.objects:
        ball = int(np.bincount(truth[scene.segmentation.mask(item.label)]).argmax())
        shares[ball] = item.visible_share
    assert shares[1] > 0.9
    assert expected < 0.8
    # The share refers to the outline of the fit. Half a ball does not show its full size.
    assert shares[2] == pytest.approx(expected, abs=0.15)


def test_equal_frames_give_equal_scenes():
    frame, _ = ball_frame(BALLS)
    first, second = perceive(frame), perceive(frame)
    assert np.array_equal(first.segmentation.labels, second.segmentation.labels)
    for a, b in zip(first.objects, second.objects, strict=True):
        assert a.fit.superquadric is not None
        assert b.fit.superquadric is not None
        assert np.array_equal(a.fit.superquadric.semi_axes, b.fit.superquadric.semi_axes)


def test_a_known_region_is_fitted_as_in_the_scene():
    frame, _ = ball_frame(BALLS)
    rotation = Rotation.align_vectors([[0.0, 0.0, 1.0]], [UP])[0]
    T = RigidTransform.from_components([0.3, -0.2, 0.6], rotation)
    frame = DepthFrame(frame.depth, CAMERA, T)
    scene = perceive(frame)
    segmentation = scene.segmentation
    # The random choice of points is the same for the first object only.
    fit, points = fit_region(frame, segmentation.labels, 1, segmentation.support)
    expected = scene.objects[0]
    assert np.array_equal(points, expected.points)
    assert fit.superquadric is not None
    assert expected.fit.superquadric is not None
    assert np.array_equal(fit.superquadric.semi_axes, expected.fit.superquadric.semi_axes)
    assert np.array_equal(fit.superquadric.centre, expected.fit.superquadric.centre)


def test_a_region_without_pixels_is_refused():
    frame, truth = ball_frame(BALLS[:1])
    with pytest.raises(InputError, match="label must be that of a region with pixels, got 5"):
        region_evidence(frame, truth.astype(np.int32), 5, None)
