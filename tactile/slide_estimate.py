"""How far a held face has slid, from the shift of the pressure and the shear (compiled).

The centre of pressure moves for three reasons: the stuck face bends the layer (bend = shear /
stiffness), friction turns the layer (height times shear over pressure), and the face slides. What
remains of its motion after the first two is the slide. The features are changes of these motions
between running means, along the shear, because friction points along the slide.
"""

from __future__ import annotations

from math import asinh, sqrt

from numba import njit

SLIDE_TIMES = (0.016, 0.064, 0.128)
"""Time constants of the running means, s. The first change is that from the newest image's mean of
4 ms to the first one."""
PARTS = 3
"""Motions in a running mean: of the centre of pressure, by the turned layer, and by its bend."""
SLIDE_FEATURES = 5 * len(SLIDE_TIMES)
"""Values per time constant: the slide along the shear, its amount, and the three motions."""
_LEVER_SHARE, _BEND_SHARE = 0.85, 1.1
"""Motions of the centre over height times ratio, and over bend: least squares over simulated grasps
without slide gave 0.82 to 0.87 and 1.05 to 1.28 for three kinds of objects."""
_SCALE_M = 1e-5
"""Motion from which features grow like a logarithm, m."""
_MIN_RATIO = 1e-3
"""Ratio of shear to pressure below which it has no direction."""


@njit(cache=True, error_model="numpy")
def slide_features(image, contact, layer, shares, means, values):
    """Enter an image into the running means, and compute the features.

    Parameters
    ----------
    image
        (3, rows, columns), Pa: pressure, and shear along x and y; a mean of 4 ms.
    contact
        (rows, columns), Pa: slow pressure. It selects the touching tactels, and weighs their bends.
    layer
        Pressure from which a tactel touches, Pa, distance of two tactels, m, shear stiffness of the
        layer, Pa/m, and its height, m.
    shares
        (len(SLIDE_TIMES),): share of an image in each running mean.
    means
        (len(SLIDE_TIMES) + 1, PARTS, 2), m, updated; the last row's first value is 0
        before they have started.
    values
        (SLIDE_FEATURES,), overwritten; m along the shear, like a logarithm.
    """
    threshold, pitch, stiffness, height = layer
    rows, columns = contact.shape
    force, weights = 0.0, 0.0
    now = means[-1]
    started = now[0, 0]
    now[:] = 0.0
    for r in range(rows):
        y = (r - 0.5 * (rows - 1)) * pitch
        for c in range(columns):
            if contact[r, c] > threshold:
                x = (c - 0.5 * (columns - 1)) * pitch
                force += image[0, r, c]
                weights += contact[r, c]
                now[0, 0] += x * image[0, r, c]
                now[0, 1] += y * image[0, r, c]
                for axis in range(2):
                    now[1, axis] += image[1 + axis, r, c]
                    now[2, axis] += contact[r, c] * image[1 + axis, r, c]
    values[:] = 0.0
    if force <= threshold:
        now[0, 0] = 0.0
        return
    now[0] /= force
    now[1] *= _LEVER_SHARE * height / force
    now[2] *= _BEND_SHARE / (weights * stiffness)
    for k in range(len(shares)):
        if started == 0.0:
            means[k] = now
        means[k] += shares[k] * (now - means[k])
    amount = sqrt(means[0, 1, 0] ** 2 + means[0, 1, 1] ** 2) + _MIN_RATIO * height
    along_x, along_y = means[0, 1, 0] / amount, means[0, 1, 1] / amount
    for k in range(len(shares)):
        step = (now if k == 0 else means[k - 1]) - means[k]
        slide_x = step[0, 0] - step[1, 0] - step[2, 0]
        slide_y = step[0, 1] - step[1, 1] - step[2, 1]
        values[5 * k] = asinh((slide_x * along_x + slide_y * along_y) / _SCALE_M)
        values[5 * k + 1] = asinh(sqrt(slide_x**2 + slide_y**2) / _SCALE_M)
        for part in range(PARTS):
            along = step[part, 0] * along_x + step[part, 1] * along_y
            values[5 * k + 2 + part] = asinh(along / _SCALE_M)
    now[0, 0] = 1.0
