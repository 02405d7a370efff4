"""What the shear of a contact says about stuck and sliding cells (compiled).

The shear of a stuck cell bends the layer: bend = shear / stiffness. A stuck face moves all bends
like one rigid body. Cells that have slid lag behind that motion, and their shear hangs at the
friction times their pressure. The features compare the bends with the rigid motion that fits them
best, twice: with the pressure as weight, and with its cube, as cells under a high pressure slide
last.
"""

from __future__ import annotations

from math import asinh, sqrt

from numba import njit

PATTERN_FEATURES = 11
"""Values per image: lag, residual and motion of both fits, m; then the mean ratio of shear to
pressure, its spread as a share, the misfit of a shear like the pressure, 0..1, the total over the
sum of the amounts, 0..1, and the ratio of total shear to total pressure."""
_LENGTHS = 6
"""Number of values that are lengths."""
_SCALES_M = (1e-5, 2e-6, 5e-6)
"""Lengths from which features of a pattern, and of its changes within 1 to 4 and 4 to 16 ms, grow
like a logarithm, m."""
_TINY = 1e-12
_MIN_MOTION = 1e-7
"""Rigid motion below which the lag has no direction, m."""


@njit(cache=True, error_model="numpy")
def shear_pattern(image, contact, threshold, pitch, stiffness, out):
    """Compute the features of one image's shear.

    Parameters
    ----------
    image
        (3, rows, columns), Pa: pressure, and shear along x and y.
    contact
        (rows, columns), Pa: slow pressure. It selects the touching tactels, and weighs them.
    threshold
        Pressure from which a tactel touches, Pa.
    pitch
        Distance of two tactels, m.
    stiffness
        Shear stiffness of the layer, Pa/m.
    out
        (PATTERN_FEATURES,), overwritten.
    """
    out[:] = 0.0
    for cubed in range(2):
        _rigid_fit(image, contact, threshold, pitch, stiffness, cubed == 1, out[3 * cubed :])
    push, amount, square, like, pushes = 0.0, 0.0, 0.0, 0.0, 0.0
    total_x, total_y, ratios = 0.0, 0.0, 0.0
    for r in range(contact.shape[0]):
        for c in range(contact.shape[1]):
            pressure = contact[r, c]
            if pressure <= threshold:
                continue
            shear = sqrt(image[1, r, c] ** 2 + image[2, r, c] ** 2)
            push += pressure
            amount += shear
            square += shear * shear
            like += shear * pressure
            pushes += pressure * pressure
            ratios += shear * shear / pressure
            total_x += image[1, r, c]
            total_y += image[2, r, c]
    if push <= 0.0 or amount <= 0.0:
        return
    mean, total = amount / push, sqrt(total_x * total_x + total_y * total_y)
    out[6] = mean
    out[7] = sqrt(max(ratios / push - mean * mean, 0.0)) / (mean + _TINY)
    out[8] = 1.0 - like * like / (square * pushes + _TINY)
    out[9] = total / amount
    out[10] = total / push


@njit(cache=True, error_model="numpy")
def pattern_features(patterns, scale, values):
    """Compute the features of the middle one of three running means, and of its changes.

    Parameters
    ----------
    patterns
        (3, PATTERN_FEATURES), of the means of 1, 4 and 16 ms.
    scale
        Change of a value without unit from which features grow like a logarithm.
    values
        (3 PATTERN_FEATURES,), overwritten.
    """
    for k in range(PATTERN_FEATURES):
        now = patterns[1, k]
        first, later = patterns[0, k] - now, now - patterns[2, k]
        if k < _LENGTHS:
            values[3 * k] = asinh(now / _SCALES_M[0])
            values[3 * k + 1] = asinh(first / _SCALES_M[1])
            values[3 * k + 2] = asinh(later / _SCALES_M[2])
        else:
            values[3 * k] = now
            values[3 * k + 1], values[3 * k + 2] = asinh(first / scale), asinh(later / scale)


@njit(cache=True, error_model="numpy")
def _rigid_fit(image, contact, threshold, pitch, stiffness, cubed, out):
    """Fit a rigid motion to the bends; set its lag, residual and size, m: means by pressure."""
    rows, columns = contact.shape
    weights, at_x, at_y, move_x, move_y = 0.0, 0.0, 0.0, 0.0, 0.0
    for r in range(rows):
        for c in range(columns):
            if contact[r, c] > threshold:
                weight = contact[r, c] ** 3 if cubed else contact[r, c]
                weights += weight
                at_x += weight * c
                at_y += weight * r
                move_x += weight * image[1, r, c]
                move_y += weight * image[2, r, c]
    if weights <= 0.0:
        return
    at_x, at_y = at_x / weights, at_y / weights
    move_x, move_y = move_x / (weights * stiffness), move_y / (weights * stiffness)
    turn, spread = 0.0, 0.0
    for r in range(rows):
        for c in range(columns):
            if contact[r, c] > threshold:
                weight = contact[r, c] ** 3 if cubed else contact[r, c]
                x, y = (c - at_x) * pitch, (r - at_y) * pitch
                turn += weight * (x * image[2, r, c] - y * image[1, r, c])
                spread += weight * (x * x + y * y)
    turn /= stiffness * (spread + _TINY)
    push, lag, rest, size = 0.0, 0.0, 0.0, 0.0
    for r in range(rows):
        for c in range(columns):
            pressure = contact[r, c]
            if pressure <= threshold:
                continue
            rigid_x = move_x - turn * (r - at_y) * pitch
            rigid_y = move_y + turn * (c - at_x) * pitch
            left_x = rigid_x - image[1, r, c] / stiffness
            left_y = rigid_y - image[2, r, c] / stiffness
            motion = sqrt(rigid_x * rigid_x + rigid_y * rigid_y) + _MIN_MOTION
            push += pressure
            lag += pressure * (left_x * rigid_x + left_y * rigid_y) / motion
            rest += pressure * (left_x * left_x + left_y * left_y)
            size += pressure * motion
    out[0], out[1], out[2] = lag / push, sqrt(rest / push), size / push
