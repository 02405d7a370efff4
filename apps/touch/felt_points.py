"""Compute points of a touched surface from tactile images, with a decoder fitted to the pad."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from eyehand.tactile import PressDecoder

MIN_PRESSURE = 200.0
"""Minimum pressure of a point, Pa, slightly above the sensor's lower limit. A lower pressure may
come from the foam's spread, and its noise would appear as a spike."""
MIN_SHARE = 0.75
"""Minimum pressure of a cell as a fraction of the maximum in its neighbourhood. Cells beside a
narrow imprint measure the foam's spread and not the surface."""
CONFIRMING, NEAR = 2, 0.005
"""Number of other images with a point near a felt point, and its maximum distance, m: the pad's
pitch. A pad that slides feels the surface again and again, but noise in the air only once."""
NEIGHBOURS = 16
"""Number of nearest points that are searched for those of other images."""
SHIFT_SHARE = 0.1
"""Share of a new shift by friction that is followed in a cycle. The wrist's force is noisy."""
MAX_FRICTION = 1.0
"""Maximum ratio of tangential to normal force. At a light touch the ratio is noise."""


def felt_points(
    pressures: NDArray[np.float64],
    decoder: PressDecoder,
    sharpen: bool = True,
    unknown: NDArray[np.bool_] | None = None,
) -> NDArray[np.float64]:
    """Compute points of the touched surface.

    Each cell with about the pressure of its neighbours yields one point. The pressure determines
    its depth in the foam. Its lateral position is the centre of pressure of the 3 x 3
    neighbourhood: the cell's centre on a face, and between cells on an edge or a point.

    Parameters
    ----------
    pressures
        Calibrated pressures of the pad's tactels, (N,), Pa.
    decoder
        Decoder of the pad.
    sharpen
        If true, each tactel is divided into smaller cells, and the pressure before the foam's
        spread is estimated in them. The spread makes a narrow ridge appear too low. Otherwise the
        cells are the tactels.
    unknown
        Mask (N,) of tactels whose pressure is unknown, as they are saturated. There are no points
        on them and their neighbours.

    Returns
    -------
    NDArray
        Points (M, 3) in the pad frame, m.
    """
    places = decoder.array.positions.reshape(*(decoder.array.grid or ()), 3)
    x, y, border = places[0, :, 0], places[:, 0, 1], 1
    image = decoder.equalized(pressures).reshape(len(y), len(x))
    if sharpen:
        image = decoder.deconvolve(pressures)
        (x, y), border = decoder.cells, len(image) // len(places)
    windows = _windows(image)
    felt = (image > MIN_PRESSURE) & (image >= MIN_SHARE * windows.max(axis=0))
    # The windows are incomplete at the border because nothing is measured beyond it.
    felt[:border] = felt[-border:] = felt[:, :border] = felt[:, -border:] = False
    total = np.maximum(windows.sum(axis=0), MIN_PRESSURE)
    across, down = ((windows * _windows(axis)).sum(axis=0) / total for axis in np.meshgrid(x, y))
    points = np.column_stack([across[felt], down[felt], -decoder.depth(image[felt])])
    if unknown is not None and unknown.any():
        pitch = decoder.array.area**0.5
        apart = np.abs(points[:, None, :2] - decoder.array.positions[unknown, :2]).max(axis=2)
        points = points[apart.min(axis=1) > pitch]
    return points


def confirmed_points(images: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the points (M, 3) of images that points of 2 other images confirm.

    Parameters
    ----------
    images
        Points (K, 3) of each image in a common frame, m.
    """
    points = np.concatenate([np.zeros((0, 3)), *images])
    if not len(points):
        return points
    number = np.repeat(np.arange(len(images)), [len(image) for image in images])
    found = KDTree(points).query(points, NEIGHBOURS, distance_upper_bound=NEAR)[1]
    # A missing neighbour counts as one of the point's own image.
    near = np.where(found < len(points), number[found % len(points)], number[:, None])
    others = np.count_nonzero(np.diff(np.sort(near, axis=1), axis=1), axis=1)
    return points[others >= CONFIRMING]


def friction_shift(
    shift: NDArray[np.float64], side_force: NDArray[np.float64], force: float, lever: float
) -> NDArray[np.float64]:
    """Follow the shift of the image by friction, (2,), m: h Ft / Fn for foam of height h.

    Parameters
    ----------
    shift
        Shift in the cycle before, (2,), m.
    side_force
        Tangential force on the pad, (2,), N.
    force
        Normal force, N, > 0.
    lever
        Height of the foam, m; 0 if friction does not move the image.
    """
    ratio = side_force / force
    ratio /= max(float(np.linalg.norm(ratio)), MAX_FRICTION) / MAX_FRICTION
    return shift + SHIFT_SHARE * (lever * ratio - shift)


def _windows(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the 3 x 3 neighbourhood of each cell (9, rows, columns), zero beyond the border."""
    padded = np.pad(values, 1)
    rows, columns = values.shape
    return np.array([padded[r : r + rows, c : c + columns] for r in range(3) for c in range(3)])
