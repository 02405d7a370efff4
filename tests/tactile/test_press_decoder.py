"""Decoder and memory fitted from presses that are made here, without the simulated pad."""

from typing import Any

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile import (
    FoamMemory,
    MemoryFilter,
    TactileArray,
    fit_creep,
    fit_decoder,
    fit_memory,
)

ARRAY = TactileArray.flat(8, 10, 0.004)
SCALE = 0.0012


def presses():
    """Return gains, and presses of a pad whose point response is exponential, not Gaussian."""
    rng = np.random.default_rng(0)
    gains = np.exp(0.1 * rng.standard_normal(80))
    depths = np.linspace(2e-4, 2e-3, 8)
    plates = 3e6 * depths[:, None] * gains
    places = rng.uniform([-0.012, -0.008], [0.012, 0.008], (60, 2))
    fine = ((np.arange(20) + 0.5) / 20 - 0.5) * 0.004
    square = np.stack(np.meshgrid(fine, fine), axis=-1).reshape(-1, 2)
    points = ARRAY.positions[:, None, :2] + square
    distances = np.linalg.norm(points[None] - places[:, None, None], axis=-1)
    spread = np.exp(-distances / SCALE).mean(axis=2) / (2 * np.pi * SCALE**2)
    return gains, (ARRAY, plates, depths, 0.05 * spread * gains, places, 0.0)


def test_gains_response_and_depths_are_found():
    gains, record = presses()
    decoder = fit_decoder(*record)
    assert decoder.gains / gains == pytest.approx(np.median(decoder.gains / gains), rel=1e-6)
    assert decoder.residual < 0.03
    assert decoder.depth(record[1].mean(axis=1)) == pytest.approx(record[2], rel=0.05)
    line = np.abs(ARRAY.positions[:, 0] - 0.002) < 1e-6
    restored = decoder.deconvolve(np.where(line, 2000.0, 0.0) * decoder.gains)
    assert restored.shape == (16, 20)
    assert (restored[4:-4].argmax(axis=1) // 2 == 5).all(), "column 5 is at 2 mm"


@pytest.mark.parametrize(
    ("number", "change", "match"),
    [
        (1, lambda v: v[:2], "plate images"),
        (1, lambda v: v * np.r_[0.0, np.ones(79)], "do not respond"),
        (1, lambda v: v[::-1], "increase"),
        (2, lambda v: -v, "depths of the punch"),
        (3, lambda v: v * 0.0, "are empty"),
        (3, lambda v: v * np.nan, "finite"),
        (4, lambda v: v[:5], "at least 20 needle"),
        (2, lambda v: 1e3 * v, "at most 0.1, got 2$"),
        (4, lambda v: 1e3 * v, r"x from -0.0240 to 0.0240 and .* in press 0"),
        (4, lambda v: v * 0.0, "between four tactels"),
        (5, lambda v: -1.0, "radius"),
        (5, lambda v: 1.0, "radius must be 0 to 0.012 m"),
        (0, lambda v: TactileArray.fingertip(), "flat pad"),
    ],
)
def test_bad_presses_are_refused(number, change, match):
    record: list[Any] = list(presses()[1])
    record[number] = change(record[number])
    with pytest.raises(InputError, match=match):
        fit_decoder(*record)


def test_one_place_that_is_not_between_four_tactels_determines_the_response():
    _, (array, plates, depths, needles, places, radius) = presses()
    images, beside = np.tile(needles[0], (20, 1)), np.tile(places[0], (20, 1))
    one = fit_decoder(array, plates, depths, images, beside, radius)
    many = fit_decoder(array, plates, depths, needles, places, radius)
    found, expected = one.deconvolve(needles[1]), many.deconvolve(needles[1])
    assert np.abs(found - expected).max() < 0.1 * expected.max()


def test_memory_is_fitted_and_removed():
    loaded, times = np.full(5, 4000.0), np.linspace(0.01, 4.0, 400)
    memory = fit_memory(loaded, 480.0 * np.exp(-times / 1.5)[:, None] * np.ones(5), times)
    assert memory.share == pytest.approx(0.12, abs=1e-6)
    assert memory.recovery == pytest.approx(1.5, abs=1e-6)
    corrected = MemoryFilter(memory)
    assert (corrected.correct(loaded, 0.01) == loaded).all()
    assert (corrected.correct(480.0 * np.exp(-0.01 / 1.5) * np.ones(5), 0.01) == 0.0).all()
    half = 0.88 * 2000.0 + 0.12 * (2000.0 + 2000.0 * np.exp(-0.02 / 1.5))
    fresh = MemoryFilter(memory)
    fresh.correct(loaded, 0.02)
    assert fresh.correct(np.full(5, half), 0.02) == pytest.approx(2000.0)


def test_the_memory_of_a_saturated_tactel_is_no_contact():
    memory, full = FoamMemory(0.1, 2.0), np.full(2, 12e3)
    corrected = MemoryFilter(memory)
    # A load of 80 kPa reads 12 kPa, and leaves a memory of 8 kPa.
    assert (corrected.correct(full, 0.01, full > 11e3) == full).all()
    assert (corrected.correct(np.full(2, 8e3), 0.01, np.zeros(2, bool)) == 0.0).all()
    without = MemoryFilter(memory)
    without.correct(full, 0.01)
    assert (without.correct(np.full(2, 8e3), 0.01) > 7e3).all()


def test_creep_is_fitted_and_removed():
    times = np.linspace(0.05, 8.0, 400)
    held = (1.0 + 0.15 * (1.0 - np.exp(-times / 5.0)))[:, None] * np.full(5, 4000.0)
    memory = fit_creep(FoamMemory(0.1, 2.0), held, times)
    assert (memory.share, memory.recovery) == (0.1, 2.0)
    assert (memory.creep, memory.creep_time) == pytest.approx((0.15, 5.0))
    assert fit_creep(memory, np.full((400, 5), 4000.0), times) is memory
    removed, crept, fall = MemoryFilter(FoamMemory(0.0, 1.0, 0.15, 5.0)), 0.0, np.exp(-0.01 / 5.0)
    for load in np.repeat([0.0, 4000.0, 2000.0, 0.0], 400):
        crept = load + (crept - load) * fall
        assert removed.correct(np.full(5, load + 0.15 * crept), 0.01) == pytest.approx(load)
    assert crept > 900.0


def test_pad_without_memory_stays_as_it_is():
    times = np.array([0.1, 0.2, 0.3])
    memory = fit_memory(np.full(5, 4000.0), np.zeros((3, 5)), times)
    assert memory == FoamMemory(0.0, 1.0)
    image = np.array([3.0, 1.0])
    assert MemoryFilter(memory).correct(image, 0.1) is image


def test_bad_releases_are_refused():
    loaded, times = np.full(5, 4000.0), np.array([0.1, 0.2, 0.3])
    with pytest.raises(InputError, match="at least 3"):
        fit_memory(loaded, np.zeros((2, 5)), times)
    with pytest.raises(InputError, match="does not fade"):
        fit_memory(loaded, np.full((3, 5), 400.0), times)
    with pytest.raises(InputError, match="increase"):
        fit_memory(loaded, np.zeros((3, 5)), times[::-1])
    with pytest.raises(InputError, match="must have pressure"):
        fit_memory(0 * loaded, np.zeros((3, 5)), times)
    with pytest.raises(InputError, match="finite"):
        fit_memory(loaded * np.nan, np.zeros((3, 5)), times)
    with pytest.raises(InputError, match="held press"):
        fit_creep(FoamMemory(0.1, 2.0), np.zeros((3, 5)), times)
