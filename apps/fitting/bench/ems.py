"""EMS, the expectation-maximisation-switch fit of superquadrics, written from its paper.

Liu, Wu, Ruan and Chirikjian, "Robust and Accurate Superquadric Recovery: a Probabilistic
Approach", CVPR 2022.

From the paper: a point is an inlier, Gaussian about the surface, or an outlier, uniform in the
volume of the cloud. The E-step computes the posterior of being an inlier from the radial distance.
The M-step runs a few steps of bounded trust-region least squares on the weighted radial distances,
then computes σ² from the cost. When the cost stalls, the S-step tries solids with nearly the same
surface: other axes as z, and duals rotated by 45°. It tries them in the order of their cost and
keeps the first whose M-step improves the cost. The start is an ellipsoid along the principal axes
with the median coordinates as semi-axes. Outlier prior, iterations, tolerances and the ratios that
admit a dual are the published defaults of the authors.

Differences: rotation vectors relative to the current rotation replace Euler angles. Exponents stay
a little away from 0 and 2. The surface area term is left out; the authors leave it out too unless
σ² is near zero.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Superquadric
from eyehand.perception.superquadric import MAX_EXPONENT, MIN_EXPONENT

OUTLIER_PRIOR = 0.1
"""Prior probability of an outlier."""
MAX_ROUNDS, MIN_ROUNDS = 20, 5
"""Maximum and minimum number of rounds of E-step and M-step."""
MAX_EVALUATIONS = 3
"""Residual evaluations per M-step, without those for derivatives."""
MAX_SWITCHES = 2
"""Maximum number of S-steps."""
COST_TOLERANCE = 1e-3
"""Cost below which a fit ends, in the units of the authors (largest coordinate 10)."""
MIN_GAIN = 0.1
"""Relative gain of a round below which the cost has stalled."""
MAX_COORDINATE = 10.0
"""Maximum coordinate of a cloud in the authors' units."""
DUAL_RATIOS = (0.6, 1.4)
"""Range of the ratio of two semi-axes in which a section may switch to its dual."""
MAX_SEMI_AXIS = 4.0
"""Maximum semi-axis, in largest coordinates."""
MIN_SEMI_AXIS = 1e-3
"""Minimum semi-axis, in the authors' units."""
MIN_POINTS = 11
"""Minimum number of points: the number of parameters."""
_TINY = 1e-12


class ScaledCloud(NamedTuple):
    """A cloud, centred and scaled."""

    points: NDArray[np.float64]
    """(N, 3), about their mean, in units of their root mean square radius."""
    centre: NDArray[np.float64]
    """(3,), m."""
    unit: float
    """m."""


class State(NamedTuple):
    """Parameters of :func:`gauge_at`, and the frame of their rotation vector."""

    x: NDArray[np.float64]
    frame: NDArray[np.float64]


def ems_fit(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64] | None = None,
    support_plane: NDArray[np.float64] | None = None,
) -> Superquadric | None:
    """Fit a superquadric by EMS; None if the cloud has too few points or no extent.

    Parameters
    ----------
    points
        (N, 3), m.
    view_origin, support_plane
        Not used by the method.
    """
    cloud = normalised(points)
    if cloud is None:
        return None
    largest = float(cloud.points.max()) / MAX_COORDINATE
    cloud = ScaledCloud(cloud.points / largest, cloud.centre, cloud.unit * largest)
    state = _ems(cloud.points)
    return None if state is None else solid_of(cloud, *state)


def _ems(points: NDArray[np.float64]) -> State | None:
    frame = principal_axes(points)
    # The authors order the axes by variance: largest, smallest, middle.
    frame = np.column_stack([frame[:, 0], frame[:, 2], np.cross(frame[:, 0], frame[:, 2])])
    local = points @ frame
    volume = float(np.prod(np.ptp(local, axis=0)))
    if volume <= 0:
        return None
    variance = volume ** (1 / 3) / 10
    half = np.maximum(np.median(np.abs(local), axis=0), 2 * MIN_SEMI_AXIS)
    state = State(np.concatenate([[1.0, 1.0], half, np.zeros(6)]), frame)
    cost, switched = 0.0, 0
    for round_number in range(1, MAX_ROUNDS + 1):
        weights = _inliers(radial_distances(points, *state), variance, volume)
        following, new_cost = _m_step(points, weights, state)
        gain = (cost - new_cost) / max(new_cost, np.finfo(float).tiny)
        done = switched >= MAX_SWITCHES and round_number > MIN_ROUNDS and gain < MIN_GAIN
        if done or (new_cost < COST_TOLERANCE and round_number > 1):
            return following
        if gain < MIN_GAIN and round_number > 1:
            limit = min(cost, new_cost)
            following, new_cost = _s_step(points, weights, following, new_cost, limit)
            switched += 1
        state, cost = following, new_cost
        variance = cost / (3 * max(float(weights.sum()), np.finfo(float).tiny))
    return state


def _inliers(distances: NDArray[np.float64], variance: float, volume: float) -> NDArray[np.float64]:
    """Compute the posterior (N,) of each point to be an inlier."""
    variance = max(variance, np.finfo(float).tiny)
    uniform = OUTLIER_PRIOR / (1 - OUTLIER_PRIOR) / volume * (2 * np.pi * variance) ** 1.5
    gaussian = np.exp(-0.5 * distances**2 / variance)
    return gaussian / (uniform + gaussian)


def _m_step(
    points: NDArray[np.float64], weights: NDArray[np.float64], state: State
) -> tuple[State, float]:
    """Run the M-step; return the new state and its weighted sum of squares."""
    root = np.sqrt(weights)
    largest = MAX_SEMI_AXIS * float(np.abs(points).max())
    low = [MIN_EXPONENT] * 2 + [MIN_SEMI_AXIS] * 3 + [-2 * np.pi] * 3 + [-largest] * 3
    high = [MAX_EXPONENT] * 2 + [largest] * 3 + [2 * np.pi] * 3 + [largest] * 3
    # The rotation is moved into the frame, so that the rotation vector starts at zero.
    turned = state.frame @ Rotation.from_rotvec(state.x[5:8]).as_matrix()
    start = np.clip(state.x, low, high)
    start[5:8] = 0.0
    found = least_squares(
        lambda x: root * radial_distances(points, x, turned),
        start,
        bounds=(low, high),
        max_nfev=MAX_EVALUATIONS,
    )
    return State(found.x, turned), 2.0 * float(found.cost)


def _s_step(
    points: NDArray[np.float64],
    weights: NDArray[np.float64],
    state: State,
    cost: float,
    limit: float,
) -> tuple[State, float]:
    """Run the S-step: return the first similar solid with a cost below `limit`, or the state."""

    def cost_of(other: State) -> float:
        return float(weights @ radial_distances(points, *other) ** 2)

    candidates = [(cost_of(other), other) for other in _similar(state)]
    for _, other in sorted(
        (pair for pair in candidates if np.isfinite(pair[0])), key=lambda p: p[0]
    ):
        better, better_cost = _m_step(points, weights, other)
        if better_cost < limit:
            return better, better_cost
    return state, cost


def _similar(state: State) -> Iterator[State]:
    """Yield solids with nearly the same surface: other axes as z, and duals of sections."""
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
    """Return the semi-axis of the dual of a unit section, rotated by 45°.

    It is linear between three exact cases: a square (exponent 0) becomes a diamond of √2, a circle
    (1) stays 1, a diamond (2) becomes a square of √½.
    """
    root = np.sqrt(2.0)
    if exponent <= 1:
        return float((1 - root) * exponent + root)
    return float((root / 2 - 1) * exponent + 2 - root / 2)


def normalised(points: NDArray[np.float64]) -> ScaledCloud | None:
    """Centre and scale a cloud; None if it has too few points or no extent."""
    points = np.asarray(points, dtype=np.float64)
    if len(points) < MIN_POINTS or not np.all(np.isfinite(points)):
        return None
    centre = points.mean(axis=0)
    unit = float(np.sqrt(np.mean(np.sum((points - centre) ** 2, axis=1))))
    if not _TINY < unit < np.inf:
        return None
    return ScaledCloud((points - centre) / unit, centre, unit)


def principal_axes(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return right-handed principal axes as columns (3, 3), by falling variance."""
    _, axes = np.linalg.eigh(points.T @ points)
    axes = axes[:, ::-1]
    return axes * [1.0, 1.0, np.sign(np.linalg.det(axes))]


def gauge_at(
    points: NDArray[np.float64], x: NDArray[np.float64], frame: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Compute G = F^(ε1/2) at points (N, 3) for parameters (11,), (N,).

    Parameters are ε1, ε2, a1, a2, a3, a rotation vector within the axes of `frame` (3, 3), and
    the centre. The computation uses logarithms, so that small exponents do not overflow.
    """
    local = (points - x[8:]) @ frame @ Rotation.from_rotvec(x[5:8]).as_matrix()
    log_x, log_y, log_z = np.log(np.maximum(np.abs(local), _TINY) / x[2:5]).T
    across = np.logaddexp(2 / x[1] * log_x, 2 / x[1] * log_y)
    log_f = np.logaddexp(x[1] / x[0] * across, 2 / x[0] * log_z)
    return np.exp(0.5 * x[0] * log_f)


def radial_distances(
    points: NDArray[np.float64], x: NDArray[np.float64], frame: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Compute the signed distance of points (N, 3) from the surface along central rays, (N,)."""
    radius = np.linalg.norm(points - x[8:], axis=1)
    return radius * (1.0 - 1.0 / np.maximum(gauge_at(points, x, frame), _TINY))


def solid_of(
    cloud: ScaledCloud, x: NDArray[np.float64], frame: NDArray[np.float64]
) -> Superquadric | None:
    """Return the solid of parameters (11,) in the frame of the points; None if not finite."""
    if not np.all(np.isfinite(x)):
        return None
    e1, e2 = np.clip(x[:2], MIN_EXPONENT, MAX_EXPONENT)
    turn = Rotation.from_matrix(frame) * Rotation.from_rotvec(x[5:8])
    pose = RigidTransform.from_components(cloud.centre + cloud.unit * x[8:], turn)
    return Superquadric(cloud.unit * x[2:5], (float(e1), float(e2)), pose)
