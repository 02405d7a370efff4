"""Two classic superquadric fitters, implemented from their papers, as baselines.

Each function states what is from its paper. Common differences: both use scipy's bounded
trust-region least squares with numeric derivatives, in a frame scaled to the cloud. Each principal
axis is tried as z, and the lowest residual is kept. With one start, as published, half of all
solids end with a wrong z axis, even on whole surfaces without noise.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Superquadric
from eyehand.perception.superquadric import MAX_EXPONENT, MIN_EXPONENT

EXPONENTS = (0.1, 1.9)
"""Bounds of the exponents. Solina and Bajcsy use 0.1 to 1; the wider range includes pinched
shapes."""
MIN_SEMI_AXIS = 0.01
"""Minimum semi-axis, in units of the root mean square radius of the cloud."""
MAX_SEMI_AXIS = 10.0
"""Maximum semi-axis, and maximum coordinate of the centre, in the same unit."""
MAX_EVALUATIONS = 200
"""Maximum number of residual evaluations of a fit, without those for derivatives."""
LOSS_SCALE = 0.03
"""Radial distance above which soft_l1 grows linearly, in the same unit: twice 1 mm of noise on a
solid of 65 mm."""
MIN_POINTS = 11
"""Minimum number of points: the number of parameters."""
_TINY = 1e-12


Residuals = Callable[
    ["NDArray[np.float64]", "NDArray[np.float64]", "NDArray[np.float64]"], "NDArray[np.float64]"
]
"""Residuals (N,) of points (N, 3) for parameters (11,) within a frame (3, 3)."""


class Cloud(NamedTuple):
    """A cloud, centred and scaled for the baselines."""

    points: NDArray[np.float64]
    """(N, 3), about their mean, in units of their root mean square radius."""
    centre: NDArray[np.float64]
    """(3,), m."""
    unit: float
    """m."""


def moments_fit(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64] | None = None,
    support_plane: NDArray[np.float64] | None = None,
) -> Superquadric | None:
    """Fit by Solina and Bajcsy (1990): least squares on √(a1 a2 a3) (F^ε1 - 1) from moments.

    From the paper ("Recovery of parametric models from range images: the case for superquadrics
    with global deformations", PAMI 12(2)): the residual, whose first factor prefers the smallest
    solid that explains a view; the start, an ellipsoid at the middle of the cloud along the
    principal axes. Difference: bounds replace clamping. Left out: their noise on the error for
    leaving local minima, and deformations. View and plane are not used.
    """
    return _solved(points, _volume_residuals, "linear")


def radial_fit(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64] | None = None,
    support_plane: NDArray[np.float64] | None = None,
) -> Superquadric | None:
    """Fit by Gross and Boult (1988): least squares on the radial distance |r| |1 - F^(-ε1/2)|.

    From the paper ("Error of fit measures for recovering parametric solids", ICCV): the distance
    to the surface along the ray from the centre of the solid, the best of four measures there.
    Differences: the start is that of :func:`moments_fit`, and soft_l1 of scipy replaces the square,
    so that outliers have a limited weight.
    """
    return _solved(points, radial_distances, "soft_l1")


def normalised(points: NDArray[np.float64]) -> Cloud | None:
    """Centre and scale a cloud; None if it has too few points or no extent."""
    points = np.asarray(points, dtype=np.float64)
    if len(points) < MIN_POINTS or not np.all(np.isfinite(points)):
        return None
    centre = points.mean(axis=0)
    unit = float(np.sqrt(np.mean(np.sum((points - centre) ** 2, axis=1))))
    if not _TINY < unit < np.inf:
        return None
    return Cloud((points - centre) / unit, centre, unit)


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
    cloud: Cloud, x: NDArray[np.float64], frame: NDArray[np.float64]
) -> Superquadric | None:
    """Return the solid of parameters (11,) in the frame of the points; None if not finite."""
    if not np.all(np.isfinite(x)):
        return None
    e1, e2 = np.clip(x[:2], MIN_EXPONENT, MAX_EXPONENT)
    turn = Rotation.from_matrix(frame) * Rotation.from_rotvec(x[5:8])
    pose = RigidTransform.from_components(cloud.centre + cloud.unit * x[8:], turn)
    return Superquadric(cloud.unit * x[2:5], (float(e1), float(e2)), pose)


def _volume_residuals(
    points: NDArray[np.float64], x: NDArray[np.float64], frame: NDArray[np.float64]
) -> NDArray[np.float64]:
    return np.sqrt(np.prod(x[2:5])) * (gauge_at(points, x, frame) ** 2 - 1.0)


def _solved(points: NDArray[np.float64], residuals: Residuals, loss: str) -> Superquadric | None:
    cloud = normalised(points)
    if cloud is None:
        return None
    bounds = (
        [EXPONENTS[0]] * 2 + [MIN_SEMI_AXIS] * 3 + [-np.inf] * 3 + [-MAX_SEMI_AXIS] * 3,
        [EXPONENTS[1]] * 2 + [MAX_SEMI_AXIS] * 3 + [np.inf] * 3 + [MAX_SEMI_AXIS] * 3,
    )
    axes = principal_axes(cloud.points)
    best, best_frame = None, axes
    for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1]):
        frame = axes[:, order]
        local = cloud.points @ frame
        low, high = local.min(axis=0), local.max(axis=0)
        half = np.clip((high - low) / 2, 2 * MIN_SEMI_AXIS, MAX_SEMI_AXIS / 2)
        start = np.concatenate([[1.0, 1.0], half, np.zeros(3), frame @ ((low + high) / 2)])
        found = least_squares(
            lambda x, frame: residuals(cloud.points, x, frame),
            start,
            args=(frame,),
            bounds=bounds,
            loss=loss,
            f_scale=LOSS_SCALE,
            max_nfev=MAX_EVALUATIONS,
        )
        if best is None or found.cost < best.cost:
            best, best_frame = found, frame
    assert best is not None
    return solid_of(cloud, best.x, best_frame)
