"""Tests of the alternatives of solids whose end is hidden."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation
from synthetic_solids import Box, solid_frame

from eyehand.perception import (
    DepthFrame,
    FitOptions,
    Superquadric,
    SuperquadricFit,
    SupportPlane,
    fit_region,
)
from eyehand.perception.superquadric import sample_surface
from eyehand.perception.superquadric.cost_kernels import distances
from eyehand.perception.superquadric.free_space import solid_parameters
from eyehand.perception.superquadric.occlusion import _with_extent, occlusion_alternatives
from eyehand.perception.superquadric.outliers import FilteredCloud
from eyehand.perception.superquadric.problem import Observation
from eyehand.perception.superquadric.unseen_depth import with_depth

NOISE = 0.0007
"""Noise of the readings, m."""
SIZE = (0.14, 0.05, 0.08)
"""Size of the box that is fitted, m: its longest side runs from side to side."""
TABLE = SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)
SIDE = np.array([1.0, 0.0, 0.0])
"""Direction in which the box is hidden."""


def fit_box(x: float, *occluders: Box) -> tuple[Box, SuperquadricFit]:
    """Fit a box at `x` m to the side, behind occluders."""
    box = Box(x, 0.62, SIZE, yaw=0.2)
    frame, labels = solid_frame([box, *occluders], known_pose=True)
    noise = NOISE * np.random.default_rng(3).normal(size=frame.depth.shape)
    frame = DepthFrame((frame.depth + noise).astype(np.float32), frame.intrinsics, pose(frame))
    fit, _ = fit_region(frame, labels, 1, TABLE.moved(pose(frame).inv()))
    return box, fit


def pose(frame: DepthFrame):
    assert frame.T_world_camera is not None
    return frame.T_world_camera


def true_end(box: Box) -> float:
    """Return how far a box reaches along SIDE, m."""
    half = np.array(box.size) / 2
    return box.x + float(half[:2] @ np.abs([np.cos(box.yaw), np.sin(box.yaw)]))


def ends(fit: SuperquadricFit) -> NDArray[np.float64]:
    """Return how far a fit and its alternatives reach along SIDE, (K,), m."""
    assert fit.superquadric is not None
    solids = [fit.superquadric, *(other.superquadric for other in fit.alternatives)]
    return np.array([solid.support(SIDE) for solid in solids])


def test_box_behind_an_occluder_may_end_later():
    occluder = Box(0.09, 0.5, (0.13, 0.03, 0.25))
    box, fit = fit_box(0.0, occluder)
    assert fit
    assert fit.ambiguous
    reach = ends(fit)
    assert reach.min() - 0.003 < true_end(box) < reach.max() + 0.003
    # The outline at the occluder is not the outline of the box.
    assert fit.covered_share < 0.02
    assert all(other.criterion >= fit.candidates[0].criterion for other in fit.alternatives)
    hidden = next(side for side in fit.sides if side.direction @ SIDE > 0.9)
    seen = next(side for side in fit.sides if side.direction @ SIDE < -0.9)
    assert hidden.sigma > 2.0 * seen.sigma


def test_box_cut_by_the_image_border_may_end_later():
    box, fit = fit_box(0.5)
    assert fit
    assert fit.ambiguous
    assert ends(fit).max() > true_end(box) - 0.003


@pytest.mark.parametrize(
    "occluders", [(), (Box(0.16, 0.62, (0.08, 0.05, 0.08)),), (Box(0.0, 0.45, (0.3, 0.03, 0.02)),)]
)
def test_box_whose_ends_are_seen_has_no_alternatives(occluders: tuple[Box, ...]):
    box, fit = fit_box(0.0, *occluders)
    assert fit
    assert not fit.ambiguous
    assert ends(fit)[0] == pytest.approx(true_end(box), abs=0.003)


def test_points_far_inside_the_end_of_a_solid_are_no_error():
    _, fit = fit_box(0.0, Box(0.09, 0.5, (0.13, 0.03, 0.25)))
    evidence = fit.evidence
    assert fit.superquadric is not None
    assert evidence is not None
    cloud = FilteredCloud(evidence.points, 0.0, on_grid=True)
    view = Observation(cloud, evidence.view_origin, evidence.plane, evidence.free_space)
    for shift in (0.1, 0.3, 1.0):
        pose = RigidTransform.from_translation(shift * SIDE) * fit.superquadric.pose
        away = replace(fit.superquadric, pose=pose)
        first = replace(fit.candidates[0], superquadric=away)
        moved = replace(fit, superquadric=away, parts=(away,), candidates=(first,))
        found = occlusion_alternatives(moved, view, FitOptions())
        assert all(np.all(other.superquadric.semi_axes > 0) for other in found)


def test_every_part_may_end_later_behind_an_occluder():
    _, fit = fit_box(0.0, Box(0.09, 0.5, (0.13, 0.03, 0.25)))
    evidence, whole = fit.evidence, fit.superquadric
    assert whole is not None
    assert evidence is not None
    cloud = FilteredCloud(evidence.points, 0.0, on_grid=True)
    view = Observation(cloud, evidence.view_origin, evidence.plane, evidence.free_space)
    axis = int(np.argmax(np.abs(whole.rotation.T @ SIDE)))
    along = whole.rotation[:, axis] * np.sign(whole.rotation[:, axis] @ SIDE)
    parts = []
    for share, shift in ((0.7, -0.3), (0.3, 0.7)):
        half = whole.semi_axes.copy()
        half[axis] *= share
        move = RigidTransform.from_translation(shift * whole.semi_axes[axis] * along)
        parts.append(replace(whole, semi_axes=half, pose=move * whole.pose, kind="superquadric"))
    divided = replace(fit, superquadric=parts[0], parts=tuple(parts), alternatives=())
    found = occlusion_alternatives(divided, view, FitOptions())
    reach = max(float(other.superquadric.support(SIDE)) for other in found)
    assert reach > float(parts[1].support(SIDE)) + 0.01


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("change", [-0.02, 0.05])
def test_moved_side_equals_the_solid_of_another_depth(axis, change):
    pose = RigidTransform.from_components([0.1, 0.2, 0.6], Rotation.from_rotvec([0.3, 0.2, 0.5]))
    solid = Superquadric(np.array([0.03, 0.04, 0.05]), (0.4, 0.8), pose)
    outwards = solid.rotation[:, axis]
    moved = _with_extent(solid_parameters(solid), axis, outwards, change)
    depth = 2.0 * float(solid.semi_axes[axis]) + change
    points = sample_surface(with_depth(solid, axis, -outwards, depth), 50, np.random.default_rng(0))
    np.testing.assert_allclose(distances(points, moved), 0.0, atol=1e-6)
