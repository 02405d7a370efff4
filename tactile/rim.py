"""The rim of an imprint: where the touched face ends, its straight edges and their corners."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from eyehand.errors import InputError

from .image import TactileImage

RIM_SHARE = 0.5
"""Share of the face's pressure at the rim. Foam spreads the end of a face evenly to both sides."""
NEIGHBOURHOOD = 5
"""Side of the square, in tactels, whose highest pressure is the face's pressure there. It differs
over a tilted pad. Foam spreads the pressure by less than two tactels."""
MIN_FACE_SHARE = 0.2
"""Share of the median pressure of the face below which there is no rim."""
FACE_RANK = 4
"""The face are the tactels above half the pressure of this rank. A few tactels may be faulty."""
MIN_PRESSURE = 60.0
"""Pressure of a face, Pa: three times the noise of the readings."""
SAME_DIRECTION = np.cos(np.radians(40.0))
"""Minimum cosine between the normals of a rim point and its edge. Corners, which foam rounds, turn
by 60° or more."""
LINE_DISTANCE = 0.001
"""Distance from a line at which a rim point has a quarter of its weight, m."""
FIT_ROUNDS = 4
"""Iterations of the robust line fit."""
MIN_POINTS = 4
"""Points of an edge."""
END_STARTS = (-0.005, -0.025)
"""Positions along a line beyond which its pressure is summed, m from the pad's middle."""
END_RAMP = 0.01
"""Length of two tactels, m, over which the weight of a tactel grows from 0 to 1. With a step, the
sum would jump with the number of tactels."""


@dataclass(frozen=True)
class Rim:
    """K points of an imprint's rim; none where the face continues beyond the pad."""

    points: NDArray[np.float64]
    """(K, 2), m, in the pad's frame."""
    outward: NDArray[np.float64]
    """(K, 2), unit vectors away from the face."""

    def select(self, mask: NDArray[np.bool_]) -> Rim:
        """Return the points of a mask (K,)."""
        return Rim(self.points[mask], self.outward[mask])


@dataclass(frozen=True)
class RimEdge:
    """A straight edge of the face."""

    outward: NDArray[np.float64]
    """(2,), unit normal, away from the face."""
    offset: float
    """Distance from the pad's middle along the normal, m; negative if the middle is outside."""
    rms: float
    """Root mean square distance of its points from the line, m."""
    ends: tuple[float, float]
    """Range of its points along the edge, m, from the foot of the pad's middle; positive to the
    left of the normal."""

    @property
    def span(self) -> float:
        """Length that its points cover, m."""
        return self.ends[1] - self.ends[0]

    @property
    def nearest(self) -> NDArray[np.float64]:
        """Its felt point that is nearest to the pad's middle, (2,), m."""
        x, y = self.outward
        along = min(max(0.0, self.ends[0]), self.ends[1])
        return self.offset * self.outward + along * np.array([-y, x])


def find_rim(image: TactileImage) -> Rim:
    """Find where the pressure falls through half the face's pressure, between two tactels.

    Raises
    ------
    InputError
        If the array is not a flat even grid.
    """
    grid = image.array.grid
    if grid is None or np.ptp(image.array.positions[:, 2]) > 0:
        raise InputError("find_rim needs a flat pad with an even grid of tactels")
    pressures = image.pressures.reshape(grid)
    high = np.partition(image.pressures, -FACE_RANK)[-FACE_RANK]
    if high < MIN_PRESSURE:
        return Rim(np.zeros((0, 2)), np.zeros((0, 2)))
    face = float(np.median(pressures[pressures > 0.5 * high]))
    level = np.maximum(RIM_SHARE * maximum_filter(pressures, NEIGHBOURHOOD), MIN_FACE_SHARE * face)
    positions = image.array.positions[:, :2].reshape(*grid, 2)
    down, right = np.gradient(pressures)
    fall = -np.stack([right, down], axis=-1)
    above = pressures - level
    crossings = [
        _crossings(above[a], above[b], positions[a], positions[b], fall[a], fall[b])
        for a, b in (
            ((slice(None), slice(None, -1)), (slice(None), slice(1, None))),
            ((slice(None, -1), slice(None)), (slice(1, None), slice(None))),
        )
    ]
    points = np.concatenate([points for points, _ in crossings])
    outward = np.concatenate([falls for _, falls in crossings])
    length = np.linalg.norm(outward, axis=1)
    valid = length > 0.0
    return Rim(points[valid], outward[valid] / length[valid, None])


def fit_edge(rim: Rim, outward: NDArray[np.float64], reach: float | None = None) -> RimEdge | None:
    """Fit a line to the rim points that face in a direction.

    Parameters
    ----------
    rim
        Points.
    outward
        (2,), unit vector, the approximate normal of the edge.
    reach
        Distance along the edge from the pad's middle at which a point has a third of the weight,
        m. A bent edge is then fitted at the pad. None gives all points the same weight.

    Returns
    -------
    RimEdge
        None if too few points face in that direction.
    """
    points = rim.points[rim.outward @ outward > SAME_DIRECTION]
    if len(points) < MIN_POINTS:
        return None
    base = np.ones(len(points))
    if reach is not None:
        base = np.exp(-(((points @ [-outward[1], outward[0]]) / reach) ** 2))
    weights = base / base.sum()
    normal, middle, distance = outward, points[0], np.zeros(len(points))
    for _ in range(FIT_ROUNDS):
        middle = weights @ points
        centred = points - middle
        (xx, xy), (_, yy) = ((weights[:, None] * centred).T @ centred).tolist()
        # The short axis of the second moments; an eigensolver takes ten times as long.
        axis = 0.5 * math.atan2(2.0 * xy, xx - yy)
        normal = np.array([-math.sin(axis), math.cos(axis)])
        normal = normal if float(normal @ outward) >= 0 else -normal
        distance = centred @ normal
        weights = base / (1.0 + (distance / LINE_DISTANCE) ** 2) ** 2
        weights /= weights.sum()
    near = np.abs(distance) < 2.0 * LINE_DISTANCE
    if np.count_nonzero(near) < MIN_POINTS or float(normal @ outward) < SAME_DIRECTION:
        return None
    rms = float(np.sqrt(weights @ distance**2))
    along = points[near] @ [-normal[1], normal[0]]
    return RimEdge(normal, float(middle @ normal), rms, (float(along.min()), float(along.max())))


def fit_longest_edge(rim: Rim) -> RimEdge | None:
    """Fit a line to the rim points in the direction that most of them face."""
    if not len(rim.points):
        return None
    alike = (rim.outward @ rim.outward.T > SAME_DIRECTION).sum(axis=1)
    return fit_edge(rim, rim.outward[np.argmax(alike)])


def intersect_edges(one: RimEdge, other: RimEdge) -> NDArray[np.float64]:
    """Compute the point (2,), m, where two edges meet; they must not be parallel."""
    normals = np.array([one.outward, other.outward])
    return np.linalg.solve(normals, [one.offset, other.offset]).astype(np.float64)


def find_line_end(image: TactileImage, along: NDArray[np.float64]) -> float:
    """Compute how far a narrow line reaches from the pad's middle, m.

    It is the pressure beyond a position, over the pressure per length before this position. For an
    evenly pressed line this is exact, no matter how far foam spreads its end.

    Parameters
    ----------
    image
        Pressures, of a flat pad.
    along
        (2,), unit vector along the line.
    """
    positions = image.array.positions[:, :2] @ along
    beyond, beyond_both = (
        float(image.pressures @ np.clip((positions - start) / END_RAMP + 0.5, 0.0, 1.0))
        for start in END_STARTS
    )
    length = END_STARTS[0] - END_STARTS[1]
    return END_STARTS[0] + length * beyond / max(beyond_both - beyond, MIN_PRESSURE)


def _crossings(p, q, position_p, position_q, fall_p, fall_q):
    """Return points (K, 2) and falls (K, 2) where one of two neighbours p and q is above 0."""
    across = (p > 0) != (q > 0)
    p, q = p[across], q[across]
    share = (p / (p - q))[:, None]
    points = position_p[across] + share * (position_q - position_p)[across]
    return points, fall_p[across] + share * (fall_q - fall_p)[across]
