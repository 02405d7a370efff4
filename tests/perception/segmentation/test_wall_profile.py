"""Tests of the loops over the readings around a container, against NumPy."""

import numpy as np
import pytest

from eyehand.perception.segmentation.wall_profile import (
    MIN_SLANT,
    face_distances,
    inside_polygon,
    outermost_run,
    read_strip,
    read_window,
)

CORNERS = np.array([[0.0, 0.0], [0.4, 0.05], [0.35, 0.3], [-0.05, 0.25]])


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def test_window_gives_plan_heights_and_areas(rng):
    depth = rng.uniform(0.5, 1.0, (12, 17)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.3] = 0.0
    rays = np.linspace(-0.3, 0.3, 17), np.linspace(-0.2, 0.2, 12)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    plan, heights, areas, pixels = read_window(depth, rays, axes, 0.7, 1e-6)
    v, u = np.nonzero(depth)
    z = depth[v, u].astype(np.float64)
    directions = np.column_stack([rays[0][u], rays[1][v], np.ones(len(u))])
    points = directions * z[:, None]
    assert np.array_equal(pixels, v * 17 + u)
    np.testing.assert_allclose(plan, points @ axes[1:].T, atol=1e-12)
    np.testing.assert_allclose(heights, points @ axes[0] + 0.7, atol=1e-12)
    slant = np.maximum(-(directions @ axes[0]), MIN_SLANT)
    np.testing.assert_allclose(areas, 1e-6 * z**2 / slant, rtol=1e-12)


@pytest.mark.parametrize("margin", [-0.02, 0.0, 0.03])
def test_points_inside_a_polygon(rng, margin):
    plan = rng.uniform(-0.2, 0.5, (500, 2))
    along = np.roll(CORNERS, -1, axis=0) - CORNERS
    along /= np.linalg.norm(along, axis=1)[:, None]
    inwards = np.column_stack([-along[:, 1], along[:, 0]])
    distance = (plan @ inwards.T - np.einsum("ij,ij->i", inwards, CORNERS)).min(axis=1)
    assert np.array_equal(inside_polygon(plan, CORNERS, margin), distance > margin)


def test_strip_gives_the_highest_readings_of_each_cell(rng):
    plan, heights = rng.uniform(-0.1, 0.6, (2000, 2)), rng.uniform(0.0, 0.2, 2000)
    start, along, length = np.array([0.05, 0.1]), np.array([0.8, 0.6]), 0.4
    corner, reach, place, cell = 0.03, 0.05, 0.02, 0.004
    readings, places, profile = read_strip(
        plan, heights, (start, along, length), (0.02, 0.15), (corner, reach, place, cell)
    )
    s, d = (plan - start) @ along, (plan - start) @ np.array([along[1], -along[0]])
    kept = (s > corner) & (s < length - corner) & (np.abs(d) < reach)
    kept &= (heights > 0.02) & (heights <= 0.15)
    np.testing.assert_allclose(readings, np.column_stack([s, d, heights])[kept], atol=1e-15)
    count = int((length - 2 * corner) / place)
    expected = np.minimum(((s[kept] - corner) / place).astype(int), count - 1)
    assert np.array_equal(places, expected)
    highest = np.full((count, int(2 * reach / cell) + 1), -np.inf)
    np.maximum.at(highest, (expected, ((d[kept] + reach) / cell).astype(int)), heights[kept])
    assert np.array_equal(profile, highest)


def test_outermost_run_ignores_single_gaps_and_what_lies_farther_inside():
    level = 0.5
    rows = ["0110111000", "1100000000", "0000000000", "1111111111", "1001000000"]
    profile = np.array([[float(cell) for cell in row] for row in rows])
    inner, outer = outermost_run(profile, level)
    assert inner.tolist() == [1, 0, 10, 0, 3]
    assert outer.tolist() == [7, 2, 10, 10, 4]


def test_face_is_the_outermost_reading_of_each_band(rng):
    readings = np.column_stack(
        [rng.uniform(0, 0.4, 800), rng.uniform(-0.05, 0.05, 800), rng.uniform(-0.01, 0.12, 800)]
    )
    places = rng.integers(0, 9, 800)
    floor, top, bands = 0.0, 0.1, 5
    found = face_distances(readings, places, (0.05, 0.01), (0.004, 0.09), (bands, 9, floor, top))
    s, d, heights = readings.T
    across = d - 0.01 - 0.05 * s
    inside = (across < 0.004) & (heights < 0.09)
    band = np.clip(((heights - floor) / (top - floor) * bands).astype(int), 0, bands - 1)
    expected = np.full((bands, 9), -np.inf)
    np.maximum.at(expected, (band[inside], places[inside]), across[inside])
    assert np.array_equal(found, expected)
