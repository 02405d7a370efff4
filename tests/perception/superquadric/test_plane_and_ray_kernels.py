"""Rays and the support plane: compiled depths and heights equal plain minimisations."""

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


def solid_of(state) -> Superquadric:
    axes, eps, R, c, taper = state
    pose = RigidTransform.from_components(c, Rotation.from_matrix(R))
    return Superquadric(np.exp(axes), (eps[0], eps[1]), pose, "tapered", (taper[0], taper[1]))


def moved(state, step):
    axes, eps, R, c, taper = state
    turn = Rotation.from_rotvec(step[5:8]).as_matrix()
    return ShapeParameters(
        axes + step[:3], eps + step[3:5], R @ turn, c + R @ step[8:11], taper + step[11:]
    )


def rays_at(directions, origin, state, tapered, outside):
    """Depths (K,) and derivatives (K, 13)."""
    work = new_workspace()
    work.flat[:] = np.nan
    grid, n = work.grid, len(directions)
    compute_ray_rows(directions, origin, 0, n, state, tapered, outside, work)
    depths = grid[RESIDUAL_ROW, :n].copy()
    return depths, np.where(depths[:, None] != 0.0, grid[:N_PARAMETERS, :n].T, 0.0)


def ray(direction, origin, state, tapered, outside):
    """Depth and derivatives."""
    depths, rows = rays_at(direction[None], origin, state, tapered, outside)
    return depths[0], rows[0]


def height(plane, state, tapered):
    """Height over the plane and derivatives."""
    row = np.zeros(N_PARAMETERS)
    return plane_gap(plane, state, tapered, row, np.zeros(3)), row


def min_scale(direction, origin, state) -> float:
    """Smallest gauge along a ray: on a grid, then between the grid's neighbours."""
    solid = solid_of(state)
    middle = float(direction @ (state[3] - origin))
    times = middle + np.linspace(-6.0, 6.0, 6001)
    best = int(np.argmin(solid.radial_scale(origin + times[:, None] * direction)))
    near = minimize_scalar(
        lambda t: float(solid.radial_scale(origin + t * direction)),
        bounds=(times[best - 1], times[best + 1]),
        method="bounded",
        options={"xatol": 1e-11},
    )
    return float(near.fun)


def aimed(rng, state, share):
    """A ray from afar that passes the centre at a share of the largest semi-axis."""
    origin = state[3] + 6.0 * Rotation.random(rng=rng).apply([0.0, 0.0, 1.0])
    aside = rng.normal(size=3)
    target = state[3] + share * np.exp(state[0].max()) * aside / np.linalg.norm(aside)
    return (target - origin) / np.linalg.norm(target - origin), origin


def derivative(value, step, h=1e-5):
    """Fourth-order central difference."""
    return (
        8 * (value(h * step) - value(-h * step)) - value(2 * h * step) + value(-2 * h * step)
    ) / (12 * h)


@given(seed=seeds, tapered=st.booleans(), share=st.floats(0.0, 1.2))
def test_a_rays_depth_is_that_of_its_lowest_gauge(seed, tapered, share):
    rng = np.random.default_rng(seed)
    # A tapered solid with ε1 > 1 is not convex: along a ray there may be two minima.
    state = random_state(rng, 0.1, 1.0 if tapered else 1.9, tapered)
    direction, origin = aimed(rng, state, share)
    depth, row = ray(direction, origin, state, tapered, outside=False)
    reference = np.exp(state[0].min()) * (1.0 - min_scale(direction, origin, state))
    assert depth == pytest.approx(max(reference, 0.0), abs=1e-6)
    assert np.all(np.isfinite(row))


@given(seed=seeds, count=st.integers(1, LANES), outside=st.booleans())
def test_rays_do_not_know_of_one_another(seed, count, outside):
    rng = np.random.default_rng(seed)
    state = random_state(rng, 0.1, 1.9, tapered=False)
    origin = state[3] + np.array([0.0, 0.0, 6.0])
    targets = state[3] + rng.normal(size=(count, 3))
    directions = (targets - origin) / np.linalg.norm(targets - origin, axis=1, keepdims=True)
    depths, rows = rays_at(directions, origin, state, False, outside)
    for direction, depth, row in zip(directions, depths, rows, strict=True):
        alone = ray(direction, origin, state, False, outside)
        assert alone[0] == pytest.approx(depth, abs=1e-12)
        assert np.allclose(alone[1], row, atol=1e-12)


@given(seed=seeds, share=st.floats(0.9, 1.6))
def test_a_ray_that_passes_near_by_is_told_by_how_much_it_misses(seed, share):
    rng = np.random.default_rng(seed)
    state = random_state(rng, 0.1, 1.9, tapered=False)
    direction, origin = aimed(rng, state, share)
    least = min_scale(direction, origin, state)
    depth, _ = ray(direction, origin, state, tapered=False, outside=True)
    if least < 1.8 / np.sqrt(3.0):
        # So far every minimum lies within the ball in which it is looked for.
        assert depth == pytest.approx(np.exp(state[0].min()) * (1.0 - least), abs=1e-6)


@given(seed=seeds, tapered=st.booleans())
def test_a_rays_derivatives_match_finite_differences(seed, tapered):
    rng = np.random.default_rng(seed)
    # Above ε = 1 there are ridges, at equal semi-axes and through the centre kinks: off those.
    state = random_state(rng, 0.4, 1.0, tapered)
    direction, origin = aimed(rng, state, 0.4)
    depth, row = ray(direction, origin, state, tapered, outside=False)
    if depth < 0.05 or np.ptp(np.sort(state[0])[:2]) < 0.01:
        return

    def value(step):
        return ray(direction, origin, moved(state, step), tapered, outside=False)[0]

    moving = N_PARAMETERS if tapered else N_STRAIGHT
    numeric = [derivative(value, d) for d in np.eye(N_PARAMETERS)[:moving]]
    assert np.allclose(row[:moving], numeric, atol=2e-5)


@given(seed=seeds, tapered=st.booleans())
def test_the_height_over_a_plane_is_that_of_the_lowest_point(seed, tapered):
    rng = np.random.default_rng(seed)
    state = random_state(rng, 0.05, 1.95, tapered)
    normal = Rotation.random(rng=rng).apply([0.0, 0.0, 1.0])
    plane = np.append(normal, rng.normal())
    lowest, _ = height(plane, state, tapered)
    assert lowest == pytest.approx(plane[3] - solid_of(state).support(-normal), abs=1e-6)


@given(seed=seeds, tapered=st.booleans())
def test_the_heights_derivatives_match_finite_differences(seed, tapered):
    rng = np.random.default_rng(seed)
    # Sharp tapered edges touch with corners, where the section that touches jumps.
    state = random_state(rng, 0.4, 1.2 if tapered else 1.6, tapered)
    axes, eps, R, c, taper = state
    down = rng.uniform(0.3, 1.0, 3) * rng.choice([-1, 1], 3)
    normal = -R @ (down / np.linalg.norm(down))
    plane = np.append(normal, rng.normal())
    _, row = height(plane, state, tapered)
    moving = N_PARAMETERS if tapered else N_STRAIGHT
    numeric = [
        derivative(lambda step: height(plane, moved(state, step), tapered)[0], d)
        for d in np.eye(N_PARAMETERS)[:moving]
    ]
    assert np.allclose(row[:moving], numeric, atol=2e-5)
    # A raised solid is higher by as much.
    raised = ShapeParameters(axes, eps, R, c + 0.3 * normal, taper)
    assert height(plane, raised, tapered)[0] - height(plane, state, tapered)[0] == pytest.approx(
        0.3
    )


def test_a_ball_is_entered_by_its_radius_and_stands_on_the_plane():
    ball = ShapeParameters(
        np.log(np.full(3, 0.5)), np.ones(2), np.eye(3), np.array([0.0, 0.0, 0.5]), np.zeros(2)
    )
    origin = np.array([0.0, 0.0, 3.0])
    straight, aside = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    assert ray(straight, origin, ball, False, False)[0] == pytest.approx(0.5, abs=1e-6)
    assert ray(aside, origin, ball, False, False)[0] == 0.0
    assert ray(-straight, -origin, ball, False, False)[0] == pytest.approx(0.5, abs=1e-6)
    over = height(np.array([0.0, 0.0, 1.0, 0.0]), ball, False)[0]
    assert over == pytest.approx(0.0, abs=1e-9)
