"""Tests of the alternatives of solids whose depth the view does not show."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import sample_surface

NOISE = 0.001
EYE = np.array([0.02, -0.65, 0.1])
HALF = (0.06, 0.02, 0.06)


def visible_cloud(solid: Superquadric, eye: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 1500 visible points (N, 3) of a convex solid with noise."""
    rng = np.random.default_rng(4)
    points = sample_surface(solid, 12000, rng)
    facing = np.einsum("ij,ij->i", solid.normals(points), eye - points) > 0
    return points[facing][:1500] + rng.normal(0.0, NOISE, (min(facing.sum(), 1500), 3))


def fit_view(
    solid: Superquadric, eye: NDArray[np.float64], max_parts: int = FitOptions().max_parts
) -> SuperquadricFit:
    table = np.array([0.0, 0.0, 1.0, 0.0])
    options = FitOptions(max_parts=max_parts)
    cloud = visible_cloud(solid, eye)
    return fit_superquadric(cloud, view_origin=eye, support_plane=table, options=options)


def box(yaw: float = 0.0) -> Superquadric:
    """Return an upright box on the table z = 0, its large face towards EYE at yaw 0."""
    pose = RigidTransform.from_components([0, 0, HALF[2]], Rotation.from_rotvec([0, 0, yaw]))
    return Superquadric(np.array(HALF), (0.05, 0.05), pose, "box")


def test_face_of_a_box_has_a_deeper_alternative():
    fit = fit_view(box(), EYE)
    assert fit.ambiguous
    side = np.array([0.0, 1.0, 0.0])
    assert float(fit.alternatives[-1].superquadric.support(side)) > HALF[1]


def test_face_of_a_box_has_alternatives_from_thin_to_deep():
    fit = fit_view(box(), EYE, max_parts=1)
    assert fit.ambiguous
    thin, deep = fit.alternatives[-2:]
    side = np.array([0.0, 1.0, 0.0])
    backs = [float(one.superquadric.support(side)) for one in (thin, deep)]
    assert backs[0] < HALF[1] < backs[1]
    assert thin.criterion == fit.candidates[0].criterion


@pytest.mark.parametrize("elevation_deg", [40.0, 60.0, 85.0])
def test_support_plane_determines_the_depth(elevation_deg):
    angle = np.radians(elevation_deg)
    eye = 0.65 * np.array([0.0, -np.cos(angle), np.sin(angle)])
    fit = fit_view(box(), eye)
    assert fit
    assert not fit.ambiguous


def test_corner_view_determines_the_depth():
    fit = fit_view(box(0.7), EYE + np.array([0.0, 0.0, 0.2]))
    assert fit
    assert not fit.ambiguous


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_curvature_determines_the_depth(kind):
    exponents = (1.0, 1.0) if kind == "sphere" else (0.05, 1.0)
    place = RigidTransform.from_translation([0.0, 0.0, 0.04])
    solid = Superquadric(np.full(3, 0.04), exponents, place, kind)
    fit = fit_view(solid, EYE)
    assert fit
    assert not fit.ambiguous
    assert fit.superquadric is not None
    assert fit.superquadric.semi_axes == pytest.approx(0.04, abs=0.002)
