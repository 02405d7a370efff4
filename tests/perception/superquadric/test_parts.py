"""Objects that no one solid is become few solids; what one solid is stays one."""

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
from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import sample_surface
from eyehand.perception.superquadric.part_proposals import largest_cluster, propose_splits

THREE = FitOptions(max_parts=3)
NOISE = 0.001


@cache
def compound(name: str, seed: int) -> CompoundSolid:
    rng = np.random.default_rng(seed)
    turn = Rotation.from_quat(rng.normal(size=4))
    pose = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), turn)
    return posed_compound(COMPOUNDS[name](rng), pose)


def whole_surface(solid: CompoundSolid, seed: int, count: int = 800) -> np.ndarray:
    rng = np.random.default_rng(seed)
    points = solid.surface_points(None, count, rng)
    return points + NOISE * rng.normal(size=points.shape)


def one_and_three(case: FitCase) -> tuple[SuperquadricFit, SuperquadricFit]:
    """Fits of at most one solid and of at most three."""
    one, three = (
        fit_superquadric(
            case.points,
            view_origin=case.view_origin,
            support_plane=case.support_plane,
            options=options,
        )
        for options in (FitOptions(), THREE)
    )
    return one, three


@cache
def l_fit() -> tuple[CompoundSolid, np.ndarray, SuperquadricFit]:
    solid = compound("L", 2)
    points = whole_surface(solid, 2)
    return solid, points, fit_superquadric(points, options=THREE)


@pytest.mark.parametrize(
    ("name", "parts"),
    [("L", 2), ("T", 2), ("hammer", 2), ("mug", 2), ("dumbbell", 3), ("drill", 3)],
)
def test_whole_surfaces_become_their_parts(name, parts):
    solid = compound(name, 2)
    points = whole_surface(solid, 2)
    fit = fit_superquadric(points, options=THREE)
    assert fit
    assert len(fit.parts) == parts
    assert overlap(solid, fit.parts) > 0.95
    one = fit_superquadric(points)
    before = 0.0 if one.superquadric is None else overlap(solid, [one.superquadric])
    assert overlap(solid, fit.parts) > before + 0.01


@pytest.mark.parametrize(("seed", "least"), [(401, 0.85), (404, 0.9), (405, 0.95), (410, 0.9)])
def test_single_views_become_parts(seed, least):
    case = fit_case("compound", seed)
    one, fit = one_and_three(case)
    before = 0.0 if one.superquadric is None else overlap(case.truth, [one.superquadric])
    assert fit
    assert overlap(case.truth, fit.parts) > max(least, before)


@pytest.mark.parametrize("group", ["view-1mm", "view-2mm", "view-outliers", "full", "table"])
@pytest.mark.parametrize("seed", range(500, 503))
def test_one_solid_stays_one(group, seed):
    case = fit_case(group, seed, 600)
    one, fit = one_and_three(case)
    assert fit.superquadric is not None
    assert one.superquadric is not None
    assert len(fit.parts) == 1
    assert np.array_equal(fit.superquadric.semi_axes, one.superquadric.semi_axes)


def test_the_largest_part_stands_for_the_object():
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


def test_parts_follow_their_cloud():
    _, points, fit = l_fit()
    turn = RigidTransform.from_components([1.0, -2.0, 3.0], Rotation.from_rotvec([0.3, -1.0, 0.5]))
    order = np.random.default_rng(0).permutation(len(points))
    moved = fit_superquadric(turn.apply(points[order]), options=THREE)
    assert len(moved.parts) == len(fit.parts)
    for before, after in zip(fit.parts, moved.parts, strict=True):
        assert after.kind == before.kind
        assert after.semi_axes == pytest.approx(before.semi_axes, abs=1e-5)
        assert after.centre == pytest.approx(turn.apply(before.centre), abs=1e-5)


def test_the_same_cloud_gives_the_same_parts():
    _, points, fit = l_fit()
    again = fit_superquadric(points, options=THREE)
    assert np.array_equal(again.residuals, fit.residuals)
    assert all(
        np.array_equal(one.semi_axes, two.semi_axes)
        for one, two in zip(fit.parts, again.parts, strict=True)
    )


def test_few_parts_are_kept_to_where_more_would_fit():
    solid = compound("drill", 2)
    points = whole_surface(solid, 2)
    for most in (1, 2, 3):
        fit = fit_superquadric(points, options=FitOptions(max_parts=most))
        assert len(fit.parts) <= most
    assert len(fit_superquadric(points, options=FitOptions(max_parts=6)).parts) <= 4


def test_what_few_parts_do_not_explain_is_said():
    rng = np.random.default_rng(0)
    crumpled = rng.uniform(-0.05, 0.05, (600, 3))
    fit = fit_superquadric(crumpled, options=THREE)
    assert not fit
    assert "no better in 2" in fit.reason


def test_a_sheet_stays_no_solid():
    rng = np.random.default_rng(0)
    sheet = rng.uniform(-0.05, 0.05, (600, 3)) * [1.0, 1.0, 0.0]
    sheet += 0.0005 * rng.normal(size=sheet.shape)
    fit = fit_superquadric(sheet, options=THREE)
    assert fit.superquadric is None
    assert fit.parts == ()
    assert "one plane" in fit.reason


def test_hidden_rays_are_asked_for_every_part():
    case = fit_case("compound", 404)
    asked = []

    def hidden(rays: np.ndarray) -> np.ndarray:
        assert np.linalg.norm(rays, axis=1) == pytest.approx(1.0)
        asked.append(len(rays))
        return np.ones(len(rays), dtype=bool)

    fit = fit_superquadric(case.points, view_origin=case.view_origin, hidden=hidden, options=THREE)
    assert len(asked) > 1
    assert fit.superquadric is not None


@pytest.mark.parametrize("wrong", [0, -1, 9])
def test_a_wrong_number_of_parts_is_refused(wrong):
    with pytest.raises(InputError, match="max_parts must be 1 to 8"):
        FitOptions(max_parts=wrong)


def test_points_of_a_compound_lie_on_its_outer_surface():
    solid = compound("L", 2)
    points = solid.surface_points(None, 500, np.random.default_rng(1))
    gaps = np.array([part.distance(points) for part in solid.parts])
    assert np.abs(np.abs(gaps).min(axis=0)).max() < 1e-9
    assert gaps.min() > -1e-9


def test_seen_points_of_a_compound_are_not_behind_another_part():
    rng = np.random.default_rng(0)
    pose = RigidTransform.identity()
    solid = posed_compound(draw_l_shape(rng), pose)
    origin = solid.centre + np.array([0.0, 0.7, 0.0])
    points = solid.surface_points(origin, 400, rng)
    for share in np.linspace(0.01, 0.3, 20):
        assert not solid.contains(points + share * (origin - points)).any()


def test_cuts_leave_points_on_both_sides_and_differ():
    rng = np.random.default_rng(0)
    solid = Superquadric(np.array([0.05, 0.03, 0.02]), (0.5, 0.5), RigidTransform.identity())
    points = sample_surface(solid, 300, rng)
    neighbours = np.argsort(np.linalg.norm(points[:, None] - points, axis=2), axis=1)[:, 1:9]
    residuals = np.where(points[:, 0] > 0.03, 0.01, 0.0)
    found = propose_splits(points, neighbours, residuals, np.eye(3), NOISE, 25)
    assert any(np.array_equal(mask, points[:, 0] > 0.03) for mask in found)
    for mask in found:
        assert 25 <= np.count_nonzero(mask) <= 275
    for k, one in enumerate(found):
        for other in found[:k]:
            apart = np.count_nonzero(one ^ other)
            assert min(apart, 300 - apart) > 12


def test_the_largest_cluster_hangs_together():
    line = np.arange(20)
    neighbours = np.column_stack([line - 1, np.where(line < 19, line + 1, -1)])
    chosen = np.isin(line, [1, 2, 3, 7, 8, 9, 10, 15])
    cluster = largest_cluster(chosen, neighbours)
    assert np.array_equal(np.flatnonzero(cluster), [7, 8, 9, 10])
    assert not largest_cluster(np.zeros(20, dtype=bool), neighbours).any()


def test_more_parts_than_one_need_no_more_of_the_options():
    _, points, _ = l_fit()
    fast = replace(THREE, optimiser="lm", points=300, kinds=("box", "cylinder"))
    fit = fit_superquadric(points, options=fast)
    assert [part.kind for part in fit.parts] == ["box", "box"]
