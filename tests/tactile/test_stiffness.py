"""The estimate of dp/dz: told from motion, unmoved by noise, and within its bounds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.tactile.stiffness import (
    FORGETTING,
    INITIAL_STIFFNESS,
    INITIAL_TRAVEL,
    MAX_STIFFNESS,
    MIN_STIFFNESS,
    STARTED,
    STIFFNESS,
    UPDATES,
    new_stiffness,
    update_stiffness,
)


class Estimate:
    """The compiled estimate with its state."""

    def __init__(self) -> None:
        self.state = new_stiffness(INITIAL_STIFFNESS)

    @property
    def value(self) -> float:
        """Estimated stiffness, Pa/m."""
        return float(self.state[STIFFNESS])

    def update(self, pressure: float, depth: float, rolled: float = 0.0) -> float:
        """Update with one reading and return the estimate, Pa/m."""
        update_stiffness(self.state, float(pressure), float(depth), float(rolled))
        return self.value


@pytest.mark.parametrize("true", [5e4, 4e5, 2e6, 1e7])
def test_pressing_once_tells_soft_from_stiff(true):
    estimate = Estimate()
    rng = np.random.default_rng(0)
    for pressure in np.linspace(0.0, 1000.0, 60):
        estimate.update(pressure + rng.normal(0.0, 2.0), pressure / true)
    assert estimate.value == pytest.approx(true, rel=0.1)


def test_the_first_guess_is_on_the_stiff_side_and_stays_without_excitation():
    estimate = Estimate()
    rng = np.random.default_rng(1)
    for _ in range(5000):
        estimate.update(1000.0 + rng.normal(0.0, 2.0), rng.normal(0.0, 5e-7))
    assert estimate.value == INITIAL_STIFFNESS
    assert estimate.state[UPDATES] == 0.0


def test_it_follows_an_object_that_becomes_stiffer():
    estimate = Estimate()
    depth = pressure = 0.0
    for true in (1e5, 1e6):
        for k in range(200):
            way = 2e-4 * np.sin(0.3 * k)
            depth, pressure = depth + way, pressure + true * way
            estimate.update(pressure, depth)
        assert estimate.value == pytest.approx(true, rel=0.05)


def test_what_rolling_did_to_the_pressure_is_no_evidence():
    estimate = Estimate()
    for k in range(200):
        estimate.update(500.0 * np.sin(k), 1e-5 * k, rolled=1e-4)
    assert estimate.state[UPDATES] == 0.0


def test_the_way_through_air_is_no_evidence():
    estimate = Estimate()
    estimate.update(1000.0, 0.0)
    estimate.state[STARTED] = 0.0
    estimate.update(900.0, 0.05)
    assert estimate.value == INITIAL_STIFFNESS


@settings(max_examples=50)
@given(
    readings=st.lists(st.tuples(st.floats(0.0, 1e4), st.floats(-0.1, 0.1)), min_size=2, max_size=50)
)
def test_whatever_comes_it_stays_finite_and_within_bounds(readings):
    estimate = Estimate()
    for pressure, depth in readings:
        value = estimate.update(pressure, depth)
        assert MIN_STIFFNESS <= value <= MAX_STIFFNESS


def test_it_equals_weighted_least_squares():
    """Recursive and in one piece: weights fall by the forgetting, the guess is one more piece."""
    rng = np.random.default_rng(2)
    ways = rng.uniform(3e-5, 3e-4, 30) * rng.choice([-1.0, 1.0], 30)
    changes = 1.3e6 * ways + rng.normal(0.0, 20.0, 30)
    estimate = Estimate()
    estimate.update(0.0, 0.0)
    for depth, pressure in zip(np.cumsum(ways), np.cumsum(changes), strict=True):
        estimate.update(pressure, depth)
    weights = FORGETTING ** np.arange(29, -1, -1)
    guess = FORGETTING**30 * INITIAL_TRAVEL**2
    expected = (guess * INITIAL_STIFFNESS + np.sum(weights * ways * changes)) / (
        guess + np.sum(weights * ways**2)
    )
    assert estimate.value == pytest.approx(expected, rel=1e-9)
