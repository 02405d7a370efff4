"""A decoder of tactile images, fitted from presses of a flat punch and a needle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import nnls
from scipy.sparse import csr_array

from eyehand.errors import InputError

from .image import TactileArray

CELLS_PER_TACTEL = 2
"""Cells of the decoded image per tactel, along x and along y."""
ROUNDS = 10
"""Number of deconvolution rounds. After 5 a ridge is still too low, 30 do not improve the result,
and from 100 on noise appears as spikes."""
FLOOR = 5.0
"""Offset added to measured and predicted pressure before their division, Pa. Without it, the ratio
of small pressures would be noise."""
KNOTS_PER_PITCH, REACH = 4, 3.0
"""Knots of the fitted response per pitch, and the distance at which it ends, pitches."""
MIN_PRESSES = 20
"""Minimum number of needle presses: each knot of the response then lies in several images."""
MAX_DEPTH = 0.1
"""Maximum depth of a press, m: foams of pads are thinner. Depths in mm exceed it."""
MAX_BESIDE = 1.5
"""Maximum distance of a needle from the middles of the outermost tactels, pitches. It is then one
pitch beside the pad, and still in reach of several tactels."""
MIN_RANK, RANK_SHARE = 6, 0.01
"""Minimum number of singular values of the needle's places, and the share of the greatest one from
which they count. Presses between four tactels give 5. The predicted images of other places are then
12 to 21 % off. A single other place gives 6 or more, and is at most 5 % off."""
_FINE = 6
"""Sample points of a tactel along each side, over which its response is averaged."""
_SMOOTHING = 0.02
"""Weight of the response's second differences beside the images."""


@dataclass(frozen=True)
class PressDecoder:
    """Properties of a pad from presses: gain of each tactel, spread of a point force, stiffness.

    :func:`fit_decoder` computes it.
    """

    array: TactileArray
    """Geometry of the pad, a flat grid."""
    gains: NDArray[np.float64]
    """Reading of each tactel over the median of all under an even pressure, (N,), > 0."""
    radii: NDArray[np.float64]
    """Distances from a point force, (K,), m, from 0 upwards."""
    response: NDArray[np.float64]
    """Pressure of a point force of 1 N at these distances, (K,), Pa; linear in between."""
    pressures: NDArray[np.float64]
    """Pressures of the flat punch, (P,), Pa, increasing."""
    depths: NDArray[np.float64]
    """Depths of the flat punch at these pressures, (P,), m, increasing."""
    residual: float
    """Rms error of the predicted needle images over the rms of the measured ones."""

    def equalized(self, pressures: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return pressures (N,), Pa, without the differences of the tactels' gains, >= 0."""
        return np.maximum(pressures, 0.0) / self.gains

    @property
    def cells(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Centres of the cells of `deconvolve` along x and y of the pad, m."""
        columns = _grid_of(self.array)[1]
        places = self.array.positions
        return _cell_centres(places[:columns, 0]), _cell_centres(places[::columns, 1])

    def deconvolve(
        self, pressures: NDArray[np.float64], rounds: int = ROUNDS
    ) -> NDArray[np.float64]:
        """Estimate the pressure on the pad's surface before the pad spreads it to the tactels.

        Use Richardson-Lucy deconvolution (Richardson, J. Opt. Soc. Am. 62, 1972; Lucy, Astron. J.
        79, 1974). Each round multiplies the estimate by the back-projected ratio of measured to
        predicted pressure. The estimate stays non-negative, and few rounds keep the noise small.

        Parameters
        ----------
        pressures
            Calibrated pressures of an image, (N,), Pa.
        rounds
            Number of rounds. More rounds give a sharper and noisier result.

        Returns
        -------
        NDArray
            (CELLS_PER_TACTEL * rows, CELLS_PER_TACTEL * columns), Pa.
        """
        rows, columns = _grid_of(self.array)
        measured = self.equalized(pressures) + FLOOR
        cells = np.ones((CELLS_PER_TACTEL, CELLS_PER_TACTEL))
        estimate = np.kron(measured.reshape(rows, columns), cells).ravel()
        weights, back = self._weights
        weight = weights.sum(axis=0)
        for _ in range(rounds):
            estimate = estimate * (back @ (measured / (weights @ estimate))) / weight
        image = np.maximum(estimate - FLOOR, 0.0)
        return image.reshape(CELLS_PER_TACTEL * rows, CELLS_PER_TACTEL * columns)

    def depth(self, pressures: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the depth of a surface, (...), m, that causes pressures (...), Pa, >= 0.

        Below the first press the depth is proportional to the pressure. Above the last one, it
        grows with the logarithm of the pressure.
        """
        curve, slope = self._curve
        first, last = self.pressures[0], self.pressures[-1]
        inside = curve(np.log(np.clip(pressures, first, last)))
        beyond = slope * np.log(np.maximum(pressures, last) / last)
        return inside * np.minimum(pressures / first, 1.0) + beyond

    @cached_property
    def _curve(self) -> tuple[PchipInterpolator, float]:
        curve = PchipInterpolator(np.log(self.pressures), self.depths)
        return curve, float(curve.derivative()(np.log(self.pressures[-1])))

    @cached_property
    def _weights(self) -> tuple[csr_array, csr_array]:
        """The mean (N, M) over M cells that each tactel measures, and its transpose.

        Each row adds up to 1, because the gains make all tactels equal under an even pressure.
        """
        places = self.array.positions[:, :2]
        cells = np.stack(np.meshgrid(*self.cells), axis=-1).reshape(-1, 2)
        offsets = cells[None] - places[:, None]
        near = np.hypot(*np.moveaxis(offsets, 2, 0)) < self.radii[-1] + self.array.area**0.5
        found = _hat_means(offsets[near], self.radii, self.array.area**0.5, 0.0) @ self.response
        weights = np.zeros(near.shape)
        weights[near] = found
        sparse = csr_array(weights / weights.sum(axis=1, keepdims=True))
        return sparse, csr_array(sparse.T)


def fit_decoder(
    array: TactileArray,
    plate_images: NDArray[np.float64],
    plate_depths: NDArray[np.float64],
    needle_images: NDArray[np.float64],
    needle_places: NDArray[np.float64],
    needle_radius: float,
) -> PressDecoder:
    """Fit a decoder from presses of a flat punch and of a needle.

    The punch gives the gains and the pressure over depth. The needle gives the response to a point
    force as a function of the distance. It has no formula: its values at knots are >= 0 and
    minimize the squared error of the images (non-negative least squares). The forces need not be
    known.

    Parameters
    ----------
    array
        Geometry of the pad, a flat grid.
    plate_images
        Calibrated pressures (P, N), Pa, under a flat punch that covers all tactels, P >= 3.
    plate_depths
        Depth (P,) of the punch below the unloaded surface in each image, m, > 0 and increasing.
    needle_images
        Calibrated pressures (M, N), Pa, under a flat-ended needle, M >= 20.
    needle_places
        Middle (M, 2) of the needle on the pad, m. The places should differ within a tactel.
    needle_radius
        Radius of the needle, m, at most 3 pitches.

    Returns
    -------
    PressDecoder
        The decoder.

    Raises
    ------
    InputError
        If the array is not a flat grid, shapes disagree, values are not finite or not in m, a
        tactel does not respond, the pressure does not increase with the depth, a needle image is
        empty, or all places lie between four tactels.
    """
    _grid_of(array)
    _check_presses(array, plate_images, plate_depths, needle_images, needle_places)
    _check_lengths(array, plate_depths, needle_places, needle_radius)
    levels = np.median(plate_images, axis=1)
    if not (levels[0] > 0 and (np.diff(levels) > 0).all()):
        raise InputError(f"pressures under the punch must be > 0 and increase, got {levels} Pa")
    gains = np.median(plate_images / levels[:, None], axis=0)
    silent = np.flatnonzero(~(gains > 0))
    if len(silent):
        raise InputError(f"tactels {silent.tolist()} do not respond to the punch")
    images = np.maximum(needle_images, 0.0) / gains
    forces = images.sum(axis=1) * array.area
    if not (forces > 0).all():
        raise InputError(f"needle images {np.flatnonzero(forces <= 0).tolist()} are empty")
    radii, response, residual = _fit_response(
        array, images / forces[:, None], needle_places, needle_radius
    )
    return PressDecoder(array, gains, radii, response, levels, plate_depths, residual)


def _cell_centres(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centres of the cells within a row of tactels with these centres (N,), m."""
    pitch = places[1] - places[0]
    within = ((np.arange(CELLS_PER_TACTEL) + 0.5) / CELLS_PER_TACTEL - 0.5) * pitch
    return (places[:, None] + within).ravel()


def _fit_response(
    array: TactileArray,
    images: NDArray[np.float64],
    places: NDArray[np.float64],
    needle_radius: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Fit the response, and return its radii, its values and the relative residual."""
    pitch = array.area**0.5
    radii = np.arange(int(REACH * KNOTS_PER_PITCH) + 1) * (pitch / KNOTS_PER_PITCH)
    offsets = places[:, None] - array.positions[None, :, :2]
    near = np.hypot(*np.moveaxis(offsets, 2, 0)) < radii[-1] + pitch
    # The last knot is 0, so it has no unknown.
    design = _hat_means(offsets[near], radii, pitch, needle_radius)[:, :-1]
    _check_rank(design)
    scale = np.linalg.norm(design) / np.sqrt(len(radii))
    bend = np.diff(np.eye(len(radii)), n=2, axis=0)[:, :-1] * (_SMOOTHING * scale)
    values, _ = nnls(
        np.concatenate([design, bend]), np.concatenate([images[near], np.zeros(len(bend))])
    )
    error = images[near] - design @ values
    residual = float(np.linalg.norm(error) / np.linalg.norm(images[near]))
    return radii, np.append(values, 0.0), residual


def _hat_means(
    offsets: NDArray[np.float64], radii: NDArray[np.float64], pitch: float, radius: float
) -> NDArray[np.float64]:
    """Return the means (L, K) of the hat functions of the distance over tactel and needle.

    Offsets (L, 2), m, lead from the tactel to the needle. Means are over a square of side `pitch`
    and a disc of a radius, m.
    """
    steps = ((np.arange(_FINE) + 0.5) / _FINE - 0.5) * pitch
    square = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    angles = np.arange(6) * (np.pi / 3)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    # 7 points with the mean square radius of the disc, radius^2 / 2.
    disc = np.concatenate([np.zeros((1, 2)), radius * (7 / 12) ** 0.5 * ring])
    spacing = radii[1]
    means = np.zeros((len(offsets), len(radii)))
    rows = np.arange(len(offsets))
    shifts = (disc if radius > 0 else disc[:1])[:, None] + square
    for shift in shifts.reshape(-1, 2):
        distance = np.hypot(*(offsets + shift).T) / spacing
        low = np.minimum(distance.astype(int), len(radii) - 1)
        share = np.minimum(distance - low, 1.0)
        means[rows, low] += 1.0 - share
        means[rows, np.minimum(low + 1, len(radii) - 1)] += share * (low + 1 < len(radii))
    return means / (len(shifts) * len(square))


def _grid_of(array: TactileArray) -> tuple[int, int]:
    if array.grid is None or np.ptp(array.positions[:, 2]) > 0 or min(array.grid) < 2:
        raise InputError("a decoder needs a flat pad with an even grid of tactels")
    return array.grid


def _check_presses(
    array: TactileArray,
    plate_images: NDArray[np.float64],
    plate_depths: NDArray[np.float64],
    needle_images: NDArray[np.float64],
    needle_places: NDArray[np.float64],
) -> None:
    count, plates, needles = len(array.positions), len(plate_depths), len(needle_places)
    if plates < 3 or plate_images.shape != (plates, count):
        raise InputError(
            f"need at least 3 plate images of {count} tactels and as many depths, got "
            f"{plate_images.shape} and {plate_depths.shape}"
        )
    shapes = (needle_images.shape, needle_places.shape)
    if needles < MIN_PRESSES or shapes != ((needles, count), (needles, 2)):
        raise InputError(
            f"need at least {MIN_PRESSES} needle images of {count} tactels and as many places "
            f"(M, 2), got {shapes[0]} and {shapes[1]}"
        )
    values = (plate_images, plate_depths, needle_images, needle_places)
    if not all(np.isfinite(value).all() for value in values):
        raise InputError("images, depths and places of presses must be finite")
    if not (plate_depths[0] > 0 and (np.diff(plate_depths) > 0).all()):
        raise InputError(f"depths of the punch must be > 0 and increase, got {plate_depths} m")


def _check_lengths(
    array: TactileArray, depths: NDArray[np.float64], places: NDArray[np.float64], radius: float
) -> None:
    """Refuse depths, places and a radius that are not in m, or not of this pad."""
    if depths[-1] > MAX_DEPTH:
        raise InputError(
            f"depths of the punch must be in m and at most {MAX_DEPTH:g}, got {depths[-1]:g}"
        )
    pitch, points = array.area**0.5, array.positions[:, :2]
    low, high = points.min(axis=0) - MAX_BESIDE * pitch, points.max(axis=0) + MAX_BESIDE * pitch
    outside = np.flatnonzero(((places < low) | (places > high)).any(axis=1))
    if len(outside):
        x, y = places[outside[0]]
        raise InputError(
            f"needle places must be in m on the pad, x from {low[0]:.4f} to {high[0]:.4f} and y "
            f"from {low[1]:.4f} to {high[1]:.4f}, got ({x:g}, {y:g}) in press {outside[0]}"
        )
    if not 0 <= radius <= REACH * pitch:
        raise InputError(
            f"the needle's radius must be 0 to {REACH * pitch:g} m ({REACH:g} pitches), got "
            f"{radius:g}"
        )


def _check_rank(design: NDArray[np.float64]) -> None:
    """Refuse places from which the tactels have too few different distances."""
    values = np.linalg.svd(design, compute_uv=False)
    if np.count_nonzero(values > RANK_SHARE * values[0]) < MIN_RANK:
        raise InputError(
            "needle places must differ within a tactel: between four tactels, these have too few "
            "different distances to determine the spread"
        )
