"""EMS, the expectation-maximisation-switch fit of superquadrics, written from its paper.

Liu, Wu, Ruan and Chirikjian, "Robust and Accurate Superquadric Recovery: a Probabilistic
Approach", CVPR 2022.

From the paper: points are Gaussian about the surface or uniform in the cloud's volume; the E-step
gives each its posterior of being no outlier from its radial distance; the M-step is a few steps of
bounded trust-region least squares on the weighted radial distances, then σ² from their cost; when
the cost stalls, the S-step tries the solids that are nearly the same surface (other axes as z, and
duals turned by 45°), in the order of their cost, and keeps the first whose own M-step is better.
The start is an ellipsoid along the principal axes with the median coordinates as semi-axes.
Prior of an outlier, iterations, tolerances and the range of ratios that admits a dual are the
authors' published defaults.

Our reading: rotations are vectors about the current ones instead of Euler angles; exponents keep
a little off 0 and 2; the term of the surface's area, which the authors too leave out while σ² is
more than rounding, is left out for good.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from eyehand.perception.superquadric import MAX_EXPONENT, MIN_EXPONENT

from .classic_fitters import Cloud, normalised, principal_axes, radial_distances, solid_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

OUTLIER_PRIOR = 0.1
"""Share of outliers believed in before a look at the points."""
ROUNDS, FEWEST_ROUNDS = 20, 5
"""Most rounds of expectation and maximisation, and those before it may end."""
EVALUATIONS = 3
"""Evaluations of the residuals in a maximisation, derivatives not counted."""
SWITCHES = 2
"""Times that another solid of nearly the same surface is tried."""
COST_TOLERANCE = 1e-3
"""Cost below which a fit is done, in the authors' units (largest coordinate 10)."""
STALLED = 0.1
"""Relative gain of a round below which it has stalled."""
AUTHORS_REACH = 10.0
"""Largest coordinate of a cloud in the authors' units."""
DUAL_RATIOS = (0.6, 1.4)
"""Ratio of two semi-axes within which a section may be taken for its dual."""
LARGEST = 4.0
"""Largest semi-axis, in largest coordinates."""
SMALLEST = 1e-3
"""Smallest semi-axis, in the authors' units."""


class State(NamedTuple):
    """Parameters as :func:`fit_peers.gauge_at` takes them, and the axes that they turn."""

    x: NDArray[np.float64]
    frame: NDArray[np.float64]


def ems_fit(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64] | None = None,
    support_plane: NDArray[np.float64] | None = None,
) -> Superquadric | None:
    """Fit a superquadric by EMS; None when the cloud holds too little.

    Parameters
    ----------
    points
        (N, 3), m.
    view_origin, support_plane
        Not used: the method knows of neither.
    """
    cloud = normalised(points)
    if cloud is None:
        return None
    largest = float(cloud.points.max()) / AUTHORS_REACH
    cloud = Cloud(cloud.points / largest, cloud.centre, cloud.unit * largest)
    state = _ems(cloud.points)
    return None if state is None else solid_of(cloud, *state)


def _ems(points: NDArray[np.float64]) -> State | None:
    frame = principal_axes(points)
    # The authors take the middle axis as y's neighbour: largest, smallest, middle.
    frame = np.column_stack([frame[:, 0], frame[:, 2], np.cross(frame[:, 0], frame[:, 2])])
    local = points @ frame
    volume = float(np.prod(np.ptp(local, axis=0)))
    if volume <= 0:
        return None
    variance = volume ** (1 / 3) / 10
    half = np.maximum(np.median(np.abs(local), axis=0), 2 * SMALLEST)
    state = State(np.concatenate([[1.0, 1.0], half, np.zeros(6)]), frame)
    cost, switched = 0.0, 0
    for round_number in range(1, ROUNDS + 1):
        weights = _inliers(radial_distances(points, *state), variance, volume)
        following, new_cost = _maximised(points, weights, state)
        gain = (cost - new_cost) / max(new_cost, np.finfo(float).tiny)
        done = switched >= SWITCHES and round_number > FEWEST_ROUNDS and gain < STALLED
        if done or (new_cost < COST_TOLERANCE and round_number > 1):
            return following
        if gain < STALLED and round_number > 1:
            limit = min(cost, new_cost)
            following, new_cost = _switched(points, weights, following, new_cost, limit)
            switched += 1
        state, cost = following, new_cost
        variance = cost / (3 * max(float(weights.sum()), np.finfo(float).tiny))
    return state


def _inliers(distances: NDArray[np.float64], variance: float, volume: float) -> NDArray[np.float64]:
    """Posterior of each point (N,) to be Gaussian about the surface, not uniform in the volume."""
    variance = max(variance, np.finfo(float).tiny)
    uniform = OUTLIER_PRIOR / (1 - OUTLIER_PRIOR) / volume * (2 * np.pi * variance) ** 1.5
    gaussian = np.exp(-0.5 * distances**2 / variance)
    return gaussian / (uniform + gaussian)


def _maximised(
    points: NDArray[np.float64], weights: NDArray[np.float64], state: State
) -> tuple[State, float]:
    """A few steps of weighted least squares: the state after them, and its sum of squares."""
    root = np.sqrt(weights)
    largest = LARGEST * float(np.abs(points).max())
    low = [MIN_EXPONENT] * 2 + [SMALLEST] * 3 + [-2 * np.pi] * 3 + [-largest] * 3
    high = [MAX_EXPONENT] * 2 + [largest] * 3 + [2 * np.pi] * 3 + [largest] * 3
    # The rotation goes into the frame, so that its vector starts at none.
    turned = state.frame @ Rotation.from_rotvec(state.x[5:8]).as_matrix()
    start = np.clip(state.x, low, high)
    start[5:8] = 0.0
    found = least_squares(
        lambda x: root * radial_distances(points, x, turned),
        start,
        bounds=(low, high),
        max_nfev=EVALUATIONS,
    )
    return State(found.x, turned), 2.0 * float(found.cost)


def _switched(
    points: NDArray[np.float64],
    weights: NDArray[np.float64],
    state: State,
    cost: float,
    limit: float,
) -> tuple[State, float]:
    """The first solid of nearly the same surface that becomes better than `limit`, or this one."""

    def price(other: State) -> float:
        return float(weights @ radial_distances(points, *other) ** 2)

    priced = [(price(other), other) for other in _similar(state)]
    for _, other in sorted((pair for pair in priced if np.isfinite(pair[0])), key=lambda p: p[0]):
        better, better_cost = _maximised(points, weights, other)
        if better_cost < limit:
            return better, better_cost
    return state, cost


def _similar(state: State) -> Iterator[State]:
    """Solids whose surface is nearly the same: other axes as z, and duals of round sections."""
    e1, e2, a1, a2, a3 = state.x[:5]
    centre = state.x[8:]
    own = state.frame @ Rotation.from_rotvec(state.x[5:8]).as_matrix()
    after_x, after_y = own[:, [1, 2, 0]], own[:, [2, 0, 1]]

    def at(e1: float, e2: float, half: tuple[float, ...], frame: NDArray[np.float64]) -> State:
        return State(np.concatenate([[e1, e2], half, np.zeros(3), centre]), frame)

    yield at(e2, e1, (a2, a3, a1), after_x)
    yield at(e2, e1, (a3, a1, a2), after_y)
    low, high = DUAL_RATIOS
    sections = (
        (e1, e2, (a1, a2, a3), own),
        (e2, e1, (a2, a3, a1), after_x),
        (e2, e1, (a3, a1, a2), after_y),
    )
    eighth = Rotation.from_euler("z", 45, degrees=True).as_matrix()
    for outer, inner, (along, across, height), frame in sections:
        if low < across / along < high or low < along / across < high:
            size = _dual_size(inner) * min(along, across)
            yield at(outer, 2 - inner, (size, size, height), frame @ eighth)


def _dual_size(exponent: float) -> float:
    """Semi-axis of the dual of a unit section, turned by 45°: linear between the three that fit.

    A square (0) becomes a diamond √2 as large, a circle (1) itself, a diamond (2) a square of
    √½.
    """
    root = np.sqrt(2.0)
    if exponent <= 1:
        return float((1 - root) * exponent + root)
    return float((root / 2 - 1) * exponent + 2 - root / 2)
