"""Tests of fitting several parts to one object."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.bench.clouds import FitCase, fit_case
from eyehand.apps.fitting.bench.compound_solids import (
    COMPOUNDS,
    CompoundSolid,
    draw_l_shape,
    posed_compound,
)
from eyehand.apps.fitting.bench.score import overlap
from eyehand.errors import InputError
from eyehand.perception import FitOptions, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import parts
from eyehand.perception.superquadric.outliers import FilteredCloud
from eyehand.perception.superquadric.part_assignment import (
    PartAssignment,
    assignment_of,
    principal_box,
    rough_part,
)
from eyehand.perception.superquadric.part_cloud import prepare_part_cloud
from eyehand.perception.superquadric.problem import Observation

THREE_PARTS = FitOptions(max_parts=3)
NOISE = 0.001


@cache
def make_compound(name: str, seed: int) -> CompoundSolid:
    rng = np.random.default_rng(seed)
    rotation = Rotation.from_quat(rng.normal(size=4))
    pose = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), rotation)
    return posed_compound(COMPOUNDS[name](rng), pose)


def whole_surface(solid: CompoundSolid, seed: int, count: int = 800) -> np.ndarray:
    rng = np.random.default_rng(seed)
    points = solid.surface_points(None, count, rng)
    return points + NOISE * rng.normal(size=points.shape)


def fit_one_and_three(case: FitCase) -> tuple[SuperquadricFit, SuperquadricFit]:
    """Return the fits with at most one part and with at most three parts."""
    one, three = (
        fit_superquadric(
            case.points,
            view_origin=case.view_origin,
            support_plane=case.support_plane,
            options=options,
        )
        for options in (FitOptions(max_parts=1), THREE_PARTS)
    )
    return one, three


@cache
def l_fit() -> tuple[CompoundSolid, np.ndarray, SuperquadricFit]:
    solid = make_compound("L", 2)
    points = whole_surface(solid, 2)
    return solid, points, fit_superquadric(points, options=THREE_PARTS)


@pytest.mark.parametrize(
    ("name", "parts"),
    [("L", 2), ("T", 2), ("hammer", 2), ("mug", 2), ("dumbbell", 3), ("drill", 3)],
)
def test_whole_surfaces_are_split_into_parts(name, parts):
    solid = make_compound(name, 2)
    points = whole_surface(solid, 2)
    fit = fit_superquadric(points, options=THREE_PARTS)
    assert fit
    assert len(fit.parts) == parts
    assert overlap(solid, fit.parts) > 0.95
    one = fit_superquadric(points, options=FitOptions(max_parts=1))
    overlap_of_one = 0.0 if one.superquadric is None else overlap(solid, [one.superquadric])
    assert overlap(solid, fit.parts) > overlap_of_one + 0.01


@pytest.mark.parametrize(
    ("seed", "min_overlap"), [(401, 0.85), (404, 0.9), (405, 0.95), (410, 0.9)]
)
def test_single_views_are_split_into_parts(seed, min_overlap):
    case = fit_case("compound", seed)
    one, fit = fit_one_and_three(case)
    overlap_of_one = 0.0 if one.superquadric is None else overlap(case.truth, [one.superquadric])
    assert fit
    assert overlap(case.truth, fit.parts) > max(min_overlap, overlap_of_one)


@pytest.mark.parametrize("group", ["view-1mm", "view-2mm", "view-outliers", "full", "table"])
@pytest.mark.parametrize("seed", range(500, 503))
def test_single_solid_is_not_split(group, seed):
    case = fit_case(group, seed, 600)
    one, fit = fit_one_and_three(case)
    assert fit.superquadric is not None
    assert one.superquadric is not None
    assert len(fit.parts) == 1
    assert np.array_equal(fit.superquadric.semi_axes, one.superquadric.semi_axes)


def test_largest_part_represents_object():
    _, points, fit = l_fit()
    volumes = [part.volume for part in fit.parts]
    assert volumes == sorted(volumes, reverse=True)
    assert fit.superquadric is fit.parts[0]
    assert np.allclose(fit.candidates[0].superquadric.centre, fit.parts[0].centre)
    assert {part.kind for part in fit.parts} == {"box"}
    gaps = np.min([part.distance(points) for part in fit.parts], axis=0)
    assert sorted(fit.residuals) == pytest.approx(sorted(gaps), abs=1e-12)
    assert fit.spread < 1.5 * NOISE
    assert fit.uncertainty is not None
    assert fit.seconds > 0.0


def test_parts_follow_rigid_motion():
    _, points, fit = l_fit()
    transform = RigidTransform.from_components(
        [1.0, -2.0, 3.0], Rotation.from_rotvec([0.3, -1.0, 0.5])
    )
    order = np.random.default_rng(0).permutation(len(points))
    moved = fit_superquadric(transform.apply(points[order]), options=THREE_PARTS)
    assert len(moved.parts) == len(fit.parts)
    for part, moved_part in zip(fit.parts, moved.parts, strict=True):
        assert moved_part.kind == part.kind
        assert moved_part.semi_axes == pytest.approx(part.semi_axes, abs=1e-5)
        assert moved_part.centre == pytest.approx(transform.apply(part.centre), abs=1e-5)


def test_repeated_fit_gives_same_parts():
    _, points, fit = l_fit()
    second = fit_superquadric(points, options=THREE_PARTS)
    assert np.array_equal(second.residuals, fit.residuals)
    assert all(
        np.array_equal(one.semi_axes, two.semi_axes)
        for one, two in zip(fit.parts, second.parts, strict=True)
    )


def test_max_parts_limits_parts():
    solid = make_compound("drill", 2)
    points = whole_surface(solid, 2)
    for max_parts in (1, 2, 3):
        fit = fit_superquadric(points, options=FitOptions(max_parts=max_parts))
        assert len(fit.parts) <= max_parts
    assert len(fit_superquadric(points, options=FitOptions(max_parts=6)).parts) <= 4


def test_unexplained_cloud_is_rejected_with_reason():
    rng = np.random.default_rng(0)
    random_points = rng.uniform(-0.05, 0.05, (600, 3))
    fit = fit_superquadric(random_points, options=THREE_PARTS)
    assert not fit
    assert "no better in 2" in fit.reason


def test_sheet_is_rejected():
    rng = np.random.default_rng(0)
    sheet = rng.uniform(-0.05, 0.05, (600, 3)) * [1.0, 1.0, 0.0]
    sheet += 0.0005 * rng.normal(size=sheet.shape)
    fit = fit_superquadric(sheet, options=THREE_PARTS)
    assert fit.superquadric is None
    assert fit.parts == ()
    assert "one plane" in fit.reason


@pytest.mark.parametrize("invalid", [0, -1, 9])
def test_invalid_max_parts_is_rejected(invalid):
    with pytest.raises(InputError, match="max_parts must be 1 to 8"):
        FitOptions(max_parts=invalid)


def test_compound_points_lie_on_outer_surface():
    solid = make_compound("L", 2)
    points = solid.surface_points(None, 500, np.random.default_rng(1))
    gaps = np.array([part.distance(points) for part in solid.parts])
    assert np.abs(np.abs(gaps).min(axis=0)).max() < 1e-9
    assert gaps.min() > -1e-9


def test_visible_compound_points_are_not_occluded():
    rng = np.random.default_rng(0)
    pose = RigidTransform.identity()
    solid = posed_compound(draw_l_shape(rng), pose)
    origin = solid.centre + np.array([0.0, 0.7, 0.0])
    points = solid.surface_points(origin, 400, rng)
    for share in np.linspace(0.01, 0.3, 20):
        assert not solid.contains(points + share * (origin - points)).any()


def test_parts_respect_fit_options():
    _, points, _ = l_fit()
    fast = replace(THREE_PARTS, optimiser="lm", points=300, kinds=("box", "cylinder"))
    fit = fit_superquadric(points, options=fast)
    assert len(fit.parts) == 2
    assert {part.kind for part in fit.parts} <= {"box", "cylinder"}


@pytest.mark.parametrize(("needed", "expected"), [(False, 1), (True, 3)])
def test_a_cut_that_lowers_no_error_is_the_last_unless_parts_are_needed(
    needed, expected, monkeypatch
):
    """Correlated noise of a camera leaves errors that more parts do not lower."""
    cuts = []

    def useless_cut(assignment: PartAssignment, *_: object) -> PartAssignment:
        cuts.append(assignment)
        labels = assignment.labels.copy()
        labels[len(cuts) :: 5] = len(assignment.parts)
        parts = (*assignment.parts, assignment.parts[0])
        return assignment._replace(parts=parts, labels=labels)

    monkeypatch.setattr(parts, "cut_part", useless_cut)
    points = whole_surface(make_compound("L", 3), 3)
    observation = Observation(FilteredCloud(points, 0.0, on_grid=False))
    cloud = prepare_part_cloud(observation, FitOptions())
    shape = principal_box(cloud.points)
    single = assignment_of([rough_part(shape, cloud)], np.zeros(len(cloud.points), int), cloud)
    found = parts._assign_parts(single, cloud, FitOptions(max_parts=4), needed=needed)
    assert len(found) == len(cuts) == expected
