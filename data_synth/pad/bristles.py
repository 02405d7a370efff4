"""Static friction of the foam: columns that bend before they slide (compiled).

Each cell of the pad's force grid is a bristle: a foam column of shear stiffness G / h per area. The
sliding motion of the object bends it, and it slides where the shear stress would exceed the
friction. This is Dahl's model with exponent 0, per cell (a brush model). Cells under a low pressure
slide first, so that an object sticks, slips in part, and slides.
"""

from __future__ import annotations

from math import exp, sqrt

from numba import njit

from .foam_column import FRICTION, SHEAR_STIFFNESS, spline_weights

BEND_X, BEND_Y, RATIO, AREA, FLOW_X, FLOW_Y = 0, 1, 2, 3, 4, 5
"""Fields of a bristle: how far the object has bent it along x and y, m; shear stress over pressure
per bend, 1/m; then sums of the current step: the contact's area, m², and the force times the
sliding velocity along x and y, N m/s."""
BRISTLE_FIELDS = 6
"""Number of fields of a bristle."""
STATIC_RATIO = 1.2
"""Ratio of static to sliding friction, as of rubber-like surfaces."""
_STRIBECK_SPEED = 0.002
"""Speed over which friction falls from static to sliding, m/s."""
_SLIPPING = 0.999
"""Share of the friction limit from which a bristle counts as sliding."""


@njit(cache=True, error_model="numpy")
def friction_limit(bed, speed):
    """Return the ratio of tangential to normal force at which a bristle slides."""
    scaled = speed / _STRIBECK_SPEED
    return bed[FRICTION] * (1.0 + (STATIC_RATIO - 1.0) * exp(-scaled * scaled))


@njit(cache=True, error_model="numpy")
def bristle_force(bristles, bed, lead, x, y, push, area, slide_x, slide_y):
    """Compute the friction on a solid in one column, and add the column to the bristles' sums.

    Parameters
    ----------
    bristles
        (BRISTLE_FIELDS, rows, columns) float64; the last three sums are changed.
    bed
        (BED_FIELDS,) float64 (see :mod:`foam_column`).
    lead
        Time by which the bend is advanced, s: the time step, as the bends are those of the last
        step, plus the foam's loss time, which damps.
    x, y
        Position of the column on the pad, m.
    push
        Normal force, N.
    area
        Cross-section of the column, m².
    slide_x, slide_y
        Velocity of the solid along the pad at the column, m/s.

    Returns
    -------
    tuple of two floats
        Force along x and y, N.
    """
    rows, columns = bristles.shape[1], bristles.shape[2]
    row, column, weights_x, weights_y = spline_weights(bed, rows, columns, x, y)
    ratio_x, ratio_y, slope = 0.0, 0.0, 0.0
    for p in range(3):
        r = min(max(row + p - 1, 0), rows - 1)
        for q in range(3):
            c = min(max(column + q - 1, 0), columns - 1)
            weight = weights_y[p] * weights_x[q]
            stiff = weight * bristles[RATIO, r, c]
            ratio_x += stiff * bristles[BEND_X, r, c]
            ratio_y += stiff * bristles[BEND_Y, r, c]
            slope += stiff
            bristles[AREA, r, c] += weight * area
            bristles[FLOW_X, r, c] += weight * push * slide_x
            bristles[FLOW_Y, r, c] += weight * push * slide_y
    ratio_x += slope * lead * slide_x
    ratio_y += slope * lead * slide_y
    limit = friction_limit(bed, sqrt(slide_x * slide_x + slide_y * slide_y))
    ratio = sqrt(ratio_x * ratio_x + ratio_y * ratio_y)
    if ratio > limit:
        ratio_x, ratio_y = ratio_x * limit / ratio, ratio_y * limit / ratio
    return -push * ratio_x, -push * ratio_y


@njit(cache=True, error_model="numpy")
def bend_bristles(grid, bed, dt, bristles):
    """Bend all bristles by the motion of this step, let them slide, and clear the sums.

    Parameters
    ----------
    grid
        Force grid (3, rows, columns) float64, N, of this step.
    bed
        (BED_FIELDS,) float64.
    dt
        Time step, s; 0 straightens all bristles.
    bristles
        (BRISTLE_FIELDS, rows, columns) float64, overwritten.

    Returns
    -------
    float
        Share of the normal force on bristles that slide, 0..1.
    """
    total, slipping = 0.0, 0.0
    for r in range(bristles.shape[1]):
        for c in range(bristles.shape[2]):
            push, area = grid[0, r, c], bristles[AREA, r, c]
            if push > 0.0 and area > 0.0:
                ratio = bed[SHEAR_STIFFNESS] * area / push
                flow_x, flow_y = bristles[FLOW_X, r, c] / push, bristles[FLOW_Y, r, c] / push
                bend_x, bend_y = 0.0, 0.0
                if dt > 0.0:
                    bend_x = bristles[BEND_X, r, c] + flow_x * dt
                    bend_y = bristles[BEND_Y, r, c] + flow_y * dt
                limit = friction_limit(bed, sqrt(flow_x * flow_x + flow_y * flow_y)) / ratio
                bend = sqrt(bend_x * bend_x + bend_y * bend_y)
                if bend > limit:
                    bend_x, bend_y = bend_x * limit / bend, bend_y * limit / bend
                bristles[BEND_X, r, c], bristles[BEND_Y, r, c] = bend_x, bend_y
                bristles[RATIO, r, c] = ratio
                total += push
                slipping += push if bend > _SLIPPING * limit else 0.0
            elif bristles[RATIO, r, c] != 0.0:
                bristles[BEND_X : RATIO + 1, r, c] = 0.0
            if area > 0.0:
                bristles[AREA:, r, c] = 0.0
    return slipping / total if total > 0.0 else 0.0
