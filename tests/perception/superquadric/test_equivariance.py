"""Tests of equivariance: a transformed or scaled cloud gives the transformed or scaled solid."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import mesh, sample_surface

MAX_DIFFERENCE = 1e-5
"""Maximum distance between two surfaces, as a share of the solid's largest semi-axis."""
LENGTHS = ("noise", "silhouette_margin", "plane_scale")
"""Options that are lengths, m. The range of semi-axes is a length too."""
DIRECTIONS = np.random.default_rng(0).normal(size=(500, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)

CAMERA = np.array([0.35, -0.3, 0.5])
STRAIGHT = (0.0, 0.0)
SOLIDS: dict[str, tuple[list[float], tuple[float, float], tuple[float, float]]] = {
    "ball": ([0.04, 0.04, 0.04], (1.0, 1.0), STRAIGHT),
    "can": ([0.035, 0.035, 0.06], (0.1, 1.0), STRAIGHT),
    "egg": ([0.07, 0.05, 0.035], (1.0, 1.0), STRAIGHT),
    "brick": ([0.03, 0.05, 0.08], (0.1, 0.1), STRAIGHT),
    "pillow": ([0.06, 0.045, 0.025], (0.5, 0.6), STRAIGHT),
    "diamond": ([0.05, 0.05, 0.04], (1.0, 1.7), STRAIGHT),
    "cup": ([0.04, 0.04, 0.05], (0.1, 1.0), (0.25, 0.25)),
}
VIEWS = ("view", "table", "whole")
"""One view; one view with a known support plane; the whole surface."""
CLOUDS = [(name, view) for name in SOLIDS for view in VIEWS if name != "cup" or view == "whole"]


def observe(name: str, view: str, count: int = 700, noise: float = 0.001) -> dict[str, Any]:
    """Return the arguments of a fit: the points, and camera and plane where known."""
    rng = np.random.default_rng([len(name), len(view)])
    axes, exponents, taper = SOLIDS[name]
    pose = RigidTransform.from_rotation(Rotation.from_euler("z", 0.4))
    kind = "tapered" if any(taper) else "superquadric"
    solid = Superquadric(np.array(axes), exponents, pose, kind, taper)
    points = sample_surface(solid, 4 * count, rng)
    if view != "whole":
        points = points[np.einsum("ij,ij->i", CAMERA - points, solid.normals(points)) > 0]
    points = points[:count] + noise * rng.normal(size=(min(count, len(points)), 3))
    argument_names = {"view": ("view_origin",), "table": ("view_origin", "support_plane")}
    known = {"view_origin": CAMERA, "support_plane": np.array([0.0, 0.0, 1.0, axes[2]])}
    return {"points": points} | {key: known[key] for key in argument_names.get(view, ())}


@cache
def reference_fit(name: str, view: str) -> SuperquadricFit:
    """Fit the untransformed cloud."""
    return fit_superquadric(**observe(name, view))


def transform_cloud(cloud: dict[str, Any], T: RigidTransform) -> dict[str, Any]:
    """Return the arguments of a fit in another frame."""
    other = {key: T.apply(cloud[key]) for key in ("points", "view_origin") if key in cloud}
    if "support_plane" in cloud:
        normal = T.rotation.apply(cloud["support_plane"][:3])
        other["support_plane"] = np.append(
            normal, cloud["support_plane"][3] - normal @ T.translation
        )
    return other


def scale_cloud(cloud: dict[str, Any], factor: float) -> dict[str, Any]:
    """Return the arguments of a fit with all lengths scaled."""
    other = {key: factor * cloud[key] for key in ("points", "view_origin") if key in cloud}
    if "support_plane" in cloud:
        other["support_plane"] = cloud["support_plane"] * [1.0, 1.0, 1.0, factor]
    return other


def surface_difference(first: Superquadric, second: Superquadric) -> float:
    """Return the distance of two surfaces, as a share of the first's largest semi-axis.

    For convex solids the largest difference of the support functions is the Hausdorff distance.
    Distances from points of one surface to the other cover concave parts as well.
    """
    # Relative to the first centre, so that no digits are lost far from the origin.
    offset = DIRECTIONS @ (second.centre - first.centre)
    supports = [solid.support(DIRECTIONS) - DIRECTIONS @ solid.centre for solid in (first, second)]
    points = first.project_radially(mesh(first, 16)[0])
    distances = [np.abs(supports[1] - supports[0] + offset), np.abs(second.distance(points))]
    return float(np.concatenate(distances).max() / first.semi_axes.max())


def transform_solid(T: RigidTransform, solid: Superquadric) -> Superquadric:
    """Return the solid in another frame."""
    return replace(solid, pose=T * solid.pose)


def solid_of(fit: SuperquadricFit) -> Superquadric:
    assert fit, fit.reason
    assert fit.superquadric is not None
    return fit.superquadric


def assert_follows(
    reference: SuperquadricFit, other: SuperquadricFit, expected: Superquadric
) -> None:
    """Assert that `other` has the kind of `reference` and the surface of `expected`."""
    solid = solid_of(other)
    assert solid.kind == solid_of(reference).kind
    assert surface_difference(expected, solid) < MAX_DIFFERENCE


QUATERNIONS = st.one_of(
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1),
    # Rotations by 90° and 180° swap axes and flip signs.
    st.sampled_from(
        [tuple(Rotation.as_quat(quaternion)) for quaternion in Rotation.create_group("O")]
    ),
)
TRANSLATIONS = st.tuples(*[st.floats(-10, 10)] * 3)


@pytest.mark.parametrize(("name", "view"), CLOUDS)
@given(quaternion=QUATERNIONS)
@settings(max_examples=3, deadline=None)
def test_rotated_cloud_gives_rotated_solid(name, view, quaternion):
    cloud, T = observe(name, view), RigidTransform.from_rotation(Rotation.from_quat(quaternion))
    reference, other = reference_fit(name, view), fit_superquadric(**transform_cloud(cloud, T))
    assert_follows(reference, other, transform_solid(T, solid_of(reference)))


@pytest.mark.parametrize(("name", "view"), CLOUDS)
@given(translation=TRANSLATIONS)
@example(translation=(-6e3, 7e3, 4e3))
@settings(max_examples=2, deadline=None)
def test_translated_cloud_gives_translated_solid_up_to_10_km(name, view, translation):
    cloud, T = observe(name, view), RigidTransform.from_translation(translation)
    reference, other = reference_fit(name, view), fit_superquadric(**transform_cloud(cloud, T))
    assert_follows(reference, other, transform_solid(T, solid_of(reference)))


@given(cloud=st.sampled_from(CLOUDS), quaternion=QUATERNIONS, translation=TRANSLATIONS)
@settings(max_examples=25, deadline=None)
def test_transformed_cloud_gives_transformed_solid(cloud, quaternion, translation):
    arguments = observe(*cloud)
    T = RigidTransform.from_components(translation, Rotation.from_quat(quaternion))
    reference, other = reference_fit(*cloud), fit_superquadric(**transform_cloud(arguments, T))
    assert_follows(reference, other, transform_solid(T, solid_of(reference)))


@pytest.mark.parametrize(("name", "view"), CLOUDS)
@given(factor=st.floats(0.1, 10.0))
@settings(max_examples=3, deadline=None)
def test_scaled_cloud_gives_scaled_solid(name, view, factor):
    cloud, options = observe(name, view), FitOptions()
    low, high = options.axis_range
    lengths = {key: factor * getattr(options, key) for key in LENGTHS}
    scaled_options = replace(options, axis_range=(factor * low, factor * high), **lengths)
    reference = reference_fit(name, view)
    other = fit_superquadric(**scale_cloud(cloud, factor), options=scaled_options)
    solid = solid_of(reference)
    pose = RigidTransform.from_components(factor * solid.centre, solid.pose.rotation)
    assert_follows(reference, other, replace(solid, semi_axes=factor * solid.semi_axes, pose=pose))


@pytest.mark.parametrize(("name", "view"), CLOUDS)
def test_float32_cloud_equals_same_values_in_float64(name, view):
    cloud = {key: value.astype(np.float32) for key, value in observe(name, view).items()}
    cloud.pop("support_plane", None)
    double = {key: value.astype(np.float64) for key, value in cloud.items()}
    reference, other = fit_superquadric(**cloud), fit_superquadric(**double)
    assert np.array_equal(solid_of(reference).pose.as_matrix(), solid_of(other).pose.as_matrix())
    assert np.array_equal(solid_of(reference).semi_axes, solid_of(other).semi_axes)


@pytest.mark.parametrize(("name", "view"), CLOUDS)
def test_rounding_to_float32_changes_solid_little(name, view):
    cloud = observe(name, view)
    rounded = cloud | {"points": cloud["points"].astype(np.float32)}
    reference, other = reference_fit(name, view), fit_superquadric(**rounded)
    assert_follows(reference, other, solid_of(reference))


@pytest.mark.parametrize(("name", "view"), CLOUDS)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=2, deadline=None)
def test_point_order_does_not_change_solid(name, view, seed):
    cloud = observe(name, view)
    order = np.random.default_rng(seed).permutation(len(cloud["points"]))
    reference = reference_fit(name, view)
    other = fit_superquadric(**(cloud | {"points": cloud["points"][order]}))
    assert_follows(reference, other, solid_of(reference))


@pytest.mark.parametrize(("name", "view"), CLOUDS)
def test_repeated_fit_is_identical(name, view):
    first, second = (
        solid_of(reference_fit(name, view)),
        solid_of(fit_superquadric(**observe(name, view))),
    )
    assert np.array_equal(first.pose.as_matrix(), second.pose.as_matrix())
    assert np.array_equal(first.semi_axes, second.semi_axes)
    assert first.exponents == second.exponents
