"""The read-out electronics: saturating characteristics, 12 bits, seeds and faults."""

import numpy as np
import pytest

from eyehand.data_synth.pad.tactile_readout import FULL_SCALE, TactileReadout
from eyehand.errors import InputError


def test_tactels_are_monotonic_with_different_characteristics() -> None:
    readout = TactileReadout.draw()
    pressures = np.geomspace(1.0, 2e4, 200)
    counts = np.array([readout.clean(np.full(256, p)) for p in pressures])
    assert (np.diff(counts, axis=0) > 0).all()
    assert np.std(counts[120]) > 50
    assert counts.max() < FULL_SCALE + 1000


def test_characteristic_equals_formula() -> None:
    readout = TactileReadout.draw(4, seed=3)
    p = np.array([0.0, 100.0, 1e3, 1e4])
    g, h = readout.exponents, readout.half_pressures
    expected = readout.offsets + readout.spans * p**g / (p**g + h**g)
    assert readout.clean(p) == pytest.approx(expected)


def test_characteristic_is_linear_at_low_and_saturates_at_high_pressure() -> None:
    readout = TactileReadout.draw()
    slope = np.diff([readout.clean(np.full(256, p)).mean() for p in (200.0, 400.0, 800.0, 1000.0)])
    slope /= [200.0, 400.0, 200.0]
    assert slope.max() < 1.15 * slope.min()
    top = np.diff([readout.clean(np.full(256, p)).mean() for p in (9e3, 1e4)])[0] / 1e3
    assert top < 0.25 * slope.min()


def test_readings_have_twelve_bits_and_are_repeatable() -> None:
    readout = TactileReadout.draw(seed=1)
    pressures = np.linspace(0, 1e6, 256)
    raw = readout.raw(pressures, np.random.default_rng(5))
    assert raw.dtype == np.uint16
    assert raw.max() <= FULL_SCALE
    assert (raw == readout.raw(pressures, np.random.default_rng(5))).all()
    assert (raw != readout.raw(pressures, np.random.default_rng(6))).any()
    assert (TactileReadout.draw(seed=1).spans == readout.spans).all()
    assert (TactileReadout.draw(seed=2).spans != readout.spans).all()


def test_noise_has_requested_standard_deviation() -> None:
    readout = TactileReadout.draw(noise=3.0)
    rng = np.random.default_rng(0)
    raw = np.array([readout.raw(np.full(256, 500.0), rng) for _ in range(200)], float)
    assert raw.std(axis=0).mean() == pytest.approx(3.0, rel=0.03)


def test_dead_and_saturated_tactels_do_not_respond() -> None:
    readout = TactileReadout.draw(dead=(3, 7), saturated=(11,))
    low, high = (readout.raw(np.full(256, p), None) for p in (0.0, 5e3))
    changed = np.flatnonzero(low != high)
    assert set(range(256)) - set(changed.tolist()) == {3, 7, 11}
    assert high[11] == FULL_SCALE
    with pytest.raises(InputError, match="faulty"):
        TactileReadout.draw(4, dead=(4,))
