"""Tests of ray and plane kernels: depths and heights equal numerical minimisation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception.superquadric import Superquadric
from eyehand.perception.superquadric.parameters import N_PARAMETERS, N_STRAIGHT, ShapeParameters
from eyehand.perception.superquadric.plane_kernels import plane_gap
from eyehand.perception.superquadric.ray_kernels import compute_ray_rows
from eyehand.perception.superquadric.work_rows import LANES, RESIDUAL_ROW, new_workspace

seeds = st.integers(0, 2**31 - 1)


def random_state(rng, low, high, tapered):
    axes = np.log(rng.uniform(0.4, 1.5, 3))
    taper = rng.uniform(-0.5, 0.5, 2) if tapered else np.zeros(2)
    return ShapeParameters(
        axes,
        rng.uniform(low, high, 2),
        Rotation.random(rng=rng).as_matrix(),
        rng.normal(size=3),
        taper,
    )


def make_solid(state) -> Superquadric:
    axes, eps, R, c, taper = state
    pose = RigidTransform.from_components(c, Rotation.from_matrix(R))
    return Superquadric(np.exp(axes), (eps[0], eps[1]), pose, "tapered", (taper[0], taper[1]))


def step_state(state, step):
    axes, eps, R, c, taper = state
    rotation = Rotation.from_rotvec(step[5:8]).as_matrix()
    return ShapeParameters(
        axes + step[:3], eps + step[3:5], R @ rotation, c + R @ step[8:11], taper + step[11:]
    )


def ray_depths(directions, origin, state, tapered, outside):
    """Return depths (K,) and derivatives (K, 13) of rays."""
    work = new_workspace()
    work.flat[:] = np.nan
    grid, n = work.grid, len(directions)
    compute_ray_rows(directions, origin, 0, n, state, tapered, outside, work)
    depths = grid[RESIDUAL_ROW, :n].copy()
    return depths, np.where(depths[:, None] != 0.0, grid[:N_PARAMETERS, :n].T, 0.0)


def ray_depth(direction, origin, state, tapered, outside):
    """Return the depth of one ray and its derivatives."""
    depths, rows = ray_depths(direction[None], origin, state, tapered, outside)
    return depths[0], rows[0]


def plane_height(plane, state, tapered):
    """Return the height above the plane and its derivatives."""
    row = np.zeros(N_PARAMETERS)
    return plane_gap(plane, state, tapered, row, np.zeros(3)), row


def min_scale(direction, origin, state) -> float:
    """Return the minimum gauge along a ray: a grid search, then a bounded minimisation."""
    solid = make_solid(state)
    middle = float(direction @ (state[3] - origin))
    distances = middle + np.linspace(-6.0, 6.0, 6001)
    best = int(np.argmin(solid.radial_scale(origin + distances[:, None] * direction)))
    minimum = minimize_scalar(
        lambda t: float(solid.radial_scale(origin + t * direction)),
        bounds=(distances[best - 1], distances[best + 1]),
        method="bounded",
        options={"xatol": 1e-11},
    )
    return float(minimum.fun)


def aim_ray(rng, state, share):
    """Return a distant ray that passes the centre at a share of the largest semi-axis."""
    origin = state[3] + 6.0 * Rotation.random(rng=rng).apply([0.0, 0.0, 1.0])
    sideways = rng.normal(size=3)
    target = state[3] + share * np.exp(state[0].max()) * sideways / np.linalg.norm(sideways)
    return (target - origin) / np.linalg.norm(target - origin), origin


def derivative(value, step, h=1e-5):
    """Return the fourth-order central difference."""
    return (
        8 * (value(h * step) - value(-h * step)) - value(2 * h * step) + value(-2 * h * step)
    ) / (12 * h)


@given(seed=seeds, tapered=st.booleans(), share=st.floats(0.0, 1.2))
def test_ray_depth_equals_minimum_gauge(seed, tapered, share):
    rng = np.random.default_rng(seed)
    # A tapered solid with ε1 > 1 is not convex: a ray can have two minima.
    state = random_state(rng, 0.1, 1.0 if tapered else 1.9, tapered)
    direction, origin = aim_ray(rng, state, share)
    depth, row = ray_depth(direction, origin, state, tapered, outside=False)
    reference = np.exp(state[0].min()) * (1.0 - min_scale(direction, origin, state))
    assert depth == pytest.approx(max(reference, 0.0), abs=1e-6)
    assert np.all(np.isfinite(row))


@given(seed=seeds, count=st.integers(1, LANES), outside=st.booleans())
def test_rays_are_independent(seed, count, outside):
    rng = np.random.default_rng(seed)
    state = random_state(rng, 0.1, 1.9, tapered=False)
    origin = state[3] + np.array([0.0, 0.0, 6.0])
    targets = state[3] + rng.normal(size=(count, 3))
    directions = (targets - origin) / np.linalg.norm(targets - origin, axis=1, keepdims=True)
    depths, rows = ray_depths(directions, origin, state, False, outside)
    for direction, depth, row in zip(directions, depths, rows, strict=True):
        single = ray_depth(direction, origin, state, False, outside)
        assert single[0] == pytest.approx(depth, abs=1e-12)
        assert np.allclose(single[1], row, atol=1e-12)


@given(seed=seeds, share=st.floats(0.9, 1.6))
def test_depth_outside_solid_equals_minimum_gauge(seed, share):
    rng = np.random.default_rng(seed)
    state = random_state(rng, 0.1, 1.9, tapered=False)
    direction, origin = aim_ray(rng, state, share)
    min_gauge = min_scale(direction, origin, state)
    depth, _ = ray_depth(direction, origin, state, tapered=False, outside=True)
    if min_gauge < 1.8 / np.sqrt(3.0):
        # Up to this gauge the minimum lies within the search ball.
        assert depth == pytest.approx(np.exp(state[0].min()) * (1.0 - min_gauge), abs=1e-6)


@given(seed=seeds, tapered=st.booleans())
def test_ray_derivatives_match_finite_differences(seed, tapered):
    rng = np.random.default_rng(seed)
    # Avoid ridges (ε > 1) and kinks (equal semi-axes, rays through the centre).
    state = random_state(rng, 0.4, 1.0, tapered)
    direction, origin = aim_ray(rng, state, 0.4)
    depth, row = ray_depth(direction, origin, state, tapered, outside=False)
    if depth < 0.05 or np.ptp(np.sort(state[0])[:2]) < 0.01:
        return

    def value(step):
        return ray_depth(direction, origin, step_state(state, step), tapered, outside=False)[0]

    n_free = N_PARAMETERS if tapered else N_STRAIGHT
    numeric = [derivative(value, d) for d in np.eye(N_PARAMETERS)[:n_free]]
    assert np.allclose(row[:n_free], numeric, atol=2e-5)


@given(seed=seeds, tapered=st.booleans())
def test_plane_height_equals_lowest_point(seed, tapered):
    rng = np.random.default_rng(seed)
    state = random_state(rng, 0.05, 1.95, tapered)
    normal = Rotation.random(rng=rng).apply([0.0, 0.0, 1.0])
    plane = np.append(normal, rng.normal())
    lowest, _ = plane_height(plane, state, tapered)
    assert lowest == pytest.approx(plane[3] - make_solid(state).support(-normal), abs=1e-6)


@given(seed=seeds, tapered=st.booleans())
def test_plane_height_derivatives_match_finite_differences(seed, tapered):
    rng = np.random.default_rng(seed)
    # A sharp tapered edge touches with a corner. There the touching section jumps.
    state = random_state(rng, 0.4, 1.2 if tapered else 1.6, tapered)
    axes, eps, R, c, taper = state
    down = rng.uniform(0.3, 1.0, 3) * rng.choice([-1, 1], 3)
    normal = -R @ (down / np.linalg.norm(down))
    plane = np.append(normal, rng.normal())
    _, row = plane_height(plane, state, tapered)
    n_free = N_PARAMETERS if tapered else N_STRAIGHT
    numeric = [
        derivative(lambda step: plane_height(plane, step_state(state, step), tapered)[0], d)
        for d in np.eye(N_PARAMETERS)[:n_free]
    ]
    assert np.allclose(row[:n_free], numeric, atol=2e-5)
    # Raising the solid raises its height by the same amount.
    raised = ShapeParameters(axes, eps, R, c + 0.3 * normal, taper)
    assert plane_height(plane, raised, tapered)[0] - plane_height(plane, state, tapered)[
        0
    ] == pytest.approx(0.3)


def test_ball_has_ray_depth_of_radius_and_zero_plane_height():
    ball = ShapeParameters(
        np.log(np.full(3, 0.5)), np.ones(2), np.eye(3), np.array([0.0, 0.0, 0.5]), np.zeros(2)
    )
    origin = np.array([0.0, 0.0, 3.0])
    downwards, sideways = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    assert ray_depth(downwards, origin, ball, False, False)[0] == pytest.approx(0.5, abs=1e-6)
    assert ray_depth(sideways, origin, ball, False, False)[0] == 0.0
    assert ray_depth(-downwards, -origin, ball, False, False)[0] == pytest.approx(0.5, abs=1e-6)
    gap = plane_height(np.array([0.0, 0.0, 1.0, 0.0]), ball, False)[0]
    assert gap == pytest.approx(0.0, abs=1e-9)
