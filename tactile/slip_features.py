"""Features of a tactile image sequence that show slip (compiled).

Each image enters three running means of 1, 4 and 16 ms. Their differences are the changes of the
last 1 to 4 and 4 to 16 ms. From these come:

- the change of force, and of centre of pressure, spread and rim share;
- the change of the pattern that neither another force nor a shifted centre explains. Cells at the
  rim slide first, so that partial slip changes the pattern;
- the energy above 1 ms: vibrations;
- with a shear array: ratio of tangential to normal force, its change along its direction, how
  well the change of shear fits that of a stuck contact (even) and of a sliding one (like the
  pressure), what the shear itself says about sliding cells (:mod:`shear_pattern`), and how far the
  face has slid (:mod:`slide_estimate`).

No feature depends on the direction of the load. Lengths are in units near the noise's.
"""

from __future__ import annotations

from math import asinh, sqrt

import numpy as np
from numba import njit

from .shear_pattern import PATTERN_FEATURES, pattern_features, shear_pattern
from .slide_estimate import PARTS, SLIDE_FEATURES, SLIDE_TIMES, slide_features

PRESSURE_FEATURES, CHANGE_FEATURES = 15, 13
SHEAR_FEATURES = CHANGE_FEATURES + 3 * PATTERN_FEATURES + SLIDE_FEATURES
"""Number of features of the pressures alone, and further ones of the shear."""
FEATURES = PRESSURE_FEATURES + SHEAR_FEATURES
BANDS = 3
CHANNELS = 3
"""Pressure, and shear along x and y."""
BAND_TIMES = (0.001, 0.004, 0.016)
"""Time constants of the running means, s."""
SLOW_TIME = 0.064
"""Time constant of the reference of the centre of pressure, s."""
_ENERGY_TIME = 0.004
"""Time constant of the energies of vibration, s."""
CONTACT_SIGMAS = 4.0
"""Pressure from which a tactel touches, in standard deviations of the noise."""
_SCALE = 1e-3
"""Change, as a share, from which features grow like a logarithm: near the noise."""
_TINY = 1e-12


class SlipState:
    """Running means of one array's images.

    Parameters
    ----------
    rows, columns
        Size of the array.
    pitch
        Distance of two tactels, m.
    noise
        Standard deviation of a pressure at rest, Pa.
    period
        Time between two images, s.
    shear_stiffness
        Shear stiffness of the layer, Pa/m; that of a 4 mm layer of a pad for 20 kPa by default.
    height
        Height of the layer, m.
    """

    def __init__(
        self,
        rows: int,
        columns: int,
        pitch: float,
        noise: float,
        period: float,
        shear_stiffness: float = 3e6,
        height: float = 0.004,
    ) -> None:
        self.size = (rows, columns)
        self.pitch, self.threshold = pitch, CONTACT_SIGMAS * noise
        self._layer = (self.threshold, pitch, shear_stiffness, height)
        self.shares = np.array(
            [1 - np.exp(-period / t) for t in (*BAND_TIMES, SLOW_TIME, _ENERGY_TIME)]
        )
        self.means = np.zeros((BANDS, CHANNELS, rows, columns))
        self.slow = np.zeros(5)
        self.values = np.zeros(FEATURES)
        self._slides = np.zeros((len(SLIDE_TIMES) + 1, PARTS, 2))
        self._slide_shares = np.array([1 - np.exp(-period / t) for t in SLIDE_TIMES])
        self._frame = np.zeros((CHANNELS, rows, columns))
        self._started = False

    def update(self, pressures: np.ndarray, shear: np.ndarray | None = None) -> np.ndarray:
        """Enter an image, and return the features, (FEATURES,); overwritten by the next call.

        Parameters
        ----------
        pressures
            (N,), Pa.
        shear
            (N, 2), Pa; the shear features are 0 without it.
        """
        frame = self._frame
        frame[0] = pressures.reshape(self.size)
        if shear is not None:
            frame[1] = shear[:, 0].reshape(self.size)
            frame[2] = shear[:, 1].reshape(self.size)
        if not self._started:
            self.means[:] = frame
            self._started = True
        layer = self._layer
        slip_features(frame, self.shares, layer[:3], self.means, self.slow, self.values)
        if shear is not None:
            contact, slide_values = self.means[BANDS - 1, 0], self.values[-SLIDE_FEATURES:]
            slide_features(
                self.means[1], contact, layer, self._slide_shares, self._slides, slide_values
            )
        return self.values


@njit(cache=True, error_model="numpy")
def slip_features(frame, shares, layer, means, slow, values):
    """Compute the features of an image, and enter it into the running means.

    Parameters
    ----------
    frame
        (3, rows, columns), Pa: pressure, and shear along x and y.
    shares
        (5,): share of an image in each running mean, in the slow centre, and in the energies.
    layer
        Pressure from which a tactel touches, Pa, distance of two tactels, m, and shear stiffness,
        Pa/m.
    means
        (BANDS, 3, rows, columns), updated.
    slow
        (5,), updated: the slow centre x and y, m, the energies of vibration of tactels and centre,
        and whether there is a slow centre.
    values
        (FEATURES,), overwritten.
    """
    threshold, pitch, stiffness = layer
    values[:] = 0.0
    for band in range(BANDS):
        means[band] += shares[band] * (frame - means[band])
    sums = np.empty((BANDS + 1, 6))
    for band in range(BANDS):
        _summary(means[band], means[BANDS - 1, 0], threshold, pitch, sums[band])
    _summary(frame, means[BANDS - 1, 0], threshold, pitch, sums[BANDS])
    force = sums[BANDS - 1, 0]
    if force <= threshold:
        slow[:] = 0.0
        return
    if slow[4] == 0.0:
        slow[0], slow[1], slow[4] = sums[2, 1], sums[2, 2], 1.0
    slow[0] += shares[3] * (sums[2, 1] - slow[0])
    slow[1] += shares[3] * (sums[2, 2] - slow[1])
    _pressure_changes(sums, slow, pitch, values)
    for band in range(2):
        change, rest = _pattern_change(means[band], means[band + 1], threshold)
        values[9 + band] = _scaled(change)
        values[11 + band] = _scaled(rest)
    energy = 0.0
    for r in range(frame.shape[1]):
        for c in range(frame.shape[2]):
            if means[2, 0, r, c] > threshold:
                energy += (frame[0, r, c] - means[0, 0, r, c]) ** 2
    moved = (sums[3, 1] - sums[0, 1]) ** 2 + (sums[3, 2] - sums[0, 2]) ** 2
    slow[2] += shares[4] * (energy / (force * force) - slow[2])
    slow[3] += shares[4] * (moved / (pitch * pitch) - slow[3])
    values[13], values[14] = _scaled(sqrt(slow[2])), _scaled(sqrt(slow[3]))
    _shear_changes(means, sums, threshold, pitch, values)
    if values[PRESSURE_FEATURES] > 0.0:
        patterns = np.empty((BANDS, PATTERN_FEATURES))
        for band in range(BANDS):
            shear_pattern(means[band], means[2, 0], threshold, pitch, stiffness, patterns[band])
        pattern_features(patterns, _SCALE, values[PRESSURE_FEATURES + CHANGE_FEATURES :])


@njit(cache=True, error_model="numpy")
def _scaled(share):
    return asinh(share / _SCALE)


@njit(cache=True, error_model="numpy")
def _summary(image, contact, threshold, pitch, out):
    """Compute force, centre (m), spread (m), rim share and friction moment (Pa m) of an image."""
    rows, columns = contact.shape
    total, at_x, at_y, square, rim = 0.0, 0.0, 0.0, 0.0, 0.0
    for r in range(rows):
        y = (r - 0.5 * (rows - 1)) * pitch
        for c in range(columns):
            if contact[r, c] <= threshold:
                continue
            x = (c - 0.5 * (columns - 1)) * pitch
            pressure = image[0, r, c]
            total += pressure
            at_x += x * pressure
            at_y += y * pressure
            square += (x * x + y * y) * pressure
            if (
                r == 0
                or c == 0
                or r == rows - 1
                or c == columns - 1
                or contact[r - 1, c] <= threshold
                or contact[r + 1, c] <= threshold
                or contact[r, c - 1] <= threshold
                or contact[r, c + 1] <= threshold
            ):
                rim += pressure
    out[:] = 0.0
    if total <= threshold:
        return
    at_x, at_y = at_x / total, at_y / total
    out[0], out[1], out[2] = total, at_x, at_y
    out[3] = sqrt(max(square / total - at_x * at_x - at_y * at_y, 0.0))
    out[4] = rim / total
    for r in range(rows):
        y = (r - 0.5 * (rows - 1)) * pitch - at_y
        for c in range(columns):
            if contact[r, c] > threshold:
                x = (c - 0.5 * (columns - 1)) * pitch - at_x
                out[5] += x * image[2, r, c] - y * image[1, r, c]


@njit(cache=True, error_model="numpy")
def _pressure_changes(sums, slow, pitch, values):
    """Compute the changes of force, centre, spread and rim share."""
    force = sums[2, 0]
    first_x, first_y = sums[0, 1] - sums[1, 1], sums[0, 2] - sums[1, 2]
    later_x, later_y = sums[1, 1] - sums[2, 1], sums[1, 2] - sums[2, 2]
    past_x, past_y = sums[2, 1] - slow[0], sums[2, 2] - slow[1]
    first, later = sqrt(first_x**2 + first_y**2), sqrt(later_x**2 + later_y**2)
    past = sqrt(past_x**2 + past_y**2)
    values[0] = _scaled((sums[0, 0] - sums[1, 0]) / force)
    values[1] = _scaled((sums[1, 0] - sums[2, 0]) / force)
    values[2], values[3] = _scaled(first / pitch), _scaled(later / pitch)
    values[4] = _scaled(past / pitch)
    along = (first_x * later_x + first_y * later_y) / (later + _TINY)
    values[5] = _scaled(along / pitch)
    along = (later_x * past_x + later_y * past_y) / (past + _TINY)
    values[6] = _scaled(along / pitch)
    values[7] = _scaled((sums[1, 3] - sums[2, 3]) / pitch)
    values[8] = _scaled(sums[1, 4] - sums[2, 4])


@njit(cache=True, error_model="numpy")
def _pattern_change(newer, older, threshold):
    """Return the change of a pattern, and its part that no force and no shift explains, as shares.

    The explaining patterns are the pressure itself and its slopes along x and y.
    """
    rows, columns = newer.shape[1], newer.shape[2]
    normal = np.zeros((4, 4))
    row = np.zeros(4)
    for r in range(1, rows - 1):
        for c in range(1, columns - 1):
            if older[0, r, c] <= threshold:
                continue
            row[0] = older[0, r, c]
            row[1] = 0.5 * (older[0, r, c + 1] - older[0, r, c - 1])
            row[2] = 0.5 * (older[0, r + 1, c] - older[0, r - 1, c])
            row[3] = newer[0, r, c] - older[0, r, c]
            for i in range(4):
                for j in range(4):
                    normal[i, j] += row[i] * row[j]
    total, change = normal[0, 0], normal[3, 3]
    rest = max(_remainder(normal), 0.0)
    return sqrt(change / (total + _TINY)), sqrt(rest / (total + _TINY))


@njit(cache=True, error_model="numpy")
def _remainder(normal):
    """Eliminate all but the last unknown of normal equations in place; return what remains of it.

    This is the squared residual of the last column after a least-squares fit of the others.
    """
    last = normal.shape[0] - 1
    for k in range(last):
        pivot = normal[k, k]
        if pivot <= _TINY:
            continue
        for i in range(k + 1, last + 1):
            factor = normal[i, k] / pivot
            for j in range(k, last + 1):
                normal[i, j] -= factor * normal[k, j]
    return normal[last, last]


@njit(cache=True, error_model="numpy")
def _shear_changes(means, sums, threshold, pitch, values):
    """Compute ratio, moment and changes of the shear, and its fits of a stuck and sliding face."""
    force, at = sums[2, 0], PRESSURE_FEATURES
    total = np.zeros((BANDS, 2))
    contact = means[BANDS - 1, 0]
    for band in range(BANDS):
        for r in range(contact.shape[0]):
            for c in range(contact.shape[1]):
                if contact[r, c] > threshold:
                    total[band, 0] += means[band, 1, r, c]
                    total[band, 1] += means[band, 2, r, c]
    ratio = sqrt(total[1, 0] ** 2 + total[1, 1] ** 2) / force
    slow_ratio = sqrt(total[2, 0] ** 2 + total[2, 1] ** 2) / force
    if ratio == 0.0:
        return
    values[at] = ratio
    unit = (total[2, 0] / (slow_ratio * force + _TINY), total[2, 1] / (slow_ratio * force + _TINY))
    reach = pitch * force
    values[at + 1] = abs(sums[1, 5]) / reach
    for band in range(2):
        step_x = (total[band, 0] - total[band + 1, 0]) / force
        step_y = (total[band, 1] - total[band + 1, 1]) / force
        values[at + 2 + band] = _scaled(sqrt(step_x**2 + step_y**2))
        values[at + 4 + band] = _scaled(step_x * unit[0] + step_y * unit[1])
        turn = (sums[band, 5] - sums[band + 1, 5]) / reach
        values[at + 6 + band] = _scaled(abs(turn))
        change, even, like = _shear_fits(means[band], means[band + 1], contact, threshold)
        values[at + 8 + band] = _scaled(change)
        values[at + 10 + band] = sqrt(even) - sqrt(like)
    values[at + 12] = values[at] - slow_ratio


@njit(cache=True, error_model="numpy")
def _shear_fits(newer, older, contact, threshold):
    """Return the change of shear as a share of the pressure, and what two fits leave of it.

    The fits are an even change and one like the pressure.
    """
    square, change, even, like = 0.0, 0.0, 0.0, 0.0
    for channel in (1, 2):
        count, square = 0.0, 0.0
        plain, weighted = 0.0, 0.0
        for r in range(contact.shape[0]):
            for c in range(contact.shape[1]):
                if contact[r, c] > threshold:
                    step = newer[channel, r, c] - older[channel, r, c]
                    pressure = contact[r, c]
                    count += 1.0
                    square += pressure * pressure
                    plain += step
                    weighted += step * pressure
                    change += step * step
        even += plain * plain / max(count, 1.0)
        like += weighted * weighted / (square + _TINY)
    total = change + _TINY
    return (
        sqrt(change / (square + _TINY)),
        max(1.0 - even / total, 0.0),
        max(1.0 - like / total, 0.0),
    )
