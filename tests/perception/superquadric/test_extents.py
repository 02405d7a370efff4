"""Tests of sides and widths: exact solids are covered, bounds hold, and misfit widens them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import PARAMETERS, Kind, sample_surface
from eyehand.perception.superquadric.extents import correlated_misfit

CAMERA = np.array([0.35, -0.5, 0.45])
NOISE = 0.001
SOLIDS: dict[Kind, tuple[list[float], tuple[float, float]]] = {
    "sphere": ([0.04, 0.04, 0.04], (1.0, 1.0)),
    "cylinder": ([0.035, 0.035, 0.05], (0.1, 1.0)),
    "box": ([0.05, 0.03, 0.04], (0.1, 0.1)),
    "superquadric": ([0.05, 0.035, 0.03], (0.5, 0.7)),
}
DIRECTIONS = np.array([[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [-0.3, 0.5, 0.8], [0.0, 0.0, 2.0]])


def solid_on_table(kind: Kind, yaw: float = 0.4) -> Superquadric:
    axes, exponents = SOLIDS[kind]
    pose = RigidTransform.from_components([0.0, 0.0, axes[2]], Rotation.from_euler("z", yaw))
    return Superquadric(np.array(axes), exponents, pose, kind)


def view(solid: Superquadric, seed: int, noise: float = NOISE) -> np.ndarray:
    rng = np.random.default_rng(seed)
    points = sample_surface(solid, 4000, rng)
    points = points[np.einsum("ij,ij->i", CAMERA - points, solid.normals(points)) > 0]
    rays = (points - CAMERA) / np.linalg.norm(points - CAMERA, axis=1, keepdims=True)
    return points + noise * rng.normal(size=(len(points), 1)) * rays


def fit_view(points: np.ndarray) -> SuperquadricFit:
    fit = fit_superquadric(
        points, view_origin=CAMERA, support_plane=[0.0, 0.0, 1.0, 0.0], options=FitOptions()
    )
    assert fit, fit.reason
    return fit


@pytest.mark.parametrize("kind", SOLIDS)
def test_sides_and_widths_of_exact_solids_are_covered_and_narrow(kind):
    solid = solid_on_table(kind)
    side_errors, width_errors, sigmas = [], [], []
    for seed in range(4):
        fit = fit_view(view(solid, seed))
        assert fit.superquadric is not None
        for side in fit.sides:
            reach = float(solid.support(side.direction) - fit.superquadric.centre @ side.direction)
            side_errors.append((side.position - reach) / side.sigma)
            sigmas.append(side.sigma)
            assert side.low - NOISE <= reach <= side.high + NOISE
        for direction in DIRECTIONS:
            width = fit.width(direction)
            assert width is not None
            unit = direction / np.linalg.norm(direction)
            true_width = float(solid.support(unit) + solid.support(-unit))
            width_errors.append((width.mean - true_width) / width.sigma)
            assert width.low - NOISE <= true_width <= width.high + NOISE
    # Half of the sides of an exact solid are known to a fraction of the noise.
    assert np.median(sigmas) < NOISE
    for errors in (side_errors, width_errors):
        assert np.mean(np.abs(errors) < 2.0) > 0.8


def test_width_along_an_axis_agrees_with_the_two_sides():
    fit = fit_view(view(solid_on_table("box"), 1))
    for k in range(3):
        up, down = fit.sides[2 * k], fit.sides[2 * k + 1]
        width = fit.width(up.direction)
        assert width is not None
        assert width.mean == pytest.approx(up.position + down.position, abs=1e-9)
        assert width.low == pytest.approx(up.low + down.low, abs=1e-9)
        assert width.high == pytest.approx(up.high + down.high, abs=1e-9)


def test_unseen_side_has_a_wider_interval_and_a_larger_deviation():
    fit = fit_view(view(solid_on_table("box", yaw=0.0), 2))
    towards = CAMERA - np.array([0.0, 0.0, 0.04])
    seen = max(fit.sides, key=lambda side: side.direction @ towards)
    hidden = min(fit.sides, key=lambda side: side.direction @ towards)
    assert hidden.high - hidden.low > seen.high - seen.low + 0.01
    assert hidden.sigma > seen.sigma


def test_misfit_raises_the_deviations():
    solid = solid_on_table("sphere")
    points = view(solid, 3)
    dents = 0.002 * np.sin(90.0 * points[:, :1]) * np.sin(90.0 * points[:, 2:])
    smooth, dented = fit_view(points), fit_view(points + dents * solid.normals(points))
    assert np.median([side.sigma for side in dented.sides]) > 1.5 * np.median(
        [side.sigma for side in smooth.sides]
    )


def test_covariance_agrees_with_the_deviations_of_sides_and_widths():
    fit = fit_view(view(solid_on_table("box"), 4))
    solid, covariance = fit.superquadric, fit.covariance
    assert solid is not None
    assert covariance is not None
    assert covariance.shape == (len(PARAMETERS), len(PARAMETERS))
    eigenvalues = np.linalg.eigvalsh(covariance)
    assert eigenvalues.min() > -1e-9 * eigenvalues.max()
    for k in range(3):
        width = fit.width(solid.rotation[:, k])
        assert width is not None
        # The bounds of the view may lower the deviation, nothing raises it.
        assert width.sigma <= 2.0 * np.sqrt(covariance[k, k]) * (1.0 + 1e-9)


def test_cloud_of_all_sides_needs_no_camera():
    solid = solid_on_table("superquadric")
    rng = np.random.default_rng(5)
    points = sample_surface(solid, 800, rng) + NOISE * rng.normal(size=(800, 3))
    fit = fit_superquadric(points)
    assert fit
    for side in fit.sides:
        assert side.high == np.inf
        assert side.sigma < 2.0 * NOISE


def test_result_without_solid_has_no_extents():
    fit = SuperquadricFit.rejected("nothing")
    assert fit.sides == ()
    assert fit.width([1.0, 0.0, 0.0]) is None
    assert fit.covariance is None


@pytest.mark.parametrize("direction", [[0.0, 0.0, 0.0], [1.0, 0.0], [np.nan, 0.0, 1.0]])
def test_invalid_direction_is_refused(direction):
    with pytest.raises(InputError, match="direction"):
        SuperquadricFit.rejected("nothing").width(direction)


@pytest.mark.parametrize("noise", [0.0005, 0.001, 0.003])
def test_noise_is_no_misfit(noise):
    rng = np.random.default_rng(6)
    solid = solid_on_table("sphere")
    points = sample_surface(solid, 800, rng) + noise * rng.normal(size=(800, 3))
    misfit, found = correlated_misfit(points, solid.normals(points), solid.distance(points))
    assert misfit < 0.25 * noise
    assert found == pytest.approx(noise, rel=0.15)


def test_waves_are_misfit():
    rng = np.random.default_rng(7)
    solid = solid_on_table("sphere")
    points = sample_surface(solid, 800, rng)
    normals = solid.normals(points)
    waves = 0.002 * np.sqrt(2.0) * np.sin(60.0 * points[:, 0])
    points = points + (waves + 0.001 * rng.normal(size=800))[:, None] * normals
    misfit, noise = correlated_misfit(points, solid.normals(points), solid.distance(points))
    assert misfit == pytest.approx(0.002, rel=0.3)
    assert noise == pytest.approx(0.001, rel=0.3)


@pytest.mark.parametrize(("elevation_deg", "uncertain"), [(8.0, True), (50.0, False)])
def test_width_is_uncertain_where_the_depth_is_hardly_seen(elevation_deg, uncertain):
    angle = np.radians(elevation_deg)
    eye = 0.65 * np.array([0.0, -np.cos(angle), np.sin(angle)])
    pose = RigidTransform.from_translation([0.0, 0.0, 0.06])
    box = Superquadric(np.array([0.06, 0.03, 0.06]), (0.05, 0.05), pose, "box")
    rng = np.random.default_rng(1)
    points = sample_surface(box, 8000, rng)
    points = points[np.einsum("ij,ij->i", box.normals(points), eye - points) > 0][:1500]
    points += rng.normal(0.0, 0.001, points.shape)
    fit = fit_superquadric(points, view_origin=eye, support_plane=[0.0, 0.0, 1.0, 0.0])
    assert fit.width_uncertain == uncertain
    assert not replace(fit, evidence=None).width_uncertain
