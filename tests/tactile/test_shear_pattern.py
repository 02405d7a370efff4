"""The pattern of a contact's shear against a plain reference, and on stuck and sliding cells."""

import numpy as np
import pytest

from eyehand.tactile.shear_pattern import PATTERN_FEATURES, shear_pattern

PITCH, STIFFNESS, THRESHOLD = 0.005, 3e6, 80.0
X, Y = np.meshgrid(np.arange(16) * PITCH, np.arange(16) * PITCH)


def pattern(image: np.ndarray) -> np.ndarray:
    out = np.empty(PATTERN_FEATURES)
    shear_pattern(image, image[0], THRESHOLD, PITCH, STIFFNESS, out)
    return out


def pressed() -> np.ndarray:
    pressure = 6000 * np.exp(-((X - 0.036) ** 2 + (Y - 0.04) ** 2) / 0.01**2)
    return np.where(pressure > THRESHOLD, pressure, 0.0)


def moved(pressure: np.ndarray, shift: tuple[float, float], turn: float, limit: float = 1e6):
    """Return the image of a face that moves like a rigid body; cells slide at a ratio `limit`."""
    across = STIFFNESS * (shift[0] - turn * (Y - 0.04))
    along = STIFFNESS * (shift[1] + turn * (X - 0.036))
    size = np.maximum(np.hypot(across, along), 1e-9)
    share = np.minimum(1.0, limit * pressure / size) * (pressure > 0)
    return np.array([pressure, share * across, share * along])


def test_pattern_equals_a_plain_reference():
    rng = np.random.default_rng(0)
    image = moved(pressed(), (2e-4, 1e-4), 0.01, 0.4)
    image[1:] += rng.normal(0, 20, image[1:].shape)
    touching = image[0] > THRESHOLD
    p, tx, ty = (part[touching] for part in image)
    x, y = X[touching], Y[touching]
    bends = np.column_stack([tx, ty]) / STIFFNESS
    found = pattern(image)
    for cubed, power in enumerate((1, 3)):
        weights = np.sqrt(np.tile(p**power, 2))
        ones, zeros = np.ones_like(x), np.zeros_like(x)
        basis = np.vstack([np.column_stack([ones, zeros, -y]), np.column_stack([zeros, ones, x])])
        fit = np.linalg.lstsq(weights[:, None] * basis, weights * bends.T.ravel(), rcond=None)[0]
        rigid = (basis @ fit).reshape(2, -1).T
        left, size = rigid - bends, np.linalg.norm(rigid, axis=1)
        lag = np.average(np.sum(left * rigid, axis=1) / size, weights=p)
        rest = np.sqrt(np.average(np.sum(left**2, axis=1), weights=p))
        expected = [lag, rest, np.average(size, weights=p)]
        assert found[3 * cubed : 3 * cubed + 3] == pytest.approx(expected, rel=0.01, abs=1e-9)
    shear = np.hypot(tx, ty)
    mean = shear.sum() / p.sum()
    spread = np.sqrt(np.average((shear / p - mean) ** 2, weights=p)) / mean
    like = 1 - (shear @ p) ** 2 / ((shear @ shear) * (p @ p))
    total = np.hypot(tx.sum(), ty.sum())
    assert found[6:] == pytest.approx([mean, spread, like, total / shear.sum(), total / p.sum()])


def test_stuck_face_lags_nowhere_and_sliding_rim_lags():
    stuck = pattern(moved(pressed(), (2e-4, 0.0), 0.005))
    partly = pattern(moved(pressed(), (2e-4, 0.0), 0.005, 0.4))
    assert np.abs(stuck[:2]).max() < 1e-9
    assert stuck[2] == pytest.approx(2e-4, rel=0.05)
    # Of the fit by the cubed pressure, stuck cells decide: the others lag behind it.
    assert partly[3] > 2e-5
    assert partly[4] > 2e-5


def test_sliding_face_has_a_shear_like_its_pressure():
    sliding = pattern(moved(pressed(), (5e-3, 0.0), 0.0, 0.4))
    assert sliding[6:] == pytest.approx([0.4, 0.0, 0.0, 1.0, 0.4], abs=1e-6)


def test_no_contact_has_no_pattern():
    assert not pattern(np.zeros((3, 16, 16))).any()
