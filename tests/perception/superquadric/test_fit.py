"""Tests of fitting: accuracy, choice of the simplest kind, and rejected clouds."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import FitOptions, Superquadric, fit_superquadric
from eyehand.perception.superquadric import (
    OptimiserName,
    model_selection,
    multi_start,
    problem,
    sample_surface,
)
from eyehand.perception.superquadric import finish as finish_module
from eyehand.perception.superquadric.kinds import BOX_EXPONENT, fixed_exponents

VIEW = np.array([0.4, -0.3, 0.6])


def make_cloud(kind, axes, e, rng, count=1500, noise=0.001):
    """Return a solid, its noisy points visible from VIEW, and its support plane."""
    rotation = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0, np.pi)])
    solid = Superquadric(
        np.array(axes), e, RigidTransform.from_components([0.1, 0.2, 0.0], rotation), kind
    )
    points = sample_surface(solid, 4 * count, rng)
    visible = np.einsum("ij,ij->i", VIEW - points, solid.normals(points)) > 0
    points = points[visible][:count] + rng.normal(size=(min(count, int(visible.sum())), 3)) * noise
    bottom = -float(solid.support([0.0, 0.0, -1.0]))
    return solid, points, np.array([0.0, 0.0, 1.0, -bottom])


def overlap(a: Superquadric, b: Superquadric, rng) -> float:
    """Return the IoU of two solids, estimated from random points."""
    reach = 1.8 * max(a.semi_axes.max(), b.semi_axes.max())
    points = a.centre + rng.uniform(-reach, reach, (40000, 3))
    inside_a, inside_b = a.contains(points), b.contains(points)
    return float((inside_a & inside_b).sum() / (inside_a | inside_b).sum())


KINDS = [
    ("sphere", [0.04, 0.04, 0.04], (1.0, 1.0)),
    ("cylinder", [0.035, 0.035, 0.06], (0.1, 1.0)),
    ("ellipsoid", [0.07, 0.05, 0.035], (1.0, 1.0)),
    ("box", [0.03, 0.05, 0.08], (0.1, 0.1)),
]


@pytest.mark.parametrize(("kind", "axes", "e"), KINDS)
def test_noisy_view_gives_solid_of_simplest_kind(kind, axes, e):
    rng = np.random.default_rng(5)
    solid, points, plane = make_cloud(kind, axes, e, rng)
    fit = fit_superquadric(points, view_origin=VIEW, support_plane=plane)
    assert fit
    assert fit.superquadric is not None
    assert fit.superquadric.kind == kind
    assert overlap(solid, fit.superquadric, rng) > 0.93
    assert fit.spread < 0.0015
    assert [c.criterion for c in fit.candidates] == sorted(c.criterion for c in fit.candidates)
    # A taper is tried only if straight solids leave residuals above the noise.
    assert {c.kind for c in fit.candidates} == set(FitOptions().kinds) - {"tapered"}


@pytest.mark.parametrize("optimiser", get_args(OptimiserName))
def test_every_optimiser_finds_box(optimiser):
    rng = np.random.default_rng(6)
    solid, points, plane = make_cloud("box", [0.03, 0.05, 0.08], (0.1, 0.1), rng)
    options = FitOptions(optimiser=optimiser)
    fit = fit_superquadric(points, view_origin=VIEW, support_plane=plane, options=options)
    assert fit.superquadric is not None
    assert overlap(solid, fit.superquadric, rng) > 0.93


def test_refinement_lowers_criterion(monkeypatch):
    rng = np.random.default_rng(8)
    _, points, plane = make_cloud("superquadric", [0.06, 0.03, 0.05], (0.5, 0.7), rng)
    monkeypatch.setattr(multi_start, "START_ITERATIONS", 1)
    monkeypatch.setattr(model_selection, "MAX_ITERATIONS", 1)
    options = FitOptions(kinds=("superquadric",), max_minima=1)

    def fit_with(iterations):
        monkeypatch.setattr(finish_module, "MAX_ITERATIONS", iterations)
        return fit_superquadric(points, view_origin=VIEW, support_plane=plane, options=options)

    rough, fine = fit_with(1), fit_with(100)
    assert fine.candidates[0].criterion < rough.candidates[0].criterion


def test_box_that_grows_with_its_sharp_edges_keeps_the_others(monkeypatch):
    _, points, plane = make_cloud(*KINDS[3], np.random.default_rng(2))
    sharp = fit_superquadric(points, view_origin=VIEW, support_plane=plane).superquadric
    descent = finish_module.levenberg_marquardt

    def growing(problem, start, *rest):
        end, cost, steps = descent(problem, start, *rest)
        grown = start.exponents[0] == BOX_EXPONENT
        return end._replace(log_axes=end.log_axes + 0.5 * grown), cost, steps

    monkeypatch.setattr(finish_module, "levenberg_marquardt", growing)
    kept = fit_superquadric(points, view_origin=VIEW, support_plane=plane).superquadric
    assert sharp is not None
    assert kept is not None
    assert sharp.exponents == (BOX_EXPONENT, BOX_EXPONENT)
    assert kept.exponents == (0.1, 0.1)
    assert kept.semi_axes == pytest.approx(sharp.semi_axes, abs=0.002)


def test_solid_of_a_whole_bowl_ends_at_its_rim():
    rng = np.random.default_rng(5)
    shell = rng.normal(size=(3000, 3))
    shell *= (rng.choice([0.077, 0.08], 3000) / np.linalg.norm(shell, axis=1))[:, None]
    bowl = shell[shell[:, 2] < -0.03]
    tall = fit_superquadric(bowl)
    flat = fit_superquadric(bowl, whole=True)
    assert flat.superquadric is not None
    assert tall.superquadric is not None
    assert flat.superquadric.support([0.0, 0.0, 1.0]) == pytest.approx(-0.03, abs=0.004)
    assert tall.superquadric.support([0.0, 0.0, 1.0]) > 0.0


def test_outliers_do_not_change_solid():
    rng = np.random.default_rng(7)
    solid = Superquadric(np.array([0.03, 0.05, 0.08]), (0.3, 0.8), RigidTransform.identity())
    points = sample_surface(solid, 800, rng) + rng.normal(size=(800, 3)) * 0.0005
    cloud = np.vstack([points, rng.uniform(-0.15, 0.15, (200, 3))])
    fit = fit_superquadric(cloud)
    assert fit.superquadric is not None
    assert overlap(solid, fit.superquadric, rng) > 0.93


def test_equal_calls_give_equal_fits():
    rng = np.random.default_rng(9)
    _, points, plane = make_cloud("cylinder", [0.03, 0.03, 0.05], (0.1, 1.0), rng)
    first, second = (fit_superquadric(points, support_plane=plane).superquadric for _ in range(2))
    assert first is not None
    assert second is not None
    assert np.array_equal(first.semi_axes, second.semi_axes)
    assert np.array_equal(first.pose.as_matrix(), second.pose.as_matrix())


@given(seed=st.integers(0, 1000))
@settings(max_examples=8)
def test_fit_follows_rigid_motion(seed):
    rng = np.random.default_rng(seed)
    _, points, plane = make_cloud("box", [0.03, 0.05, 0.08], (0.1, 0.1), np.random.default_rng(3))
    T = RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
    normal = T.rotation.apply(plane[:3])
    moved_plane = np.append(normal, plane[3] - normal @ T.translation)
    reference = fit_superquadric(points, view_origin=VIEW, support_plane=plane).superquadric
    moved = fit_superquadric(
        T.apply(points), view_origin=T.apply(VIEW), support_plane=moved_plane
    ).superquadric
    assert reference is not None
    assert moved is not None
    assert moved.kind == reference.kind
    assert (
        overlap(
            moved, Superquadric(reference.semi_axes, reference.exponents, T * reference.pose), rng
        )
        > 0.98
    )


@pytest.mark.parametrize(
    ("cloud", "message"),
    [
        (np.zeros((0, 3)), "0 points are too few"),
        (np.random.default_rng(0).normal(size=(49, 3)), "49 points are too few"),
        (np.full((80, 3), np.nan), "NaN"),
        (np.ones((80, 3)), "same point"),
        (np.linspace(0, 1, 80)[:, None] * [1.0, 2.0, 3.0], "line"),
        (np.random.default_rng(0).normal(size=(80, 3)) * [1, 1, 0], "plane"),
    ],
)
def test_insufficient_clouds_are_rejected_with_reason(cloud, message):
    fit = fit_superquadric(cloud)
    assert not fit
    assert message in fit.reason
    assert fit.superquadric is None


def test_flat_cloud_above_support_plane_is_box():
    rng = np.random.default_rng(1)
    top = rng.uniform(-1, 1, (400, 3)) * [0.04, 0.03, 0.0] + [0.0, 0.0, 0.05]
    fit = fit_superquadric(top, view_origin=[0.0, 0.0, 0.6], support_plane=[0.0, 0.0, 1.0, 0.0])
    assert fit.superquadric is not None
    height = fit.superquadric.support([0.0, 0.0, 1.0]) + fit.superquadric.support([0.0, 0.0, -1.0])
    assert height == pytest.approx(0.05, abs=0.01)


def test_duplicated_points_do_not_change_ball():
    rng = np.random.default_rng(2)
    ball = sample_surface(
        Superquadric(np.full(3, 0.04), (1.0, 1.0), RigidTransform.identity()), 300, rng
    )
    fit = fit_superquadric(np.vstack([np.repeat(ball[:1], 700, axis=0), ball]))
    assert fit
    assert fit.superquadric is not None
    assert fit.superquadric.semi_axes == pytest.approx([0.04] * 3, abs=1e-3)


def test_single_distant_point_is_outlier():
    rng = np.random.default_rng(2)
    ball = sample_surface(
        Superquadric(np.full(3, 0.04), (1.0, 1.0), RigidTransform.identity()), 300, rng
    )
    assert fit_superquadric(np.vstack([ball, [[1e4, 0.0, 0.0]]]))


@pytest.mark.parametrize(
    ("cloud", "plane", "message"),
    [
        (np.random.default_rng(0).normal(size=(500, 3)) * 0.05, None, "one solid"),
        (np.random.default_rng(0).normal(size=(500, 3)) * 50.0, None, "metres"),
        (np.random.default_rng(0).normal(size=(500, 3)) * 1e-9, None, "metres"),
        (np.random.default_rng(0).normal(size=(500, 3)) * 1e200, None, "coordinates"),
        (
            np.random.default_rng(0).uniform(-0.05, 0.05, (500, 3)) * [1, 1, 0],
            [0.0, 0.0, 1.0, 1e100],
            "support plane",
        ),
    ],
)
def test_invalid_clouds_are_rejected_with_reason(cloud, plane, message):
    fit = fit_superquadric(cloud, support_plane=plane)
    assert not fit
    assert message in fit.reason


@pytest.mark.parametrize("optimiser", get_args(OptimiserName))
def test_optimisers_do_not_raise_on_random_clouds(optimiser):
    rng = np.random.default_rng(4)
    for _ in range(25):
        solid = Superquadric(
            rng.uniform(0.015, 0.08, 3),
            (rng.uniform(0.1, 1.9), rng.uniform(0.1, 1.9)),
            RigidTransform.from_rotation(Rotation.random(rng=rng)),
        )
        points = sample_surface(solid, 300, rng)
        points = points[points @ [0.0, 0.0, 1.0] > -0.01]
        fit = fit_superquadric(points, options=FitOptions(optimiser=optimiser))
        assert fit or fit.reason


@pytest.mark.parametrize("exponent_range", [(0.5, 1.9), (0.02, 1.98)])
def test_exponent_range_limits_kinds_with_free_exponents(exponent_range, monkeypatch):
    for module in (problem, model_selection):
        monkeypatch.setattr(module, "EXPONENT_RANGE", exponent_range)
    rng = np.random.default_rng(6)
    _, points, plane = make_cloud("box", [0.03, 0.05, 0.08], (0.1, 0.1), rng)
    fit = fit_superquadric(points, support_plane=plane)
    assert fit.superquadric is not None
    assert fit.superquadric.kind == "box"
    assert fit.superquadric.exponents == (BOX_EXPONENT, BOX_EXPONENT)
    for candidate in fit.candidates[1:]:
        fixed = fixed_exponents(candidate.kind)
        if fixed is not None:
            assert candidate.superquadric.exponents == fixed
        low, high = (0.1, 1.0) if fixed else exponent_range
        assert all(low <= e <= high for e in candidate.superquadric.exponents)


@pytest.mark.parametrize(
    "arguments",
    [
        {"points": np.zeros((80, 2))},
        {"points": np.zeros((80, 3)), "view_origin": [0.0, 0.0]},
        {"points": np.zeros((80, 3)), "support_plane": [0.0, 0.0, 1.0]},
        {"points": np.zeros((80, 3)), "view_origin": [np.nan, 0.0, 0.0]},
        {"points": np.zeros((80, 3)), "support_plane": [0.0, 0.0, 10.0, 0.5]},
        {"points": [[1.0, 2.0], [3.0]]},
        {"points": "cloud"},
    ],
)
def test_arguments_of_wrong_shape_raise(arguments):
    with pytest.raises(InputError):
        fit_superquadric(arguments.pop("points"), **arguments)


@pytest.mark.parametrize(
    ("invalid", "message"),
    [
        ({"kinds": ("cone",)}, "sphere, cylinder"),
        ({"optimiser": "adam"}, "lm, slsqp"),
        ({"points": 2}, "points"),
        ({"seed": -1}, "seed"),
        ({"plane_weight": float("nan")}, "plane_weight"),
        ({"noise": 0.0}, "noise"),
        ({"axis_range": (0.1, 0.05)}, "axis_range"),
    ],
)
def test_option_errors_list_valid_choices(invalid, message):
    with pytest.raises(InputError, match=message):
        FitOptions(**invalid)


def box_view(half, yaw, camera, rng):
    """Return 600 noisy points on those sides of an exact box on a table that the camera sees."""
    signed = np.concatenate([np.eye(3), -np.eye(3)])
    turn = Rotation.from_euler("z", yaw)
    towards = (turn.apply(camera - [0, 0, half[2]], inverse=True) - signed * half) * signed
    seen = np.clip(towards.sum(axis=1), 0.0, None) / np.abs(signed @ half)
    points = half * rng.uniform(-1, 1, (600, 3))
    sides = rng.choice(6, 600, p=seen / seen.sum())
    points = np.where(signed[sides] == 0, points, signed[sides] * half)
    return turn.apply(points) + [0, 0, half[2]] + 0.001 * rng.normal(size=(600, 3))


def test_sizes_of_exact_boxes_have_no_bias():
    rng = np.random.default_rng(300)
    camera, errors = np.array([0.7, 0.0, 0.5]), []
    for _ in range(12):
        half, yaw = rng.uniform(0.02, 0.06, 3), rng.uniform(0.1, 1.4)
        points = box_view(half, yaw, camera, rng)
        fit = fit_superquadric(points, view_origin=camera, support_plane=[0, 0, 1, 0])
        assert fit, fit.reason
        assert fit.superquadric is not None
        errors.append(2 * (np.sort(fit.superquadric.semi_axes) - np.sort(half)))
    assert abs(np.mean(errors)) < 0.0003
    assert np.abs(errors).mean() < 0.0007
