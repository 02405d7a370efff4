"""Pressure under a sheared layer of foam (compiled)."""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def base_forces(grid, lever, cell_x, cell_y, base):
    """Compute the normal forces under the layer from the forces on top of it.

    Shear stress on top turns the layer, and the base bears the moment: the base pressure is
    p - h div(tau). So a tangential force Ft moves the centre of pressure by h Ft / Fn. Differences
    are central, and one-sided at the border, so that sum and moment are exact.

    Parameters
    ----------
    grid
        Forces on top of the layer, (3, rows, columns) float64, N: normal, along x, along y.
    lever
        Height h over which the layer turns, m.
    cell_x, cell_y
        Width of a grid cell along x and along y, m.
    base
        (3, rows, columns) float64, overwritten: the forces under the layer, N. Normal forces are
        negative where the layer pulls.
    """
    rows, columns = grid.shape[1], grid.shape[2]
    base[:] = grid
    for r in range(rows):
        for c in range(columns):
            along_x, along_y = grid[1, r, c], grid[2, r, c]
            if along_x != 0.0:
                low, high = max(c - 1, 0), min(c + 1, columns - 1)
                if high > low:
                    moved = lever * along_x / ((high - low) * cell_x)
                    base[0, r, high] += moved
                    base[0, r, low] -= moved
            if along_y != 0.0:
                low, high = max(r - 1, 0), min(r + 1, rows - 1)
                if high > low:
                    moved = lever * along_y / ((high - low) * cell_y)
                    base[0, high, c] += moved
                    base[0, low, c] -= moved
