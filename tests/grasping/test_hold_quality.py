"""Probability that a grasp holds: mechanics of single contacts, and the uncertainty of the fit."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.grasping.hold_kernels import VARIATES, hold_probability

ROWS = np.array([0.026, 0.0, -0.026])
HAND = np.array([3.5, 0.0085, 0.012, 0.004, 0.006, 1.0])
ENDS = np.array([-0.05, 0.05, 0.02, 0.004])
ERRORS = np.array([0.003, 0.003, 0.1, 0.4, 0.005, 0.005, 0.15])
LOAD = np.array([3.0, 0.0, 0.0, 1.0, 0.0, 0.0])
FLAT = np.zeros(2)


def variates(count=512):
    return np.random.default_rng(1).standard_normal((count, VARIATES))


def held(sample, rows, slopes, ends, errors, load, hand, friction):
    """Return whether one sample holds, step by step in plain NumPy."""
    low, high = ends[:2] + errors[0] * sample[:2]
    if ends[2] + errors[1] * sample[2] < ends[3]:
        return False
    left = np.maximum(low, rows - hand[1])
    right = np.minimum(high, rows + hand[1])
    touches = right - left >= hand[3]
    thumb = max(low, -hand[2]), min(high, hand[2])
    if touches.sum() < hand[5] or thumb[1] - thumb[0] < hand[3]:
        return False
    mu = max(friction + errors[6] * sample[5], 0.05)
    if (slopes + errors[2] * sample[3:5]).min() < -mu:
        return False
    places = 0.5 * (left + right)[touches]
    spread = np.hypot(places.std(), hand[4])
    lever = max(places.mean() - thumb[1], thumb[0] - places.mean(), 0.0)
    if lever > spread + mu * hand[4]:
        return False
    force = load[0] * np.exp(errors[3] * sample[6])
    arm = np.array([load[4] - places.mean(), load[5]]) + errors[4:6] * sample[7:9]
    torque = force * abs(arm[0] * load[3] - arm[1] * load[2])
    capacity = 2.0 * mu * touches.sum() * hand[0]
    across = force * np.hypot(load[2], load[3])
    within = (across / capacity) ** 2 + (torque / (capacity * spread)) ** 2 < 1.0
    return bool(within and force * abs(load[1]) < touches.sum() * hand[0])


def probability(**changes):
    given = {
        "rows": ROWS,
        "slopes": FLAT,
        "ends": ENDS,
        "errors": ERRORS,
        "load": LOAD,
        "hand": HAND,
        "friction": 0.8,
    } | changes
    return hold_probability(variates(), *given.values())


def test_kernel_equals_numpy_sample_by_sample():
    rng = np.random.default_rng(2)
    shares = set()
    for _ in range(40):
        half = rng.uniform(0.004, 0.05)
        ends = np.array([-half, half, rng.uniform(0.0, 0.03), 0.004])
        ends[:2] += rng.uniform(-0.02, 0.02)
        load = np.array([rng.uniform(1, 20), *rng.normal(size=3), *rng.normal(0, 0.03, 2)])
        slopes = rng.uniform(-1.0, 0.5, 2)
        samples = variates(64)
        found = hold_probability(samples, ROWS, slopes, ends, ERRORS, load, HAND, 0.8)
        expected = [held(v, ROWS, slopes, ends, ERRORS, load, HAND, 0.8) for v in samples]
        assert found == pytest.approx(np.mean(expected))
        shares.add(found)
    assert len(shares) > 10


def test_light_object_between_wide_fingers_is_held():
    assert probability() > 0.97


@pytest.mark.parametrize(
    "worse",
    [
        {"load": LOAD * np.array([8.0, 1, 1, 1, 1, 1])},
        {"load": np.array([6.0, 0.0, 0.0, 1.0, 0.08, 0.0])},
        {"slopes": np.array([-0.9, 0.0])},
        {"ends": np.array([-0.05, 0.05, 0.004, 0.004])},
        {"friction": 0.15},
        {
            "hand": HAND + np.array([0, 0, 0, 0, 0, 1.0]),
            "ends": np.array([-0.012, 0.012, 0.02, 0.004]),
        },
    ],
    ids=["heavy", "off centre", "slope", "shallow", "slippery", "thin in a power grasp"],
)
def test_each_cause_of_failure_lowers_the_probability(worse):
    assert probability(**worse) < 0.75


def test_uncertain_ends_lower_the_probability_of_a_thin_object():
    thin = {"ends": np.array([-0.004, 0.004, 0.02, 0.004])}
    certain = ERRORS.copy()
    certain[0] = 1e-4
    assert probability(errors=certain, **thin) - probability(**thin) > 0.02
