"""The compiled contact features against a NumPy reference and known contacts, on all arrays."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.tactile import FeatureOptions, TactileArray, TactileImage, contact_features
from eyehand.tactile.calibration_curves import fit_curves
from eyehand.tactile.feature_kernels import DEAD, SATURATED, read_pressures

from .reference_features import reference_features

ARRAYS = {
    "flat": TactileArray.flat(),
    "curved": TactileArray.curved(radius=0.03),
    "fingertip": TactileArray.fingertip(),
}


@settings(deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    share=st.floats(0.05, 0.95),
    name=st.sampled_from(sorted(ARRAYS)),
    rim=st.sampled_from([0.0, 0.5, 5.0, 1e3]),
)
def test_compiled_features_equal_numpy_reference(seed, share, name, rim):
    array = ARRAYS[name]
    rng = np.random.default_rng(seed)
    count = len(array.positions)
    pressures = rng.uniform(10.0, 1000.0, count) * (rng.random(count) < share)
    thresholds = rng.uniform(0.0, 300.0, count)
    image, options = TactileImage(pressures, array), FeatureOptions(min_tactels=1, rim_band=rim)
    found = contact_features(image, thresholds, options=options)
    if not (pressures > thresholds).any():
        assert not found
        return
    reference = reference_features(pressures, thresholds, array, rim)
    assert found.tactels == len(reference["region"])
    assert found.force == pytest.approx(reference["force"])
    assert found.area == pytest.approx(reference["area"])
    assert found.pressure == pytest.approx(reference["force"] / reference["area"])
    assert np.allclose(found.centre, reference["centre"])
    assert np.allclose(found.normal, reference["normal"])
    assert found.border_share == pytest.approx(reference["border_share"])
    if found.tactels > 1:
        assert found.confidence == pytest.approx(reference["confidence"], abs=1e-9)
    if found.confidence > 1e-3:
        gap = (found.orientation - reference["angle"] + np.pi / 2) % np.pi - np.pi / 2
        assert gap == pytest.approx(0.0, abs=1e-6)


def test_rim_band_smooths_area_and_pressure_at_threshold_crossing():
    pressures = np.zeros(256)
    pressures[[100, 101, 116]] = 1000.0
    for rim, max_change in ((5.0, 1e-2), (0.0, 0.5)):
        options, found = FeatureOptions(min_tactels=1, rim_band=rim), []
        for rim_pressure in (9.99, 10.01):
            pressures[117] = rim_pressure
            image = TactileImage(pressures.copy(), ARRAYS["flat"])
            found.append(contact_features(image, 10.0, options=options))
        assert [features.tactels for features in found] == [3, 4]
        for name in ("area", "pressure"):
            before, after = (getattr(features, name) for features in found)
            assert abs(after / before - 1.0) < max_change
            assert rim > 0.0 or abs(after / before - 1.0) > 0.2


@pytest.mark.parametrize("name", ARRAYS)
def test_orientation_of_single_tactel_has_no_confidence(name):
    array, rng = ARRAYS[name], np.random.default_rng(0)
    for tactel in range(len(array.positions)):
        pressures = np.zeros(len(array.positions))
        pressures[tactel] = rng.uniform(10.0, 1000.0)
        found = contact_features(TactileImage(pressures, array), 1.0)
        assert (found.orientation, found.confidence) == (0.0, 0.0)


def test_area_of_faint_contact_is_at_least_one_tactel():
    pressures = np.zeros(256)
    pressures[[100, 101]] = 10.002, 10.001
    found = contact_features(TactileImage(pressures, ARRAYS["flat"]), 10.0)
    assert found.area == pytest.approx(1.5 * ARRAYS["flat"].area)
    assert found.pressure < 20.0


def band(array: TactileArray, angle: float) -> np.ndarray:
    """Return the pressures of a band through the origin at ``angle`` on the unrolled surface."""
    radius = 0.03
    v = radius * np.arctan2(array.positions[:, 1], array.positions[:, 2] + radius)
    across = -np.sin(angle) * array.positions[:, 0] + np.cos(angle) * v
    along = np.cos(angle) * array.positions[:, 0] + np.sin(angle) * v
    return 1000.0 * np.exp(-0.5 * ((across / 0.004) ** 2 + (along / 0.009) ** 2))


@given(st.floats(-1.5, 1.5))
def test_orientation_on_curved_patch_lies_in_tangent_plane(angle):
    array = ARRAYS["curved"]
    found = contact_features(TactileImage(band(array, angle), array), 1.0)
    gap = (found.orientation - angle + np.pi / 2) % np.pi - np.pi / 2
    assert abs(gap) < np.radians(5.0)
    assert np.allclose(found.normal, [0.0, 0.0, 1.0], atol=1e-6)


def test_contact_on_side_of_fingertip_has_sideways_normal():
    array = ARRAYS["fingertip"]
    pressures = np.zeros(12)
    pressures[[2, 5, 8]] = 800.0
    found = contact_features(TactileImage(pressures, array), 10.0)
    assert np.allclose(found.normal, array.normals[5])
    assert abs(found.orientation) == pytest.approx(np.pi / 2)
    assert found.orientation > 0
    assert found.confidence == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("columns", "rows", "angle"),
    [
        ([7] * 5, [4, 5, 6, 7, 8], np.pi / 2),
        ([4, 5, 6, 7, 8], [7] * 5, 0.0),
        ([4, 5, 6], [4, 5, 6], np.pi / 4),
        ([4, 5, 6], [6, 5, 4], -np.pi / 4),
    ],
)
def test_orientation_along_grid_is_exact_and_right_angle_is_positive(columns, rows, angle):
    pressures = np.zeros((16, 16))
    pressures[rows, columns] = 300.0
    found = contact_features(TactileImage(pressures.ravel(), ARRAYS["flat"]), 1.0)
    assert found.orientation == pytest.approx(angle, abs=1e-12)
    assert found.confidence == pytest.approx(1.0)


@given(st.floats(5e-324, 1e-300))
def test_features_of_tiny_pressures_are_finite(tiny):
    pressures = np.zeros(256)
    pressures[[40, 41, 200]] = tiny
    found = contact_features(TactileImage(pressures, ARRAYS["flat"]), 0.0)
    assert np.isfinite([found.force, found.pressure, found.orientation, *found.centre]).all()


def test_contact_at_border_is_reported():
    def probe(x: float) -> np.ndarray:
        gaps = ARRAYS["flat"].positions[:, :2] - [x, 0.001]
        return 2000.0 * np.exp(-0.5 * (gaps**2).sum(axis=1) / 0.003**2)

    inside = contact_features(TactileImage(probe(0.02), ARRAYS["flat"]), 20.0)
    outside = contact_features(TactileImage(probe(0.038), ARRAYS["flat"]), 20.0)
    assert not inside.at_border
    assert inside.border_share == 0.0
    assert outside.at_border
    assert outside.centre[0] < 0.0375


def test_dead_tactels_are_interpolated_by_distance_weighted_mean():
    array = ARRAYS["flat"]
    ends = np.tile([0.0, 4095.0], (256, 1))
    curves = fit_curves(ends, ends)
    limits = np.tile(np.array([0, 4000], np.int32), (256, 1))
    limits[[100, 117, 0, 1, 16, 17], 0] = 65536
    raw = np.arange(256, dtype=np.uint16)
    raw[50] = 4050
    pressures, states = np.empty(256), np.empty(256, np.uint8)
    read_pressures(raw, curves, limits, array.links, array.geometry, pressures, states)
    sides, corners = [99, 101, 84, 116], [83, 85, 115]
    mean = (sum(sides) + 0.5 * sum(corners)) / (4 + 1.5)
    assert pressures[100] == pytest.approx(mean)
    assert pressures[0] == 0.0
    assert pressures[50] == 4050.0
    assert states[50] == SATURATED
    assert np.flatnonzero(states == DEAD).tolist() == [0, 1, 16, 17, 100, 117]
