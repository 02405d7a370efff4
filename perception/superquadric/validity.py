"""What no solid can be told from, and solids that cannot be trusted: the reasons, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .result import robust_spread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions
    from .problem import FitProblem, Guess

FLAT = 1e-4
"""Smallest ratio of a cloud's singular values that still counts as an extent."""
FARTHEST = 1e6
"""Coordinates beyond this leave too few digits for a solid, m."""
FARTHEST_CAMERA = 1e9
"""A camera beyond this sees parallel rays at best, m."""
FLATTER = 6.0
"""A solid must beat a plane or a line by this much of the criterion: strong evidence (Kass and
Raftery 1995), for noise alone makes a plane look thick."""
NOISE_LIMIT = 4.0
"""Spread of the points about a usable solid, in expected noise ..."""
SIZE_LIMIT = 0.12
"""... or as a share of the cloud's radius, whichever is more."""
FAR_SHARE = 0.3
"""Share of points that may lie farther than that from a usable solid."""
UNSEEN_LIMIT = 4.0
"""Largest semi-axis of a usable solid, in radii of the points seen."""
BOUND_TOLERANCE = 0.05
PLANE_PARAMETERS = 3
LINE_PARAMETERS = 4


def unusable(
    cloud: NDArray[np.float64], origin: NDArray[np.float64] | None, options: FitOptions
) -> str:
    """Why numbers (N, 3) are no cloud seen from an origin (3,), or an empty string."""
    if len(cloud) < options.min_points:
        return f"{len(cloud)} points are too few: at least {options.min_points} are needed"
    bad = int(np.count_nonzero(~np.all(np.isfinite(cloud), axis=1)))
    if bad:
        return f"{bad} points are NaN or infinite: leave out pixels without a reading"
    largest = float(np.abs(cloud).max())
    if largest > FARTHEST:
        return f"coordinates reach {largest:.3g} m: move the cloud nearer to the origin"
    if origin is not None and np.abs(origin).max() > FARTHEST_CAMERA:
        return f"the camera is {np.abs(origin).max():.3g} m away: are these metres?"
    return ""


def too_little(
    cloud: NDArray[np.float64],
    origin: NDArray[np.float64] | None,
    plane: NDArray[np.float64] | None,
    options: FitOptions,
) -> str:
    """Why a cloud (N, 3) without outliers determines no solid, or an empty string."""
    extents, _ = _principal(cloud)
    low, high = options.axis_range
    if np.ptp(cloud, axis=0).max() == 0.0:
        return "all points are the same point"
    if not low / 2 <= extents[0] <= 2 * high:
        return (
            f"the cloud spreads over {extents[0]:.3g} m (one σ): solids with semi-axes of "
            f"{low} to {high} m are fitted; are these metres?"
        )
    if extents[1] < FLAT * extents[0]:
        return "all points lie on one line"
    if extents[2] < FLAT * extents[0] and plane is None:
        return "all points lie on one plane: give the support plane, or another view"
    if len(cloud) < options.min_points:
        return (
            f"{len(cloud)} different points are too few: at least {options.min_points} are needed"
        )
    if origin is not None and np.linalg.norm(cloud - origin, axis=1).min() < low:
        return "a point lies at the camera: view_origin must be outside the cloud"
    if plane is None:
        return ""
    heights = cloud @ plane[:3] + plane[3]
    height = float(heights.mean())
    if abs(height) > 2 * high:
        return f"the support plane passes {abs(height):.3g} m from the cloud"
    if np.quantile(heights, 0.9) < 2.0 * options.noise:
        where = "in" if abs(height) <= 2.0 * options.noise else f"{-1e3 * height:.0f} mm under"
        return f"the points lie {where} the support plane: nothing rises from it"
    return ""


def no_solid(problem: FitProblem, lowest: float, has_plane: bool, options: FitOptions) -> str:
    """Why a plane or a line explains the points as well as the best solid, or an empty string.

    On a support plane neither does: the plane gives a thin rod or a flat face its thickness.
    `lowest` is the best solid's criterion (:func:`ladder.criterion`); plane and line are judged
    by the same one, with the few parameters they have.
    """
    if has_plane:
        return ""
    squares = _principal(problem.points)[1] ** 2
    n = problem.readings
    floor = 0.5 * options.noise / problem.unit
    flat = _robust_mean(squares[:, 2], problem.cauchy)
    lowest += FLATTER
    most = (NOISE_LIMIT * options.noise / problem.unit) ** 2
    # Every line also lies in a plane. Of its two directions the mean, as of one surface's normal.
    thin = 0.5 * _robust_mean(squares[:, 1] + squares[:, 2], problem.cauchy)
    thinner = n * np.log(thin + floor**2) + LINE_PARAMETERS * np.log(n) <= lowest
    # What is thinner than the noise is a line even where the edge of some solid follows it closer.
    if thin < (options.noise / problem.unit) ** 2 or (2.0 * thin < most and thinner):
        width = 1e3 * problem.unit * float(np.sqrt(thin))
        return f"all points lie on one line to within {width:.1f} mm"
    flatter = n * np.log(flat + floor**2) + PLANE_PARAMETERS * np.log(n) <= lowest
    if flat < most and flatter:
        width = 1e3 * problem.unit * float(np.sqrt(flat))
        return (
            f"all points lie on one plane to within {width:.1f} mm: give the support plane, or "
            "another view"
        )
    return ""


def misses(residuals: NDArray[np.float64], unit: float, options: FitOptions) -> str:
    """Why residuals (M,), m, of a cloud of radius `unit` rule a solid out, or an empty string."""
    spread = robust_spread(residuals)
    limit = max(NOISE_LIMIT * options.noise, SIZE_LIMIT * unit)
    if spread > limit:
        return (
            f"points spread {spread * 1e3:.1f} mm about the best solid, more than "
            f"{limit * 1e3:.1f} mm: is the cloud one solid?"
        )
    far = float(np.mean(np.abs(residuals) > limit))
    if far > FAR_SHARE:
        return (
            f"{100 * far:.0f} % of the points lie more than {limit * 1e3:.1f} mm from the best "
            "solid: is the cloud one solid?"
        )
    return ""


def ran_away(guess: Guess, problem: FitProblem, options: FitOptions) -> str:
    """Why a solid's size follows from no point, or an empty string."""
    low, high = np.log(np.array(options.axis_range) / problem.unit)
    seen = float(np.sqrt(np.sum(problem.points**2, axis=1).max()))
    if np.exp(guess.axes.max()) > UNSEEN_LIMIT * seen:
        return f"an extent grew to over {UNSEEN_LIMIT:g} times what was seen"
    if np.any(guess.axes >= high - BOUND_TOLERANCE):
        return f"an extent grew to its bound of {options.axis_range[1]} m: too little was seen"
    if np.any(guess.axes <= low + BOUND_TOLERANCE):
        return f"an extent shrank to its bound of {options.axis_range[0]} m: too little was seen"
    return ""


def _principal(
    cloud: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Standard deviations (3,) along the principal axes, largest first, and coordinates (N, 3)."""
    centred = cloud - cloud.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    coordinates = centred @ axes[:, ::-1]
    return np.sqrt(np.mean(coordinates**2, axis=0)), coordinates


def _robust_mean(squares: NDArray[np.float64], scale: float) -> float:
    """Twice the mean Cauchy cost of squared distances (N,)."""
    return float(np.mean(scale**2 * np.log1p(squares / scale**2)))
