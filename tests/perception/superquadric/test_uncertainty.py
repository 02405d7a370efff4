"""Tests of the uncertainty of a fit: it matches the scatter, and reports unobserved sides."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import PARAMETERS, Kind, Uncertainty, canonical, sample_surface
from eyehand.perception.superquadric.kinds import basis

REPEATS = 40
NOISE = 0.002
MAX_RATIO = 3.0
"""Maximum ratio of estimated to measured standard deviation. The estimate uses few samples."""
ROTATION = Rotation.from_euler("xyz", [0.3, 0.2, 0.5])
SOLIDS: dict[Kind, tuple[list[float], tuple[float, float], tuple[float, float]]] = {
    "sphere": ([0.04, 0.04, 0.04], (1.0, 1.0), (0.0, 0.0)),
    "cylinder": ([0.04, 0.04, 0.05], (0.1, 1.0), (0.0, 0.0)),
    "ellipsoid": ([0.06, 0.045, 0.03], (1.0, 1.0), (0.0, 0.0)),
    # Longest along z: the canonical form permutes these axes.
    "box": ([0.03, 0.04, 0.06], (0.1, 0.1), (0.0, 0.0)),
    "superquadric": ([0.035, 0.05, 0.03], (0.5, 0.7), (0.0, 0.0)),
    "tapered": ([0.035, 0.045, 0.05], (0.5, 0.8), (0.15, 0.3)),
}


def make_solid(kind: Kind) -> Superquadric:
    axes, exponents, taper = SOLIDS[kind]
    pose = RigidTransform.from_rotation(ROTATION)
    return Superquadric(np.array(axes), exponents, pose, kind, taper)


def fit_whole_surface(kind: Kind, seed: int) -> SuperquadricFit:
    """Fit the noisy whole surface of a solid with its own kind."""
    rng = np.random.default_rng(seed)
    points = sample_surface(make_solid(kind), 500, rng) + NOISE * rng.normal(size=(500, 3))
    return fit_superquadric(points, options=FitOptions(kinds=(kind,)))


def parameters_of(solid: Superquadric, reference_rotation: Rotation) -> np.ndarray:
    """Return the PARAMETERS of a solid, with its rotation relative to a reference."""
    rotation = (reference_rotation.inv() * solid.pose.rotation).as_rotvec()
    return np.concatenate([solid.semi_axes, solid.exponents, rotation, solid.centre, solid.taper])


def uncertainty_of(fit: SuperquadricFit) -> Uncertainty:
    assert fit, fit.reason
    assert fit.uncertainty is not None
    return fit.uncertainty


def fit_front_view(kind: Kind, axes: list[float], seed: int) -> SuperquadricFit:
    """Fit a solid on a table, viewed from the front at 0.7 m: all points lie on its -y side."""
    rng = np.random.default_rng(seed)
    exponents = {"box": (0.1, 0.1), "sphere": (1.0, 1.0)}[kind]
    solid = Superquadric(np.array(axes), exponents, RigidTransform.identity(), kind)
    camera = np.array([0.0, -0.7, 0.0])
    points = sample_surface(solid, 15000, rng)
    points = points[np.einsum("ij,ij->i", camera - points, solid.normals(points)) > 0][:600]
    points += 0.001 * rng.normal(size=points.shape)
    return fit_superquadric(
        points,
        view_origin=camera,
        support_plane=[0.0, 0.0, 1.0, axes[2]],
        options=FitOptions(kinds=(kind,)),
    )


@pytest.mark.parametrize("kind", SOLIDS)
def test_covariance_is_valid_and_zero_for_fixed_parameters(kind):
    covariance = uncertainty_of(fit_whole_surface(kind, 0)).covariance
    assert covariance.shape == (len(PARAMETERS), len(PARAMETERS))
    assert np.array_equal(covariance, covariance.T)
    eigenvalues = np.linalg.eigvalsh(covariance)
    assert eigenvalues.min() > -1e-9 * eigenvalues.max()
    # The canonical form permutes parameters only within their group.
    free = np.asarray(basis(kind)).any(axis=1)
    fixed = np.logical_not(free)
    if kind == "cylinder":
        assert np.allclose(covariance[7], 0.0, atol=1e-12)
        fixed[5:8] = False
    assert np.all(covariance[fixed] == 0.0)
    assert np.all(covariance[:, fixed] == 0.0)
    assert np.all(uncertainty_of(fit_whole_surface(kind, 0)).standard_deviations[free] > 0.0)


@pytest.mark.parametrize("kind", SOLIDS)
def test_standard_deviations_match_scatter_of_repeated_fits(kind):
    reference_rotation = canonical(make_solid(kind)).pose.rotation
    fits = [fit_whole_surface(kind, seed) for seed in range(REPEATS)]
    parameters = [
        parameters_of(fit.superquadric, reference_rotation)
        for fit in fits
        if fit.superquadric is not None
    ]
    # The median ignores fits whose canonical form permutes the axes.
    scatter = 1.4826 * np.median(np.abs(parameters - np.median(parameters, axis=0)), axis=0)
    estimated = np.median([uncertainty_of(fit).standard_deviations for fit in fits], axis=0)
    # Rotations about a cylinder axis, and all rotations of a sphere, are fixed.
    free = estimated > 1e-9
    assert np.all(estimated[free] < MAX_RATIO * scatter[free])
    assert np.all(estimated[free] > scatter[free] / MAX_RATIO)


def test_uncertainty_follows_axis_permutation():
    # A box with both ends of its longest axis in the cloud, but one side of each other axis.
    rng = np.random.default_rng(0)
    points = rng.uniform(-1.0, 1.0, (900, 3)) * [0.03, 0.04, 0.06]
    points[:300, 0], points[300:600, 1] = 0.03, 0.04
    points[600:, 2] = np.sign(points[600:, 2]) * 0.06
    points += 0.001 * rng.normal(size=points.shape)
    for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2]):
        fit = fit_superquadric(points[:, order], options=FitOptions(kinds=("box",)))
        solid, deviations = fit.superquadric, uncertainty_of(fit).standard_deviations
        assert solid is not None
        assert solid.semi_axes == pytest.approx([0.06, 0.04, 0.03], abs=2e-3)
        # Only the longest axis has both ends in the cloud.
        assert deviations[0] < deviations[1]
        assert deviations[0] < deviations[2]


def test_covariance_rotates_with_cloud():
    rng = np.random.default_rng(0)
    cloud = sample_surface(make_solid("superquadric"), 500, rng)
    cloud = (
        cloud[cloud[:, 2] > -0.01]
        + 0.001 * rng.normal(size=(500, 3))[: np.sum(cloud[:, 2] > -0.01)]
    )
    T = RigidTransform.from_components(
        [0.3, -0.2, 0.5], Rotation.from_euler("xyz", [1.0, 0.4, 2.0])
    )
    options = FitOptions(kinds=("superquadric",))
    reference, transformed = (
        uncertainty_of(fit_superquadric(p, options=options)) for p in (cloud, T.apply(cloud))
    )
    centre_covariance, transformed_centre_covariance = (
        reference.covariance[8:11, 8:11],
        transformed.covariance[8:11, 8:11],
    )
    R = T.rotation.as_matrix()
    assert np.allclose(
        transformed_centre_covariance,
        R @ centre_covariance @ R.T,
        rtol=1e-3,
        atol=1e-4 * np.abs(centre_covariance).max(),
    )
    assert np.allclose(
        transformed.standard_deviations[:5], reference.standard_deviations[:5], rtol=1e-3
    )


@pytest.mark.parametrize("axes", [[0.05, 0.04, 0.03], [0.04, 0.05, 0.03], [0.03, 0.03, 0.05]])
def test_front_view_of_box_reports_unobserved_side(axes):
    open_sides = 0
    for seed in range(5):
        fit = fit_front_view("box", axes, seed)
        if not fit:
            # One side of a box can also be rejected as a sheet.
            assert "too little was seen" in fit.reason
            continue
        unobserved, solid = uncertainty_of(fit).unobserved, fit.superquadric
        assert solid is not None
        for side in unobserved:
            sign = 1.0 if side[0] == "+" else -1.0
            outwards = sign * solid.rotation[:, "xyz".index(side[1])]
            assert np.allclose(outwards, [0.0, 1.0, 0.0], atol=0.1)
        open_sides += len(unobserved)
    assert open_sides >= 2


def test_front_view_of_ball_has_no_unobserved_side():
    for seed in range(5):
        assert uncertainty_of(fit_front_view("sphere", [0.04, 0.04, 0.04], seed)).unobserved == ()


@pytest.mark.parametrize("kind", SOLIDS)
def test_whole_surface_has_no_unobserved_side(kind):
    assert uncertainty_of(fit_whole_surface(kind, 1)).unobserved == ()


def test_noise_increases_all_deviations():
    rng = np.random.default_rng(4)
    surface = sample_surface(make_solid("superquadric"), 500, rng)
    options = FitOptions(kinds=("superquadric",))
    low_noise, high_noise = (
        uncertainty_of(
            fit_superquadric(surface + sigma * rng.normal(size=(500, 3)), options=options)
        )
        for sigma in (0.001, 0.004)
    )
    free = low_noise.standard_deviations > 0.0
    assert np.all(high_noise.standard_deviations[free] > 1.5 * low_noise.standard_deviations[free])
