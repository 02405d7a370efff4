"""The slide of a held face, from the shift of the pressure and the shear."""

import numpy as np
import pytest

from eyehand.tactile.slide_estimate import PARTS, SLIDE_FEATURES, SLIDE_TIMES, slide_features

ROWS, PITCH, STIFFNESS, HEIGHT, THRESHOLD = 16, 0.005, 3e6, 0.004, 20.0
PERIOD = 1 / 1900
PEAK = 5000.0
MEAN_PRESSURE = 0.5 * PEAK
"""Mean of a Gaussian pressure with itself as weight, Pa."""
SHARES = np.array([1 - np.exp(-PERIOD / time) for time in SLIDE_TIMES])
LAYER = (THRESHOLD, PITCH, STIFFNESS, HEIGHT)


def image(slide: float, ratio: float) -> np.ndarray:
    """Return the image of a face that has slid along x, m, with a ratio of shear to pressure.

    The face has moved by the bend of the layer too, and the layer turns by its height.
    """
    x, y = np.meshgrid((np.arange(ROWS) - 7.5) * PITCH, (np.arange(ROWS) - 7.5) * PITCH)
    bend = ratio * MEAN_PRESSURE / STIFFNESS
    place = slide + 1.1 * bend + 0.85 * HEIGHT * ratio
    pressure = PEAK * np.exp(-((x - place) ** 2 + y**2) / 0.012**2)
    return np.array([pressure, ratio * pressure, np.zeros_like(x)])


def run(images) -> np.ndarray:
    means, values = np.zeros((len(SLIDE_TIMES) + 1, PARTS, 2)), np.zeros(SLIDE_FEATURES)
    for one in images:
        slide_features(one, one[0], LAYER, SHARES, means, values)
    return np.sinh(values).reshape(len(SLIDE_TIMES), 5) * 1e-5


def test_a_stuck_face_that_bends_the_layer_has_not_slid():
    found = run(image(0.0, ratio) for ratio in np.linspace(0.2, 0.3, 100))
    # The centre of pressure moved far more than the estimate of the slide.
    assert found[1, 2] > 1e-4
    assert np.abs(found[:, :2]).max() < 0.03 * found[1, 2]


def test_a_slide_under_constant_shear_is_found():
    slides = np.concatenate([np.zeros(100), np.linspace(0, 3e-4, 100)])
    found = run(image(slide, 0.3) for slide in slides)
    speed = 3e-4 / (100 * PERIOD)
    # The faster mean follows with its time constant, and the sum of all changes is the slide.
    assert found[0, 0] == pytest.approx(speed * SLIDE_TIMES[0], rel=0.1)
    assert 1e-4 < found[:, 0].sum() < 3e-4
    assert found[:, :2] == pytest.approx(found[:, [2, 2]], rel=0.01)
    assert found[:, 3:] == pytest.approx(np.zeros((3, 2)), abs=1e-7)


def test_features_equal_a_plain_reference():
    rng = np.random.default_rng(0)
    images = [
        np.array([image(1e-5 * k, 0.01 * k)[0], *(rng.normal(400, 50, (2, ROWS, ROWS)))])
        for k in range(40)
    ]
    x, y = np.meshgrid((np.arange(ROWS) - 7.5) * PITCH, (np.arange(ROWS) - 7.5) * PITCH)
    motions = []
    for pressure, *shears in images:
        at = pressure > THRESHOLD
        p, shear = pressure[at], np.array([s[at] for s in shears])
        centre = np.array([x[at] @ p, y[at] @ p]) / p.sum()
        turned = 0.85 * HEIGHT * shear.sum(axis=1) / p.sum()
        motions.append([centre, turned, 1.1 * shear @ p / (p.sum() * STIFFNESS)])
    now = np.array(motions)
    means = [now[0].copy() for _ in SLIDE_TIMES]
    for motion in now:
        for mean, share in zip(means, SHARES, strict=True):
            mean += share * (motion - mean)
    unit = means[0][1] / (np.linalg.norm(means[0][1]) + 1e-3 * HEIGHT)
    for k, found in enumerate(run(images)):
        step = (now[-1] if k == 0 else means[k - 1]) - means[k]
        slide = step[0] - step[1] - step[2]
        expected = [slide @ unit, np.linalg.norm(slide), *(step @ unit)]
        assert found == pytest.approx(expected, abs=1e-12)


def test_without_contact_there_are_no_features_and_the_means_start_again():
    nothing = np.zeros((3, ROWS, ROWS))
    assert not run([image(0.0, 0.1), nothing]).any()
    jumped = run([image(0.0, 0.1), nothing, image(0.01, 0.1)])
    assert np.abs(jumped).max() < 1e-9
