"""Where the touched face ends under the pad: the rim of an imprint, and straight edges in it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import maximum_filter

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .image import TactileImage

RIM_SHARE = 0.5
"""Share of the face's pressure at the rim: foam spreads a face's end evenly to both sides."""
NEARBY = 5
"""Tactels across the square whose highest pressure is the face's there: it differs over a pad
that is tilted, and foam spreads less far than two tactels."""
LEAST_LEVEL = 0.2
"""Share of the whole face's pressure below which nothing is its rim."""
SOUND = 4
"""The face's pressure is told from tactels of half the one with this rank: few may be faulty."""
LEAST_PRESSURE = 60.0
"""Below this nothing counts as a face, Pa: three times the readings' noise."""
SAME_DIRECTION = np.cos(np.radians(40.0))
"""Cosine up to which rim belongs to an edge: corners, which foam rounds, turn by 60° or more."""
OFF_LINE = 0.001
"""Distance from a line at which a point of the rim counts a quarter, m."""
ROUNDS = 4
"""Of the fit that takes weight from what is off the line."""
FEWEST = 4
"""Points that make an edge."""
TIP_STARTS = (-0.005, -0.025)
"""Places along a line from which its weight ahead is taken, m from the pad's middle."""
TIP_RAMP = 0.01
"""Way over which tactels come to count there, m: two of them, or their number would jump."""


@dataclass(frozen=True)
class Rim:
    """Points of the imprint's rim; K of them, none where the face goes on beyond the pad."""

    points: NDArray[np.float64]
    """(K, 2), m, in the pad's frame."""
    outward: NDArray[np.float64]
    """(K, 2), unit vectors to where nothing is touched."""

    def some(self, chosen: NDArray[np.bool_]) -> Rim:
        """Give the points of a mask (K,)."""
        return Rim(self.points[chosen], self.outward[chosen])


@dataclass(frozen=True)
class RimEdge:
    """A straight edge of the face."""

    outward: NDArray[np.float64]
    """(2,), unit normal to where nothing is touched."""
    offset: float
    """Distance from the pad's middle along it, m; negative if the middle is beyond the edge."""
    rms: float
    """Of its points' distances from the line, m."""
    ends: tuple[float, float]
    """Between where its points lie along it, m from the place nearest to the pad's middle; positive
    to the left of outward."""

    @property
    def span(self) -> float:
        """Length that its points cover, m."""
        return self.ends[1] - self.ends[0]

    @property
    def nearest(self) -> NDArray[np.float64]:
        """Its point that is nearest to the pad's middle, (2,), m."""
        x, y = self.outward
        way = min(max(0.0, self.ends[0]), self.ends[1])
        return self.offset * self.outward + way * np.array([-y, x])


def find_rim(image: TactileImage) -> Rim:
    """Find where the pressure falls through half the face's, between neighbouring tactels.

    Raises
    ------
    InputError
        If the array is no flat even grid.
    """
    grid = image.array.grid
    if grid is None or np.ptp(image.array.positions[:, 2]) > 0:
        raise InputError("a rim is found on flat pads with an even grid of tactels only")
    pressures = image.pressures.reshape(grid)
    high = np.partition(image.pressures, -SOUND)[-SOUND]
    if high < LEAST_PRESSURE:
        return Rim(np.zeros((0, 2)), np.zeros((0, 2)))
    face = float(np.median(pressures[pressures > 0.5 * high]))
    level = np.maximum(RIM_SHARE * maximum_filter(pressures, NEARBY), LEAST_LEVEL * face)
    places = image.array.positions[:, :2].reshape(*grid, 2)
    down, right = np.gradient(pressures)
    fall = -np.stack([right, down], axis=-1)
    found = [
        _crossings(
            pressures[a] - level[a], pressures[b] - level[b], places[a], places[b], fall[a], fall[b]
        )
        for a, b in (
            ((slice(None), slice(None, -1)), (slice(None), slice(1, None))),
            ((slice(None, -1), slice(None)), (slice(1, None), slice(None))),
        )
    ]
    points = np.concatenate([one[0] for one in found])
    outward = np.concatenate([one[1] for one in found])
    length = np.linalg.norm(outward, axis=1)
    good = length > 0.0
    return Rim(points[good], outward[good] / length[good, None])


def fit_edge(rim: Rim, outward: NDArray[np.float64], reach: float | None = None) -> RimEdge | None:
    """Fit a line to the part of the rim that faces a way.

    Parameters
    ----------
    rim
        Points.
    outward
        (2,), unit vector: roughly where the edge faces.
    reach
        Way along the edge from the pad's middle at which points count a third, m: an edge that
        bends is told where the pad is. All alike if left out.

    Returns
    -------
    RimEdge
        None if too few points face that way.
    """
    points = rim.points[rim.outward @ outward > SAME_DIRECTION]
    if len(points) < FEWEST:
        return None
    first = np.ones(len(points))
    if reach is not None:
        first = np.exp(-(((points @ [-outward[1], outward[0]]) / reach) ** 2))
    weights = first / first.sum()
    normal, middle, off = outward, points[0], np.zeros(len(points))
    for _ in range(ROUNDS):
        middle = weights @ points
        away = points - middle
        (xx, xy), (_, yy) = ((weights[:, None] * away).T @ away).tolist()
        # Across the long axis of the second moments: a tenth of the time of an eigensolver.
        axis = 0.5 * math.atan2(2.0 * xy, xx - yy)
        normal = np.array([-math.sin(axis), math.cos(axis)])
        normal = normal if float(normal @ outward) >= 0 else -normal
        off = away @ normal
        weights = first / (1.0 + (off / OFF_LINE) ** 2) ** 2
        weights /= weights.sum()
    near = np.abs(off) < 2.0 * OFF_LINE
    if np.count_nonzero(near) < FEWEST or float(normal @ outward) < SAME_DIRECTION:
        return None
    rms = float(np.sqrt(weights @ off**2))
    way = points[near] @ [-normal[1], normal[0]]
    return RimEdge(normal, float(middle @ normal), rms, (float(way.min()), float(way.max())))


def longest_edge(rim: Rim) -> RimEdge | None:
    """Fit a line to where most of the rim faces the same way."""
    if not len(rim.points):
        return None
    alike = (rim.outward @ rim.outward.T > SAME_DIRECTION).sum(axis=1)
    return fit_edge(rim, rim.outward[np.argmax(alike)])


def corner_of(one: RimEdge, other: RimEdge) -> NDArray[np.float64]:
    """Give the place (2,), m, where two edges meet; they must not be parallel."""
    normals = np.array([one.outward, other.outward])
    return np.linalg.solve(normals, [one.offset, other.offset]).astype(np.float64)


def line_tip(image: TactileImage, along: NDArray[np.float64]) -> float:
    """Tell how far a narrow line reaches from the pad's middle along itself, m.

    What it weighs beyond a place, over what it weighs per length before that place: however far
    foam spreads the end, that is exact for a line that is pressed evenly.

    Parameters
    ----------
    image
        Pressures, of a flat pad.
    along
        (2,), unit vector.
    """
    at = image.array.positions[:, :2] @ along
    beyond, more = (
        float(image.pressures @ np.clip((at - start) / TIP_RAMP + 0.5, 0.0, 1.0))
        for start in TIP_STARTS
    )
    length = TIP_STARTS[0] - TIP_STARTS[1]
    return TIP_STARTS[0] + length * beyond / max(more - beyond, LEAST_PRESSURE)


def _crossings(p, q, at_p, at_q, fall_p, fall_q):
    """Points (K, 2) and falls (K, 2) where of two neighbours p and q one is above 0."""
    across = (p > 0) != (q > 0)
    p, q = p[across], q[across]
    share = (p / (p - q))[:, None]
    points = at_p[across] + share * (at_q - at_p)[across]
    return points, fall_p[across] + share * (fall_q - fall_p)[across]
