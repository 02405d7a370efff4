"""Pressure under a sheared layer: sum, moment, and the discrete divergence in NumPy."""

import numpy as np
import pytest

from eyehand.data_synth.pad.layer_shear import base_forces

CELL_X, CELL_Y, THICKNESS = 0.0025, 0.002, 0.004


def test_sum_is_kept_and_moment_is_lever_times_force() -> None:
    rng = np.random.default_rng(0)
    grid = rng.normal(size=(3, 14, 9))
    base = np.empty_like(grid)
    base_forces(grid, THICKNESS, CELL_X, CELL_Y, base)
    x, y = CELL_X * np.arange(9), CELL_Y * np.arange(14)
    change = base[0] - grid[0]
    assert change.sum() == pytest.approx(0.0, abs=1e-9)
    assert change.sum(axis=0) @ x == pytest.approx(THICKNESS * grid[1].sum())
    assert change.sum(axis=1) @ y == pytest.approx(THICKNESS * grid[2].sum())
    assert (base[1:] == grid[1:]).all()


def test_inside_the_change_is_the_divergence() -> None:
    rng = np.random.default_rng(1)
    grid = np.zeros((3, 14, 9))
    grid[1:, 2:-2, 2:-2] = rng.normal(size=(2, 10, 5))
    base = np.empty_like(grid)
    base_forces(grid, THICKNESS, CELL_X, CELL_Y, base)
    divergence = np.gradient(grid[1], CELL_X, axis=1) + np.gradient(grid[2], CELL_Y, axis=0)
    assert base[0] == pytest.approx(grid[0] - THICKNESS * divergence, abs=1e-12)


def test_single_row_does_not_move() -> None:
    grid = np.ones((3, 1, 5))
    base = np.empty_like(grid)
    base_forces(grid, THICKNESS, CELL_X, CELL_Y, base)
    assert base[0].sum() == pytest.approx(5.0)
    assert np.isfinite(base).all()
