"""Tests of the empty space along the rays of a view."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import FreeSpace, Superquadric, fit_superquadric
from eyehand.perception.superquadric import covered_share, outline_shares, sample_surface
from eyehand.perception.superquadric.validity import check_covered_share

SIDE = 35


def view(depth: float | np.ndarray, on_object: np.ndarray | None = None) -> FreeSpace:
    """Return a grid of rays along z within 0.2 of the optical axis."""
    steps = np.linspace(-0.2, 0.2, SIDE)
    across = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    rays = np.column_stack([across, np.ones(len(across))])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    depths = np.broadcast_to(depth, len(rays)).astype(np.float64)
    on_object = np.zeros(len(rays), bool) if on_object is None else on_object
    return FreeSpace(np.zeros(3), rays, depths, on_object, 0.4 / (SIDE - 1))


def random_solid(seed: int) -> Superquadric:
    rng = np.random.default_rng(seed)
    place = np.array([0.0, 0.0, 0.7]) + rng.uniform(-0.1, 0.1, 3)
    pose = RigidTransform.from_components(place, Rotation.random(rng=rng))
    taper = tuple(rng.uniform(-0.4, 0.4, 2)) if seed % 3 == 0 else (0.0, 0.0)
    return Superquadric(
        rng.uniform(0.01, 0.1, 3),
        tuple(rng.uniform(0.1, 1.9, 2)),
        pose,
        "tapered" if any(taper) else "superquadric",
        taper,
    )


@pytest.mark.parametrize("seed", range(12))
def test_share_equals_samples_along_the_rays(seed):
    solid, rng = random_solid(seed), np.random.default_rng(seed)
    depth = rng.uniform(0.5, 0.9, SIDE**2)
    depth[::5] = 0.0
    free_space = view(depth)
    along = np.linspace(0.3, 1.1, 1601)
    inside = np.array([solid.contains(ray * along[:, None]) for ray in free_space.rays], dtype=bool)
    early = inside & (along < depth[:, None] - 0.004) & (depth[:, None] > 0)
    expected = early.any(axis=1).sum() / inside.any(axis=1).sum()
    assert covered_share([solid], free_space, 0.004) == pytest.approx(expected, abs=0.01)


def test_union_is_counted_once():
    solid = random_solid(1)
    free_space = view(0.7)
    assert covered_share([solid, solid], free_space, 0.0) == covered_share([solid], free_space, 0.0)
    assert covered_share([], free_space, 0.0) == 0.0


def test_solid_behind_the_surface_covers_nothing():
    solid = Superquadric(np.full(3, 0.05), (1.0, 1.0), RigidTransform.from_translation([0, 0, 0.7]))
    assert covered_share([solid], view(0.64), 0.0) == 0.0
    assert covered_share([solid], view(0.0), 0.0) == 0.0
    assert covered_share([solid], view(np.inf), 0.0) == 1.0


def test_missed_pixels_are_those_of_the_object_beside_the_solid():
    solid = Superquadric(np.full(3, 0.05), (1.0, 1.0), RigidTransform.from_translation([0, 0, 0.7]))
    rays = view(0.7).rays
    miss = np.linalg.norm(np.cross(rays, solid.centre), axis=1)
    for radius in (0.04, 0.08):
        on_object = miss < radius
        shares = outline_shares([solid], view(0.6, on_object), 0.0)
        assert shares.missed == pytest.approx(np.mean(miss[on_object] >= 0.05), abs=1e-9)
        assert shares.covered == 0.0
    assert outline_shares([solid], view(0.6), 0.0).missed == 0.0
    assert outline_shares([], view(0.6, on_object), 0.0).missed == 1.0


def test_pixels_in_a_hole_are_not_beside_the_object():
    solid = Superquadric(np.full(3, 0.05), (1.0, 1.0), RigidTransform.from_translation([0, 0, 0.7]))
    rays = view(0.7).rays
    miss = np.linalg.norm(np.cross(rays, solid.centre), axis=1)
    ring = (miss > 0.02) & (miss < 0.04)
    shares = outline_shares([solid], view(np.where(ring, 0.65, 0.9), ring), 0.0)
    met = miss < 0.05
    assert shares.covered == pytest.approx(np.mean(~ring[met]), abs=1e-9)
    assert shares.beside == pytest.approx(np.mean(miss[met] >= 0.04), abs=1e-9)


def test_frame_does_not_change_the_share():
    solid, free_space = random_solid(4), view(0.7)
    by = np.array([1.0, -2.0, 0.5])
    moved = Superquadric(
        solid.semi_axes, solid.exponents, RigidTransform.from_translation(by) * solid.pose
    )
    share = covered_share([solid], free_space, 0.002)
    assert covered_share([moved], free_space.shifted(by), 0.002) == pytest.approx(share, abs=1e-9)


def test_outline_is_hidden_by_nearer_surfaces_and_beside_the_grid():
    left = view(0.0).rays[:, 0] < -0.01
    near = view(0.0).rays[:, 1] > 0.1
    depth = np.where(left, 0.7, np.where(near, 0.5, 0.9))
    free_space = view(depth, left)
    directions = np.array([[0.05, 0, 1], [0.05, 0.15, 1], [-0.1, 0, 1], [0.5, 0, 1]])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    assert free_space.hides(directions).tolist() == [False, True, True, True]


def test_solid_in_empty_space_is_rejected():
    rng = np.random.default_rng(0)
    ball = Superquadric(np.full(3, 0.05), (1.0, 1.0), RigidTransform.from_translation([0, 0, 0.7]))
    points = sample_surface(ball, 2000, rng)
    points = points[(ball.normals(points) * points).sum(axis=1) < 0]
    assert fit_superquadric(points, free_space=view(0.6))
    fit = fit_superquadric(points, free_space=view(0.9))
    assert not fit
    assert fit.superquadric is not None
    assert fit.covered_share > 0.9
    assert "the view shows empty space" in fit.reason


def test_wrong_shapes_are_rejected():
    good = view(0.7)
    with pytest.raises(InputError, match=r"depth of a free space must have shape \(1225,\)"):
        FreeSpace(good.origin, good.rays, good.depth[:-1], good.on_object, good.pitch)


def test_constrained_fit_states_a_doubt():
    ball = Superquadric(np.full(3, 0.05), (1.0, 1.0), RigidTransform.from_translation([0, 0, 0.7]))
    points = sample_surface(ball, 2000, np.random.default_rng(0))
    points = points[(ball.normals(points) * points).sum(axis=1) < 0]
    fit = fit_superquadric(points, free_space=view(0.6))
    assert not fit.constrained
    assert not fit.outline_differs
    assert replace(fit, constrained=True).outline_differs
    assert replace(fit, missed_share=0.2).outline_differs
    assert replace(fit, covered_share=0.05).outline_differs


def test_hole_is_seen_through_and_said():
    radius = np.linalg.norm(view(0.7).rays[:, :2], axis=1)
    ring = (radius > 0.05) & (radius < 0.13)
    seen_through = view(np.where(ring, 0.6, 0.8), ring)
    expected = np.count_nonzero(radius <= 0.05) / np.count_nonzero(ring)
    assert seen_through.hole_share == pytest.approx(expected)
    assert "has a hole" in check_covered_share(0.3, seen_through, 1)
    assert "has a hole" in check_covered_share(0.5, seen_through, 3)
    assert check_covered_share(0.05, seen_through, 1) == ""
    # Few solids do not follow the edge of a hole: several parts may cover more of it.
    assert check_covered_share(0.3, seen_through, 2) == ""


@pytest.mark.parametrize("inner_depth", [0.0, 0.5, 0.6])
def test_no_hole_without_a_reading_behind_the_object(inner_depth):
    radius = np.linalg.norm(view(0.7).rays[:, :2], axis=1)
    ring = (radius > 0.05) & (radius < 0.13)
    depth = np.where(ring, 0.6, np.where(radius < 0.09, inner_depth, 0.8))
    filled = ring | ((radius < 0.09) & (inner_depth == 0.6))
    closed = view(depth, filled)
    assert closed.hole_share == 0.0
    assert "bent, branched" in check_covered_share(0.3, closed, 2)
    assert view(0.7).hole_share == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_directions_without_information_equal_a_search_over_all_rays(seed):
    rng = np.random.default_rng(seed)
    on_object = rng.random(SIDE**2) < 0.7
    free_space = view(rng.uniform(0.5, 0.9, SIDE**2), on_object)
    directions = np.column_stack([rng.uniform(-0.3, 0.3, (200, 2)), np.ones(200)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    around = np.argsort(-directions @ free_space.rays.T, axis=1)[:, :4]
    nearest = np.sum(directions * free_space.rays[around[:, 0]], axis=1)
    hidden = nearest < np.cos(free_space.pitch)
    hidden |= free_space.occluders[0][around].any(axis=1) | on_object[around].all(axis=1)
    np.testing.assert_array_equal(free_space.hides(directions), hidden)
    assert 0 < np.count_nonzero(hidden) < 200
