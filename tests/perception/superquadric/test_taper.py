"""Tests of tapered solids: gauge, normals, support, volume, mesh and canonical form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception.superquadric import MAX_TAPER, Superquadric, canonical, mesh, sample_surface

exponents = st.floats(0.1, 1.9)
tapers = st.floats(-0.8, 0.8)
seeds = st.integers(0, 2**31 - 1)


def random_tapered(rng, e, taper) -> Superquadric:
    pose = RigidTransform.from_components(rng.normal(size=3) * 0.3, Rotation.random(rng=rng))
    return Superquadric(rng.uniform(0.02, 0.1, 3), e, pose, "tapered", taper)


def upright_tapered(axes, e, taper) -> Superquadric:
    return Superquadric(np.array(axes), e, RigidTransform.identity(), "tapered", taper)


def mesh_volume(solid: Superquadric, resolution: int) -> float:
    vertices, faces = mesh(solid, resolution)
    corners = vertices[faces] - solid.centre
    return float(np.linalg.det(corners).sum() / 6)


def reference_support(d, axes, e, taper) -> float:
    """Return the maximum of d·x over sections at heights sign(sin θ)|sin θ|^ε1.

    These heights are dense where the outline is steep.
    """
    angle = np.linspace(-np.pi / 2, np.pi / 2, 40001)
    height = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** e[0]
    size = np.cos(angle) ** e[0]
    power = 2.0 / (2.0 - e[1])
    widths = np.abs(d[:2]) * axes[:2] * (1.0 + height[:, None] * np.array(taper))
    widest = widths.max(axis=1)
    half_width = widest * np.sum((widths / widest[:, None]) ** power, axis=1) ** (1.0 / power)
    return float((size * half_width + height * axes[2] * d[2]).max())


def test_positive_taper_widens_top():
    cup = upright_tapered([0.04, 0.04, 0.05], (0.02, 1.0), (0.25, 0.25))
    assert cup.support([1.0, 0.0, 0.0]) == pytest.approx(0.05, rel=0.01)
    rims = np.array([[0.0495, 0.0, 0.049], [0.0305, 0.0, -0.049], [0.0325, 0.0, -0.049]])
    assert cup.contains(rims).tolist() == [True, False, False]
    assert cup.contains([0.0295, 0.0, -0.049])


def test_truncated_cone_has_exact_volume():
    cone = upright_tapered([0.04, 0.04, 0.05], (0.02, 1.0), (0.5, 0.5))
    below, above, height = 0.02, 0.06, 0.1
    exact = np.pi * height / 3 * (below**2 + below * above + above**2)
    assert cone.volume == pytest.approx(exact, rel=2e-3)


@given(seed=seeds, e1=exponents, e2=exponents, k1=tapers, k2=tapers)
def test_gauge_equals_straight_solid_at_untapered_points(seed, e1, e2, k1, k2):
    rng = np.random.default_rng(seed)
    solid = random_tapered(rng, (e1, e2), (k1, k2))
    straight = Superquadric(solid.semi_axes, solid.exponents, RigidTransform.identity())
    local = rng.uniform(-1.0, 1.0, (30, 3)) * [0.2, 0.2, solid.semi_axes[2]]
    # The definition of Barr (1984), point by point.
    height = local[:, 2] / solid.semi_axes[2]
    untapered = np.column_stack(
        [local[:, 0] / (1 + k1 * height), local[:, 1] / (1 + k2 * height), local[:, 2]]
    )
    points = solid.to_parent(local)
    assert np.allclose(solid.radial_scale(points), straight.radial_scale(untapered), rtol=1e-8)
    assert np.allclose(solid.radial_scale(solid.project_radially(points)), 1.0, rtol=1e-8)


@given(seed=seeds, e1=exponents, e2=exponents, k1=tapers, k2=tapers)
def test_normals_and_distance_match_finite_differences(seed, e1, e2, k1, k2):
    rng = np.random.default_rng(seed)
    solid = random_tapered(rng, (e1, e2), (k1, k2))
    # Away from the coordinate planes, where second derivatives are unbounded.
    local = rng.uniform(0.2, 0.9, 3) * rng.choice([-1, 1], 3) * solid.semi_axes
    point, step = solid.to_parent(local), 1e-7
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


@given(
    seed=seeds,
    e1=st.floats(0.02, 1.98),
    e2=st.floats(0.02, 1.98),
    k1=tapers,
    k2=tapers,
    tilt=st.sampled_from([1.0, 1e-2, 1e-3, 1e-5]),
)
@settings(max_examples=40)
def test_support_equals_maximum_over_sections(seed, e1, e2, k1, k2, tilt):
    rng = np.random.default_rng(seed)
    axes = rng.uniform(0.02, 0.1, 3)
    solid = upright_tapered(axes, (e1, e2), (k1, k2))
    # For directions near z the extreme point lies close to the pole.
    direction = rng.normal(size=3) * [tilt, tilt, 1.0]
    direction /= np.linalg.norm(direction)
    expected = reference_support(direction, axes, (e1, e2), (k1, k2))
    assert solid.support(direction) == pytest.approx(expected, abs=1e-6 * axes.max())
    assert solid.support(direction) >= (mesh(solid, 32)[0] @ direction).max() - 1e-12


@given(seed=seeds, e1=exponents, e2=exponents, k1=tapers, k2=tapers)
@settings(max_examples=25)
def test_volume_equals_mesh_volume(seed, e1, e2, k1, k2):
    solid = random_tapered(np.random.default_rng(seed), (e1, e2), (k1, k2))
    # The volume error of the mesh is quadratic in its step: extrapolate to step zero.
    coarse, fine = mesh_volume(solid, 64), mesh_volume(solid, 128)
    assert solid.volume == pytest.approx(fine + (fine - coarse) / 3, rel=0.02)


@pytest.mark.parametrize("e", [(0.1, 1.0), (0.5, 0.3), (1.0, 1.0), (1.7, 0.6)])
@pytest.mark.parametrize("taper", [(0.4, 0.4), (0.6, -0.5), (-0.7, 0.0)])
def test_volume_equals_monte_carlo(e, taper):
    rng = np.random.default_rng(0)
    solid = upright_tapered([0.04, 0.03, 0.05], e, taper)
    half = np.array([0.04 * 1.7, 0.03 * 1.7, 0.05])
    points = rng.uniform(-half, half, (200_000, 3))
    share = float(np.mean(solid.contains(points)))
    sigma = np.sqrt(share * (1 - share) / len(points))
    assert solid.volume / (8 * half.prod()) == pytest.approx(share, abs=5 * sigma)


def test_samples_and_mesh_lie_on_surface_facing_outwards():
    solid = random_tapered(np.random.default_rng(1), (0.3, 0.8), (0.4, -0.3))
    points = sample_surface(solid, 500, np.random.default_rng(2))
    assert np.allclose(solid.radial_scale(points), 1.0, rtol=1e-8)
    vertices, faces = mesh(solid, 32)
    assert np.allclose(solid.radial_scale(vertices), 1.0, rtol=1e-5)
    corners = vertices[faces]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Facets at an edge can point anywhere between the normals of their corners.
    outwards = np.einsum("ij,ij->i", outward, solid.normals(corners.mean(axis=1))) > 0
    assert np.mean(outwards) > 0.99


@given(seed=seeds, k1=tapers, k2=tapers)
def test_canonical_form_keeps_surface_and_is_unique(seed, k1, k2):
    rng = np.random.default_rng(seed)
    solid = random_tapered(rng, (0.3, 1.2), (k1, k2))
    form = canonical(solid)
    points = solid.centre + rng.normal(size=(50, 3)) * 0.1
    assert np.allclose(form.radial_scale(points), solid.radial_scale(points), rtol=1e-6)
    assert form.semi_axes[0] >= form.semi_axes[1]
    # Flipped, or with x and y exchanged, the same solid has other parameters.
    flipped = solid.rotation @ np.diag([1.0, -1.0, -1.0])
    half_width = solid.rotation[:, [1, 0, 2]] * [1.0, 1.0, -1.0]
    swapped = solid.semi_axes[[1, 0, 2]]
    for axes, R, taper in (
        (solid.semi_axes, flipped, (-k1, -k2)),
        (swapped, half_width, (-k2, -k1)),
    ):
        pose = RigidTransform.from_components(solid.centre, Rotation.from_matrix(R))
        equivalent = Superquadric(axes, solid.exponents, pose, "tapered", taper)
        assert np.allclose(equivalent.radial_scale(points), solid.radial_scale(points), rtol=1e-6)
        form_of_equivalent = canonical(equivalent)
        assert np.allclose(form_of_equivalent.semi_axes, form.semi_axes)
        assert np.allclose(form_of_equivalent.rotation, form.rotation, atol=1e-7)
        assert form_of_equivalent.taper == pytest.approx(form.taper)


def test_invalid_taper_is_rejected():
    with pytest.raises(InputError, match="taper must lie in"):
        upright_tapered([0.1, 0.1, 0.1], (1.0, 1.0), (MAX_TAPER + 0.01, 0.0))
    with pytest.raises(InputError, match="taper must lie in"):
        upright_tapered([0.1, 0.1, 0.1], (1.0, 1.0), (np.nan, 0.0))
    with pytest.raises(InputError, match="unless kind is tapered"):
        Superquadric(np.full(3, 0.1), (0.1, 1.0), RigidTransform.identity(), "box", (0.1, 0.0))
