"""Tests of the superquadric shape against closed forms and finite differences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception.superquadric import Superquadric, canonical, mesh, sample_surface

exponents = st.floats(0.1, 1.9)
lengths = st.floats(0.01, 0.2)
seeds = st.integers(0, 2**31 - 1)


def random_solid(rng, e1, e2, axes=None) -> Superquadric:
    pose = RigidTransform.from_components(rng.normal(size=3) * 0.3, Rotation.random(rng=rng))
    return Superquadric(rng.uniform(0.02, 0.1, 3) if axes is None else axes, (e1, e2), pose)


def identity_solid(axes, e) -> Superquadric:
    return Superquadric(np.array(axes), e, RigidTransform.identity())


def test_ball_equals_closed_forms():
    ball = identity_solid([0.05, 0.05, 0.05], (1.0, 1.0))
    points = np.array([[0.1, 0.0, 0.0], [0.0, 0.03, 0.04], [0.0, 0.0, 0.2]])
    assert ball.volume == pytest.approx(4 / 3 * np.pi * 0.05**3, rel=1e-12)
    assert np.allclose(ball.distance(points), [0.05, 0.0, 0.15], atol=1e-12)
    assert ball.support([0.0, 0.0, 1.0]) == pytest.approx(0.05)


def test_small_exponents_approach_box():
    box = identity_solid([0.1, 0.2, 0.3], (0.02, 0.02))
    assert box.volume == pytest.approx(8 * 0.1 * 0.2 * 0.3, rel=2e-3)
    assert box.support(np.ones(3) / np.sqrt(3)) == pytest.approx(0.6 / np.sqrt(3), rel=0.02)


def test_small_exponent_does_not_overflow():
    solid = identity_solid([0.01, 0.01, 0.01], (0.02, 0.02))
    points = np.array([[1000.0, 2.0, 3.0], [0.0, 0.0, 0.0]])
    assert np.all(np.isfinite(solid.radial_scale(points)))
    assert np.all(np.isfinite(solid.distance(points)))
    assert np.all(np.isfinite(solid.implicit(points)))


@given(seed=seeds, e1=exponents, e2=exponents)
def test_gauge_is_homogeneous_and_one_on_surface(seed, e1, e2):
    rng = np.random.default_rng(seed)
    solid = random_solid(rng, e1, e2)
    points = rng.normal(size=(20, 3)) * 0.2
    surface = solid.project_radially(points)
    assert np.allclose(solid.radial_scale(surface), 1.0, rtol=1e-9)
    scaled = solid.centre + 2.5 * (surface - solid.centre)
    assert np.allclose(solid.radial_scale(scaled), 2.5, rtol=1e-9)
    assert np.all(solid.contains(solid.centre + 0.99 * (surface - solid.centre)))


@given(seed=seeds, e1=exponents, e2=exponents)
def test_normals_and_distance_match_finite_differences(seed, e1, e2):
    rng = np.random.default_rng(seed)
    solid = random_solid(rng, e1, e2)
    # Away from the coordinate planes, where second derivatives are unbounded.
    local = rng.uniform(0.2, 1.0, 3) * rng.choice([-1, 1], 3) * solid.semi_axes
    point = solid.to_parent(local)
    step = 1e-7
    numeric = np.array(
        [
            (solid.radial_scale(point + step * d) - solid.radial_scale(point - step * d))
            / (2 * step)
            for d in np.eye(3)
        ]
    )
    length = np.linalg.norm(numeric)
    assert np.allclose(solid.normals(point), numeric / length, atol=1e-5)
    assert solid.distance(point) == pytest.approx(
        (solid.radial_scale(point) - 1) / length, abs=1e-8
    )


@given(seed=seeds, e1=exponents, e2=exponents)
def test_support_is_tight_bound_of_surface(seed, e1, e2):
    rng = np.random.default_rng(seed)
    solid = random_solid(rng, e1, e2)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    extents = mesh(solid, 64)[0] @ direction
    assert extents.max() <= solid.support(direction) + 1e-9
    assert solid.support(direction) - extents.max() < 0.03 * solid.semi_axes.max()


@given(seed=seeds, e1=exponents, e2=exponents, resolution=st.integers(8, 40))
@settings(max_examples=40)
def test_meshes_are_closed_oriented_and_have_volume(seed, e1, e2, resolution):
    solid = random_solid(np.random.default_rng(seed), e1, e2)
    vertices, faces = mesh(solid, resolution)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    directed_edges = {tuple(edge) for edge in edges.tolist()}
    assert len(directed_edges) == len(edges)
    assert all((b, a) in directed_edges for a, b in directed_edges)
    corners = vertices[faces] - solid.centre
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert 0.6 * solid.volume < volume <= solid.volume * (1 + 1e-9)


def test_samples_are_uniform_by_area():
    ball = identity_solid([0.05, 0.05, 0.05], (1.0, 1.0))
    points = sample_surface(ball, 40000, np.random.default_rng(3))
    # Equal slices of a sphere have equal area (Archimedes), so z is uniform.
    counts, _ = np.histogram(points[:, 2], bins=10, range=(-0.05, 0.05))
    assert np.all(np.abs(counts - 4000) < 6 * np.sqrt(4000))


@given(seed=seeds, kind=st.sampled_from(["box", "ellipsoid", "superquadric", "cylinder", "sphere"]))
def test_canonical_form_keeps_surface_and_is_unique(seed, kind):
    rng = np.random.default_rng(seed)
    exps = {"box": (0.1, 0.1), "ellipsoid": (1.0, 1.0), "superquadric": (0.3, 1.2)}
    e = exps.get(kind, (0.1, 1.0) if kind == "cylinder" else (1.0, 1.0))
    axes = rng.uniform(0.02, 0.1, 3)
    if kind in ("cylinder", "sphere"):
        axes[1] = axes[0]
    if kind == "sphere":
        axes[2] = axes[0]
    pose = RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
    solid = Superquadric(axes, e, pose, kind)
    form = canonical(solid)
    points = solid.centre + rng.normal(size=(50, 3)) * 0.1
    assert np.allclose(form.radial_scale(points), solid.radial_scale(points), rtol=1e-6)
    assert np.linalg.det(form.rotation) == pytest.approx(1.0)
    flipped = solid.rotation @ np.diag([-1.0, -1.0, 1.0])
    second_form = canonical(
        Superquadric(
            axes,
            e,
            RigidTransform.from_components(solid.centre, Rotation.from_matrix(flipped)),
            kind,
        )
    )
    assert np.allclose(second_form.semi_axes, form.semi_axes)
    assert np.allclose(second_form.rotation, form.rotation, atol=1e-7)


@pytest.mark.parametrize(
    ("axes", "e", "kind", "message"),
    [
        ([0.1, 0.1, 0.0], (1.0, 1.0), "sphere", "semi_axes"),
        ([0.1, np.nan, 0.1], (1.0, 1.0), "sphere", "semi_axes"),
        ([0.1, 0.1, 0.1], (0.0, 1.0), "sphere", "exponents"),
        ([0.1, 0.1, 0.1], (1.0, 2.0), "sphere", "exponents"),
        ([0.1, 0.1, 0.1], (1.0, 1.0), "cone", "sphere, cylinder"),
    ],
)
def test_invalid_parameters_are_rejected(axes, e, kind, message):
    with pytest.raises(InputError, match=message):
        Superquadric(np.array(axes), e, RigidTransform.identity(), kind)
