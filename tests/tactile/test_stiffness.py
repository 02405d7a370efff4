"""The estimate of the contact stiffness dp/dz: accuracy, robustness to noise, and bounds."""

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
    """The compiled estimator with its state."""

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
def test_one_press_estimates_stiffness(true):
    estimate = Estimate()
    rng = np.random.default_rng(0)
    for pressure in np.linspace(0.0, 1000.0, 60):
        estimate.update(pressure + rng.normal(0.0, 2.0), pressure / true)
    assert estimate.value == pytest.approx(true, rel=0.1)


def test_initial_stiffness_is_kept_without_excitation():
    estimate = Estimate()
    rng = np.random.default_rng(1)
    for _ in range(5000):
        estimate.update(1000.0 + rng.normal(0.0, 2.0), rng.normal(0.0, 5e-7))
    assert estimate.value == INITIAL_STIFFNESS
    assert estimate.state[UPDATES] == 0.0


def test_estimate_follows_increasing_stiffness():
    estimate = Estimate()
    depth = pressure = 0.0
    for true in (1e5, 1e6):
        for k in range(200):
            travel = 2e-4 * np.sin(0.3 * k)
            depth, pressure = depth + travel, pressure + true * travel
            estimate.update(pressure, depth)
        assert estimate.value == pytest.approx(true, rel=0.05)


def test_pressure_change_while_rolling_is_ignored():
    estimate = Estimate()
    for k in range(200):
        estimate.update(500.0 * np.sin(k), 1e-5 * k, rolled=1e-4)
    assert estimate.state[UPDATES] == 0.0


def test_pressure_that_falls_with_depth_counts_as_no_rise():
    falling, constant = Estimate(), Estimate()
    for estimate, fall in ((falling, 3e5), (constant, 0.0)):
        for depth in np.linspace(0.0, 1e-3, 50):
            estimate.update(5e5 * depth, depth)
        estimate.update(500.0 - fall * 1e-4, 1.1e-3)
    assert falling.value == constant.value < 5e5


def test_travel_without_contact_is_ignored():
    estimate = Estimate()
    estimate.update(1000.0, 0.0)
    estimate.state[STARTED] = 0.0
    estimate.update(900.0, 0.05)
    assert estimate.value == INITIAL_STIFFNESS


@settings(max_examples=50)
@given(
    readings=st.lists(st.tuples(st.floats(0.0, 1e4), st.floats(-0.1, 0.1)), min_size=2, max_size=50)
)
def test_estimate_stays_within_bounds_for_any_readings(readings):
    estimate = Estimate()
    for pressure, depth in readings:
        value = estimate.update(pressure, depth)
        assert MIN_STIFFNESS <= value <= MAX_STIFFNESS


def test_estimate_equals_weighted_least_squares():
    """The recursive estimate equals the batch solution.

    The weights decay by the forgetting factor. The initial guess counts as one more reading.
    """
    rng = np.random.default_rng(2)
    travels = rng.uniform(3e-5, 3e-4, 30) * rng.choice([-1.0, 1.0], 30)
    changes = 1.3e6 * travels + rng.normal(0.0, 20.0, 30)
    estimate = Estimate()
    estimate.update(0.0, 0.0)
    for depth, pressure in zip(np.cumsum(travels), np.cumsum(changes), strict=True):
        estimate.update(pressure, depth)
    weights = FORGETTING ** np.arange(29, -1, -1)
    guess = FORGETTING**30 * INITIAL_TRAVEL**2
    expected = (guess * INITIAL_STIFFNESS + np.sum(weights * travels * changes)) / (
        guess + np.sum(weights * travels**2)
    )
    assert estimate.value == pytest.approx(expected, rel=1e-9)
