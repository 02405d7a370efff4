"""Synthetic imprints on a pad with known position and direction, to evaluate features."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from eyehand.errors import InputError
from eyehand.tactile import TactileArray, TactileImage

SPREAD = 0.0025
"""Standard deviation of the Gaussian by which the foam spreads a point force, m."""
NOISE = 5.0
"""Standard deviation of each tactel's pressure, Pa: 1 % of the weakest imprint's peak."""
THRESHOLD = 4 * NOISE
"""Minimum pressure of a touched tactel, Pa."""
PEAKS = (500.0, 5000.0)
"""Range of the peak pressure, Pa: from half of the linear range to half of the full range."""
POINT_PITCH = 0.0005
"""Distance between the points of an imprint, m: a fifth of the spread."""
WIDTH = 0.001
"""Width of a line, m: a sharp edge."""
SHORT, LONG = (0.015, 0.04), 0.2
"""Length range of lines that end on the pad, and length of lines that cross it, m."""
LINE_OFFSET = 0.01
"""Maximum distance of a line from the pad's centre, m."""
PROBE_DIAMETER = 0.002
"""Diameter of the paper's probe, m."""
PROBE_REACH = 0.025
"""Maximum offset of a probe from the pad's centre along x and y, m. It avoids the border."""

Kind = Literal["short line", "crossing line", "probe"]


@dataclass(frozen=True)
class Imprint:
    """A tactile image and its ground truth."""

    image: TactileImage
    centre: NDArray[np.float64]
    """Centre (2,) of the imprint, m. For a crossing line, the centre of its part on the pad."""
    angle: float
    """Direction of a line, rad. 0 for a probe."""


def imprints(
    array: TactileArray, kind: Kind, count: int, seed: int, noise: float = NOISE
) -> Iterator[Imprint]:
    """Generate imprints with random position, direction and strength.

    Imprint k depends on `seed + k` only.

    Parameters
    ----------
    array
        Flat pad with a regular grid.
    noise
        Standard deviation of each tactel's pressure, Pa. Use 0 if a read-out adds its own noise.

    Raises
    ------
    InputError
        If the array is not a flat grid.
    """
    if array.grid is None or np.ptp(array.positions[:, 2]) > 0:
        raise InputError("imprints are made on flat pads only")
    for k in range(count):
        rng = np.random.default_rng((seed + k, len(kind)))
        points, centre, angle = _probe(rng) if kind == "probe" else _line(rng, kind)
        pressures = _spread(array, points)
        pressures *= np.exp(rng.uniform(*np.log(PEAKS))) / pressures.max()
        pressures += rng.normal(0.0, noise, len(pressures))
        yield Imprint(TactileImage(pressures, array), centre, angle)


def _line(
    rng: np.random.Generator, kind: Kind
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    angle = rng.uniform(-np.pi / 2, np.pi / 2)
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    centre = rng.uniform(-LINE_OFFSET, LINE_OFFSET) * across
    length = rng.uniform(*SHORT) if kind == "short line" else LONG
    u, v = np.meshgrid(_even(length), _even(WIDTH))
    return centre + u.reshape(-1, 1) * along + v.reshape(-1, 1) * across, centre, angle


def _probe(rng: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    centre = rng.uniform(-PROBE_REACH, PROBE_REACH, 2)
    points = np.stack(np.meshgrid(*[_even(PROBE_DIAMETER)] * 2), axis=-1).reshape(-1, 2)
    inside = np.linalg.norm(points, axis=1) <= PROBE_DIAMETER / 2
    return centre + points[inside], centre, 0.0


def _even(length: float) -> NDArray[np.float64]:
    count = max(int(np.ceil(length / POINT_PITCH)), 2)
    return (np.arange(count, dtype=np.float64) - 0.5 * (count - 1)) * (length / count)


def _spread(array: TactileArray, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distribute each point's force to the tactels by the integral of a Gaussian over each."""
    half = 0.5 * np.sqrt(array.area)
    rows, columns = array.grid or (0, 0)
    x = array.positions[:columns, 0]
    y = array.positions[::columns, 1]
    shares = []
    for centres, at in ((x, points[:, 0]), (y, points[:, 1])):
        away = centres - at[:, None]
        shares.append(ndtr((away + half) / SPREAD) - ndtr((away - half) / SPREAD))
    return (shares[1].T @ shares[0]).reshape(rows * columns)
