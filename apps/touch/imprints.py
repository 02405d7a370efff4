"""Made-up imprints on a pad with known place and direction, to measure features on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.special import ndtr

from eyehand.errors import InputError
from eyehand.tactile import TactileImage

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from eyehand.tactile import TactileArray

SPREAD = 0.0025
"""Standard deviation of what the foam spreads a point's force by, m."""
NOISE = 5.0
"""Standard deviation of each tactel's pressure, Pa: 1 % of the weakest imprint's peak."""
THRESHOLD = 4 * NOISE
"""Above which a tactel is touched, Pa."""
PEAKS = (500.0, 5000.0)
"""Highest pressures of imprints, Pa: half of the linear range to half of the whole."""
POINT_PITCH = 0.0005
"""Between points that an imprint is made of, m: a fifth of the spread."""
WIDTH = 0.001
"""Of a line, m: a sharp edge."""
SHORT, LONG = (0.015, 0.04), 0.2
"""Lengths of lines that end on the pad, and length of those that cross it, m."""
LINE_OFFSET = 0.01
"""Lines pass the pad's centre within this, m."""
PROBE_DIAMETER = 0.002
"""Of the paper's probe, m."""
PROBE_REACH = 0.025
"""Probes stay within this of the pad's centre along x and y, m: off the border."""

Kind = Literal["short line", "crossing line", "probe"]


@dataclass(frozen=True)
class Imprint:
    """An image and what made it."""

    image: TactileImage
    centre: NDArray[np.float64]
    """Of the imprint, (2,), m; of a crossing line the middle of the part on the pad."""
    angle: float
    """Of a line, rad; 0 for a probe, which has none."""


def imprints(
    array: TactileArray, kind: Kind, count: int, seed: int, noise: float = NOISE
) -> Iterator[Imprint]:
    """Make imprints with random place, direction and strength; number k follows from seed + k.

    Parameters
    ----------
    array
        A flat pad.
    noise
        Standard deviation of each tactel's pressure, Pa; 0 where a read-out brings its own.

    Raises
    ------
    InputError
        If the array is no flat grid.
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


def _probe(
    rng: np.random.Generator,
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    centre = rng.uniform(-PROBE_REACH, PROBE_REACH, 2)
    points = np.stack(np.meshgrid(*[_even(PROBE_DIAMETER)] * 2), axis=-1).reshape(-1, 2)
    inside = np.linalg.norm(points, axis=1) <= PROBE_DIAMETER / 2
    return centre + points[inside], centre, 0.0


def _even(length: float) -> NDArray[np.float64]:
    count = max(int(np.ceil(length / POINT_PITCH)), 2)
    return (np.arange(count, dtype=np.float64) - 0.5 * (count - 1)) * (length / count)


def _spread(array: TactileArray, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share each point's force among tactels by a Gaussian's integral over each of them."""
    half = 0.5 * np.sqrt(array.area)
    rows, columns = array.grid or (0, 0)
    x = array.positions[:columns, 0]
    y = array.positions[::columns, 1]
    shares = []
    for centres, at in ((x, points[:, 0]), (y, points[:, 1])):
        away = centres - at[:, None]
        shares.append(ndtr((away + half) / SPREAD) - ndtr((away - half) / SPREAD))
    return (shares[1].T @ shares[0]).reshape(rows * columns)
