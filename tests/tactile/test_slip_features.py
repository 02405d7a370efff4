"""Slip features against a plain reference, and their meaning on sliding and stuck contacts."""

import numpy as np
import pytest

from eyehand.tactile import PRESSURE_FEATURES, SlipState
from eyehand.tactile.slip_features import BAND_TIMES, FEATURES

ROWS, COLUMNS, PITCH, NOISE, PERIOD = 16, 16, 0.005, 5.0, 1 / 1900
SCALE = 1e-3


def contact(shift: float = 0.0, factor: float = 1.0) -> np.ndarray:
    """Return the pressures (256,) of a round contact at x = `shift`, m."""
    x, y = np.meshgrid((np.arange(COLUMNS) - 7.5) * PITCH, (np.arange(ROWS) - 7.5) * PITCH)
    return factor * 4000 * np.exp(-((x - shift) ** 2 + y**2) / 0.012**2).ravel()


def run(images, shears=None) -> np.ndarray:
    state = SlipState(ROWS, COLUMNS, PITCH, NOISE, PERIOD)
    values = np.zeros(FEATURES)
    for k, image in enumerate(images):
        values = state.update(image, None if shears is None else shears[k])
    return values.copy()


def test_features_of_pressures_equal_a_plain_reference():
    rng = np.random.default_rng(0)
    images = [contact(2e-5 * k, 1 + 0.002 * k) + rng.normal(0, NOISE, 256) for k in range(60)]
    found = run(images)
    means = [images[0].copy() for _ in BAND_TIMES]
    for image in images:
        for mean, time in zip(means, BAND_TIMES, strict=True):
            mean += (1 - np.exp(-PERIOD / time)) * (image - mean)
    touching = means[2] > 4 * NOISE
    x = np.tile((np.arange(COLUMNS) - 7.5) * PITCH, ROWS)
    forces = [mean[touching].sum() for mean in means]
    centres = [
        (x[touching] * mean[touching]).sum() / force
        for mean, force in zip(means, forces, strict=True)
    ]
    assert found[0] == pytest.approx(np.arcsinh((forces[0] - forces[1]) / forces[2] / SCALE))
    assert found[1] == pytest.approx(np.arcsinh((forces[1] - forces[2]) / forces[2] / SCALE))
    assert found[3] == pytest.approx(
        np.arcsinh((centres[1] - centres[2]) / PITCH / SCALE), rel=0.01
    )
    for band in range(2):
        older, newer = (means[band + 1].reshape(16, 16), means[band].reshape(16, 16))
        inner = np.zeros((16, 16), bool)
        inner[1:-1, 1:-1] = True
        mask = inner & (older > 4 * NOISE)
        slopes = np.gradient(older)
        basis = np.column_stack([older[mask], slopes[1][mask], slopes[0][mask]])
        change = (newer - older)[mask]
        rest = change - basis @ np.linalg.lstsq(basis, change, rcond=None)[0]
        size = np.linalg.norm(older[mask])
        assert found[9 + band] == pytest.approx(np.arcsinh(np.linalg.norm(change) / size / SCALE))
        assert found[11 + band] == pytest.approx(
            np.arcsinh(np.linalg.norm(rest) / size / SCALE), rel=1e-6
        )


def test_still_contact_has_no_change():
    values = run([contact()] * 20)
    assert values[:PRESSURE_FEATURES] == pytest.approx(np.zeros(PRESSURE_FEATURES), abs=1e-6)


def test_no_contact_has_no_features():
    assert not run([np.zeros(256)] * 5).any()


def test_shear_features_are_zero_without_an_array_of_shear():
    assert not run([contact(1e-5 * k) for k in range(20)])[PRESSURE_FEATURES:].any()


@pytest.mark.parametrize("sliding", [False, True])
def test_change_of_shear_tells_stuck_and_sliding_contacts_apart(sliding):
    image = contact()
    touching = image > 4 * NOISE
    pattern = 0.3 * image if sliding else 300.0 * touching
    shears = [np.column_stack([(1 + 0.01 * k) * pattern, 0 * pattern]) for k in range(60)]
    values = run([image] * 60, shears)
    # Positive where the change is like the pressure, as of a sliding face.
    fits = values[PRESSURE_FEATURES + 10 : PRESSURE_FEATURES + 12]
    assert (np.sign(fits) == (1 if sliding else -1)).all()


def test_features_do_not_depend_on_direction_or_unit():
    rng = np.random.default_rng(1)
    images = [contact(3e-5 * k) + rng.normal(0, 1.0, 256) for k in range(40)]
    shears = [rng.normal(200, 5, (256, 2)) for _ in images]
    turned = [image.reshape(16, 16).T.ravel() for image in images]
    swapped = [
        np.column_stack([s[:, 1].reshape(16, 16).T.ravel(), s[:, 0].reshape(16, 16).T.ravel()])
        for s in shears
    ]
    assert run(turned, swapped) == pytest.approx(run(images, shears), abs=1e-6)
