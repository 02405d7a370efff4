"""What a fit says it does not know: as large as fits scatter, and on the side nobody saw."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import (
    PARAMETERS,
    Kind,
    Uncertainty,
    canonical,
    sample_surface,
)
from eyehand.perception.superquadric.kinds import basis

REPEATS = 40
NOISE = 0.002
WITHIN = 3.0
"""Ratio of told to shown standard deviation that counts as right: it is told from few readings."""
TURN = Rotation.from_euler("xyz", [0.3, 0.2, 0.5])
SOLIDS: dict[Kind, tuple[list[float], tuple[float, float], tuple[float, float]]] = {
    "sphere": ([0.04, 0.04, 0.04], (1.0, 1.0), (0.0, 0.0)),
    "cylinder": ([0.04, 0.04, 0.05], (0.1, 1.0), (0.0, 0.0)),
    "ellipsoid": ([0.06, 0.045, 0.03], (1.0, 1.0), (0.0, 0.0)),
    # Longest along z: the canonical form gives these axes other names.
    "box": ([0.03, 0.04, 0.06], (0.1, 0.1), (0.0, 0.0)),
    "superquadric": ([0.035, 0.05, 0.03], (0.5, 0.7), (0.0, 0.0)),
    "tapered": ([0.035, 0.045, 0.05], (0.5, 0.8), (0.15, 0.3)),
}


def solid_of_kind(kind: Kind) -> Superquadric:
    axes, exponents, taper = SOLIDS[kind]
    pose = RigidTransform.from_rotation(TURN)
    return Superquadric(np.array(axes), exponents, pose, kind, taper)


def fitted(kind: Kind, seed: int) -> SuperquadricFit:
    """Fit of a noisy whole surface as the kind that it is."""
    rng = np.random.default_rng(seed)
    points = sample_surface(solid_of_kind(kind), 500, rng) + NOISE * rng.normal(size=(500, 3))
    return fit_superquadric(points, options=FitOptions(kinds=(kind,)))


def numbers(solid: Superquadric, about: Rotation) -> np.ndarray:
    """PARAMETERS of a solid, with the rotation taken from a near one."""
    turn = (about.inv() * solid.pose.rotation).as_rotvec()
    return np.concatenate([solid.semi_axes, solid.exponents, turn, solid.centre, solid.taper])


def told(fit: SuperquadricFit) -> Uncertainty:
    assert fit, fit.reason
    assert fit.uncertainty is not None
    return fit.uncertainty


def facing(kind: Kind, axes: list[float], seed: int) -> SuperquadricFit:
    """A solid on the table, seen straight from the front at 0.7 m: all points on its -y side."""
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
def test_rows_of_held_numbers_are_zero_and_the_covariance_is_one(kind):
    covariance = told(fitted(kind, 0)).covariance
    assert covariance.shape == (len(PARAMETERS), len(PARAMETERS))
    assert np.array_equal(covariance, covariance.T)
    eigenvalues = np.linalg.eigvalsh(covariance)
    assert eigenvalues.min() > -1e-9 * eigenvalues.max()
    # Semi-axes, rotation and centre keep their places up to permutation; so do the others.
    free = np.asarray(basis(kind)).any(axis=1)
    held = np.logical_not(free)
    if kind == "cylinder":
        assert np.allclose(covariance[7], 0.0, atol=1e-12)
        held[5:8] = False
    assert np.all(covariance[held] == 0.0)
    assert np.all(covariance[:, held] == 0.0)
    assert np.all(told(fitted(kind, 0)).standard_deviations[free] > 0.0)


@pytest.mark.parametrize("kind", SOLIDS)
def test_told_deviations_are_those_by_which_repeated_fits_scatter(kind):
    about = canonical(solid_of_kind(kind)).pose.rotation
    fits = [fitted(kind, seed) for seed in range(REPEATS)]
    found = [numbers(fit.superquadric, about) for fit in fits if fit.superquadric is not None]
    # Of the middle of the fits: one that names its axes otherwise is no matter of small steps.
    shown = 1.4826 * np.median(np.abs(found - np.median(found, axis=0)), axis=0)
    said = np.median([told(fit).standard_deviations for fit in fits], axis=0)
    # Cylinders have no place about their axis, spheres none at all.
    moving = said > 1e-9
    assert np.all(said[moving] < WITHIN * shown[moving])
    assert np.all(said[moving] > shown[moving] / WITHIN)


def test_axes_keep_their_uncertainty_when_the_canonical_form_renames_them():
    # A box whose ends are seen and whose sides are not: only its lengths across are unsure.
    rng = np.random.default_rng(0)
    points = rng.uniform(-1.0, 1.0, (900, 3)) * [0.03, 0.04, 0.06]
    points[:300, 0], points[300:600, 1] = 0.03, 0.04
    points[600:, 2] = np.sign(points[600:, 2]) * 0.06
    points += 0.001 * rng.normal(size=points.shape)
    for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2]):
        fit = fit_superquadric(points[:, order], options=FitOptions(kinds=("box",)))
        solid, deviations = fit.superquadric, told(fit).standard_deviations
        assert solid is not None
        assert solid.semi_axes == pytest.approx([0.06, 0.04, 0.03], abs=2e-3)
        # Both ends of the longest axis are in the cloud; of the others one side each.
        assert deviations[0] < deviations[1]
        assert deviations[0] < deviations[2]


def test_the_covariance_turns_with_the_cloud():
    rng = np.random.default_rng(0)
    cloud = sample_surface(solid_of_kind("superquadric"), 500, rng)
    cloud = (
        cloud[cloud[:, 2] > -0.01]
        + 0.001 * rng.normal(size=(500, 3))[: np.sum(cloud[:, 2] > -0.01)]
    )
    T = RigidTransform.from_components(
        [0.3, -0.2, 0.5], Rotation.from_euler("xyz", [1.0, 0.4, 2.0])
    )
    options = FitOptions(kinds=("superquadric",))
    here, there = (told(fit_superquadric(p, options=options)) for p in (cloud, T.apply(cloud)))
    place, moved = here.covariance[8:11, 8:11], there.covariance[8:11, 8:11]
    R = T.rotation.as_matrix()
    assert np.allclose(moved, R @ place @ R.T, rtol=1e-3, atol=1e-4 * np.abs(place).max())
    assert np.allclose(there.standard_deviations[:5], here.standard_deviations[:5], rtol=1e-3)


@pytest.mark.parametrize("axes", [[0.05, 0.04, 0.03], [0.04, 0.05, 0.03], [0.03, 0.03, 0.05]])
def test_a_box_seen_face_on_says_that_its_far_side_is_open(axes):
    open_sides = 0
    for seed in range(5):
        fit = facing("box", axes, seed)
        if not fit:
            # Seen from one side, a box may also be refused as a sheet.
            assert "too little was seen" in fit.reason
            continue
        unobserved, solid = told(fit).unobserved, fit.superquadric
        assert solid is not None
        for side in unobserved:
            sign = 1.0 if side[0] == "+" else -1.0
            away = sign * solid.rotation[:, "xyz".index(side[1])]
            assert np.allclose(away, [0.0, 1.0, 0.0], atol=0.1)
        open_sides += len(unobserved)
    assert open_sides >= 2


def test_a_ball_seen_from_one_side_leaves_nothing_open():
    for seed in range(5):
        assert told(facing("sphere", [0.04, 0.04, 0.04], seed)).unobserved == ()


@pytest.mark.parametrize("kind", SOLIDS)
def test_a_whole_surface_leaves_nothing_open(kind):
    assert told(fitted(kind, 1)).unobserved == ()


def test_more_noise_makes_all_numbers_less_sure():
    rng = np.random.default_rng(4)
    surface = sample_surface(solid_of_kind("superquadric"), 500, rng)
    options = FitOptions(kinds=("superquadric",))
    calm, loud = (
        told(fit_superquadric(surface + sigma * rng.normal(size=(500, 3)), options=options))
        for sigma in (0.001, 0.004)
    )
    free = calm.standard_deviations > 0.0
    assert np.all(loud.standard_deviations[free] > 1.5 * calm.standard_deviations[free])
