"""Repulsion: gradient of the cost against finite differences, and the stability limit."""

import re

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from eyehand.control.options import ControlOptions
from eyehand.control.proximity import Proximity
from eyehand.control.repulsion import repulsion_gradient, require_stable, stable_eta
from eyehand.errors import InputError

Array = NDArray[np.float64]
seeds = st.integers(0, 100_000)
OPTIONS = ControlOptions()


def proximity(distance, rows) -> Proximity:
    distance, rows = np.asarray(distance, dtype=float), np.asarray(rows, dtype=float)
    pairs = len(distance)
    points = np.zeros((pairs, 3))
    return Proximity(
        tuple((f"link{i}", "box") for i in range(pairs)),
        distance,
        points,
        points,
        points,
        rows,
        np.zeros(pairs),
    )


def spheres(q: Array, centres: Array, radius: float) -> Proximity:
    """Return the signed distances of a point robot q (3,) to spheres."""
    offset = q - centres
    length = np.linalg.norm(offset, axis=1)
    return proximity(length - radius, offset / length[:, None])


def repulsion_cost(distance, options: ControlOptions) -> float:
    """Return the cost H_ca (eq. 6): the sum of η (d - d_B)² over distances (P,) below d_B."""
    depth = np.maximum(options.influence - distance, 0.0)
    return options.eta * float(depth @ depth)


@given(seed=seeds, reach=st.floats(0.02, 0.5))
def test_gradient_equals_finite_differences_of_cost(seed, reach):
    rng = np.random.default_rng(seed)
    options = ControlOptions(influence=reach, eta=float(rng.uniform(0.1, 10.0)))
    centres, q = 0.3 * rng.normal(size=(8, 3)), 0.3 * rng.normal(size=3)
    near = spheres(q, centres, 0.25)
    if np.abs(near.distance + 0.25).min() < 0.02:  # the direction is undefined at a centre
        return
    step = 1e-6
    slope = np.zeros(3)
    for axis in range(3):
        shift = step * np.eye(3)[axis]
        up = repulsion_cost(spheres(q + shift, centres, 0.25).distance, options)
        down = repulsion_cost(spheres(q - shift, centres, 0.25).distance, options)
        slope[axis] = (up - down) / (2.0 * step)
    assert np.abs(repulsion_gradient(near, options) - slope).max() < 1e-6


@pytest.mark.parametrize("distance", [0.05, 1e-9, 0.0, -1e-9, -0.02, -0.3])
def test_repulsion_pushes_out_at_any_depth(distance):
    row = np.array([[0.0, 0.3, -0.4]])
    motion = -repulsion_gradient(proximity([distance], row), OPTIONS)
    assert row[0] @ motion > 0.0
    assert np.allclose(motion, 2.0 * OPTIONS.eta * (OPTIONS.influence - distance) * row[0])


def test_repulsion_grows_with_depth():
    depths = np.linspace(0.08, -0.1, 50)
    repulsions = [-repulsion_gradient(proximity([d], [[1.0]]), OPTIONS)[0] for d in depths]
    assert repulsions[0] == 0.0
    assert np.all(np.diff(repulsions) > 0.0)


@given(seed=seeds)
def test_gradient_is_sum_over_close_pairs(seed):
    rng = np.random.default_rng(seed)
    distance, rows = rng.uniform(-0.05, 0.2, 12), rng.normal(size=(12, 7))
    near = distance < OPTIONS.influence
    single = [
        repulsion_gradient(proximity(distance[i : i + 1], rows[i : i + 1]), OPTIONS)
        for i in np.flatnonzero(near)
    ]
    total = repulsion_gradient(proximity(distance, rows), OPTIONS)
    assert np.allclose(total, np.sum(single, axis=0) if single else np.zeros(7))
    assert repulsion_cost(distance[~near], OPTIONS) == 0.0


def test_gradient_without_pairs_is_zero():
    empty = proximity([], np.zeros((0, 7)))
    assert np.array_equal(repulsion_gradient(empty, OPTIONS), np.zeros(7))
    assert repulsion_cost(empty.distance, OPTIONS) == 0.0


# Gains


LEVER, PUSH = 0.8, 0.002


def simulate_joint(gain: float, beta: float = 1.0, steps: int = 400) -> Array:
    """Simulate a joint that is pushed towards an obstacle. Return its offsets from equilibrium.

    The motion is x' = -β grad H - push. η is ``gain`` times the stable value. The joint starts near
    its equilibrium.
    """
    dt = 0.01
    options = ControlOptions(dt=dt, eta=gain * stable_eta(LEVER, dt, beta), influence=0.2)
    equilibrium = PUSH / (2.0 * options.eta * beta * LEVER)
    x = (options.influence - equilibrium) / LEVER + 1e-6
    start, offsets = x - 1e-6, []
    for _ in range(steps):
        offsets.append(x - start)
        near = proximity([LEVER * x], [[LEVER]])
        x += dt * (-beta * repulsion_gradient(near, options)[0] - PUSH)
    return np.array(offsets)


@pytest.mark.parametrize("beta", [0.5, 1.0, 5.0])
@pytest.mark.parametrize("gain", [0.1, 0.5, 0.99])
def test_motion_below_stable_gain_does_not_overshoot(gain, beta):
    offsets = simulate_joint(gain, beta)
    assert np.all(offsets > -1e-15)
    assert np.all(np.diff(offsets) <= 1e-15)
    assert offsets[-1] < 1e-9


@pytest.mark.parametrize("gain", [1.1, 1.5, 1.95])
def test_motion_between_once_and_twice_stable_gain_settles(gain):
    offsets = simulate_joint(gain)
    assert np.all(offsets[:6] * [1, -1, 1, -1, 1, -1] > 0.0)
    assert np.all(np.diff(np.abs(offsets[:6])) < 0.0)
    assert abs(offsets[-1]) < 1e-9


@pytest.mark.parametrize("gain", [2.05, 2.5, 4.0])
def test_motion_above_twice_stable_gain_diverges(gain):
    offsets = simulate_joint(gain)
    assert np.all(offsets[:4] * [1, -1, 1, -1] > 0.0)
    assert np.all(np.diff(np.abs(offsets[:4])) > 0.0)
    assert np.abs(offsets[-50:]).max() > 5e-6  # five times the initial offset, after 4 s


@given(seed=seeds, pairs=st.integers(1, 6))
def test_lever_of_several_pairs_is_spectral_norm_of_rows(seed, pairs):
    rows = np.random.default_rng(seed).normal(size=(pairs, 4))
    dt, beta = 0.005, 1.5
    eta = stable_eta(float(np.linalg.norm(rows, 2)), dt, beta)
    hessian = 2.0 * eta * rows.T @ rows
    assert beta * dt * np.linalg.eigvalsh(hessian)[-1] == pytest.approx(1.0)


def test_corridor_has_half_the_stable_gain_of_one_wall():
    dt, rows = 0.01, np.array([[1.0], [-1.0]])

    def settle(eta: float) -> Array:
        options, x, path = ControlOptions(dt=dt, eta=eta, influence=0.2), 0.01, []
        for _ in range(30):
            path.append(x)
            walls = proximity([0.1 + x, 0.1 - x], rows)
            x -= dt * repulsion_gradient(walls, options)[0]
        return np.array(path)

    one, both = stable_eta(1.0, dt), stable_eta(float(np.linalg.norm(rows, 2)), dt)
    assert both == pytest.approx(0.5 * one)
    # Rounding alone may give values below zero: the compiled gradient ends at -4e-19 m.
    assert np.all(settle(0.99 * both) >= -1e-17)
    assert settle(0.75 * one)[1] < 0.0


@given(
    lever=st.floats(0.1, 3.0),
    dt=st.floats(1e-3, 0.05),
    beta=st.one_of(st.just("dynamic"), st.floats(0.0, 10.0)),
    excess=st.floats(1.001, 100.0),
)
def test_unstable_gain_raises_with_stable_values(lever, dt, beta, excess):
    fixed = 1.0 if beta == "dynamic" else max(beta, 1.0)  # the free motion has weight 1
    eta = excess * stable_eta(lever, dt, fixed)
    assume(eta <= 1e6)
    options = ControlOptions(dt=dt, eta=eta, beta=beta)
    with pytest.raises(InputError, match="eta at most") as error:
        require_stable(options, lever)
    numbers = re.search(r"eta at most (\S+), or dt at most (\S+) ms", str(error.value))
    assert numbers
    max_eta, period = float(numbers[1]), 1e-3 * float(numbers[2])
    require_stable(ControlOptions(dt=dt, eta=max_eta, beta=beta), lever)
    assert max_eta >= 0.99 * stable_eta(lever, dt, fixed)
    assert period >= 0.99 * dt / excess
    if period >= 1e-5:
        require_stable(ControlOptions(dt=period, eta=eta, beta=beta), lever)


def test_default_gain_is_stable_for_arm_of_one_metre():
    require_stable(OPTIONS, 1.0)


def test_any_gain_is_stable_without_motion():
    assert stable_eta(0.0, 0.005) == np.inf
    assert stable_eta(1.0, 0.005, beta=0.0) == np.inf
    require_stable(OPTIONS, 0.0)
