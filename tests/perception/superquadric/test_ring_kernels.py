"""Compiled search for the rim against NumPy references."""

import numpy as np
import pytest

from eyehand.perception.superquadric.ring import (
    RIM_NOISE,
    SECTOR_RANK,
    SECTORS,
    TRIM_RATIO,
    TRIMS,
    circle_through,
    rim_points,
    trimmed_circle,
)

NOISE = 0.001


def cup(seed, count=1500):
    """Return points of a cup seen from above, with noise and outliers, (N, 3), m."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-np.pi, np.pi, count)
    height = rng.uniform(0.3, 0.4, count)
    radius = 0.04 + 0.1 * (height - 0.4)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    points[: count // 50, 2] += 0.02
    return points + rng.normal(0.0, NOISE, points.shape) + [0.3, -0.2, 0.0]


def reference_rim_points(local, middle, noise):
    offset = local[:, :2] - middle
    sector = np.floor((np.arctan2(offset[:, 1], offset[:, 0]) / (2 * np.pi) + 0.5) * SECTORS)
    found = []
    for number in np.unique(sector):
        mine = local[sector == number]
        if len(mine) < SECTOR_RANK:
            continue
        top = np.sort(mine[:, 2])[-SECTOR_RANK]
        high = mine[mine[:, 2] >= top - RIM_NOISE * noise]
        found.append(high[np.argmax(np.linalg.norm(high[:, :2] - middle, axis=1))])
    return np.array(found).reshape(-1, 3)


def reference_circle(points):
    x, y, z = points.T
    rows = np.column_stack([x, y, np.ones_like(x)])
    solution, plane = np.linalg.lstsq(rows, np.column_stack([x**2 + y**2, z]), rcond=None)[0].T
    middle = 0.5 * solution[:2]
    return np.array([*middle, np.sqrt(solution[2] + middle @ middle), *plane])


@pytest.mark.parametrize("seed", range(4))
def test_kernels_equal_numpy(seed):
    points = cup(seed)
    middle = np.array([0.303, -0.198])
    highest = rim_points(points, middle, NOISE)
    assert highest == pytest.approx(reference_rim_points(points, middle, NOISE), abs=1e-15)
    assert circle_through(highest) == pytest.approx(reference_circle(highest), abs=1e-9)
    circle, kept = trimmed_circle(highest, NOISE)
    expected, mask = reference_circle(highest), np.ones(len(highest), dtype=bool)
    for _ in range(TRIMS):
        radial = np.linalg.norm(highest[:, :2] - expected[:2], axis=1) - expected[2]
        error = np.hypot(radial, highest[:, 2] - highest[:, :2] @ expected[3:5] - expected[5])
        mask = error <= TRIM_RATIO * np.median(error) + NOISE
        expected = reference_circle(highest[mask])
    assert np.array_equal(kept, mask)
    assert circle == pytest.approx(expected, abs=1e-9)


def test_points_on_a_line_have_no_circle():
    line = np.linspace(0.0, 0.1, 20)[:, None] * [1.0, 2.0, 0.5]
    assert np.isnan(circle_through(line)).all()
    circle, kept = trimmed_circle(line, NOISE)
    assert np.isnan(circle).all()
    assert kept.all()
    assert np.isnan(circle_through(np.zeros((0, 3)))).all()


def test_sectors_with_one_point_have_no_rim():
    assert len(rim_points(np.array([[0.1, 0.0, 0.0]]), np.zeros(2), NOISE)) == 0
