"""Checks of clouds and fitted solids. Each returns the reason for a rejection, or ''."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .free_space import FreeSpace
from .options import FitOptions
from .parameters import ShapeParameters
from .problem import FitProblem
from .robust import robust_spread

MIN_POINTS = 50
"""Minimum number of points of a fit."""
MIN_EXTENT_RATIO = 1e-4
"""Minimum ratio of a cloud's singular values that counts as an extent."""
MAX_COORDINATE = 1e6
"""Larger coordinates leave too few digits for a solid, m."""
MAX_CAMERA_COORDINATE = 1e9
"""From a farther camera the rays are parallel, m."""
DEGENERATE_MARGIN = 6.0
"""A solid must beat a plane or a line by this difference of the criterion: strong evidence (Kass
and Raftery 1995), because noise makes a plane look thick."""
MAX_SPREAD_NOISE = 4.0
"""Maximum spread of the points about a usable solid, in expected noise ..."""
MAX_SPREAD_SIZE = 0.12
"""... or as a share of the radius of the cloud, whichever is larger."""
MAX_FAR_SHARE = 0.3
"""Maximum share of points farther than that from a usable solid."""
MAX_EXTENT_RATIO = 4.0
"""Maximum semi-axis of a usable solid over the radius of the cloud."""
BOUND_TOLERANCE = 0.05
"""A log semi-axis this close to its bound counts as at the bound."""
MAX_COVERED_SHARE = 0.08
"""Maximum share of the pixels of a usable solid in space seen to be empty. Good solids of household
objects cover up to 2 %, bad ones 14-90 %."""
MAX_COVERED_WITH_HOLE = 0.4
"""The same for several parts of an object with a hole that the view shows: few solids do not follow
the edge of a hole. Chosen on scissors: in 4 such views their parts cover 12-39 %, and the width is
right. It is right in the 3 such views of the other half too, clamps with 9-12 %. The wrong outline
remains a stated doubt."""
PLANE_PARAMETERS = 3
LINE_PARAMETERS = 4


def check_cloud(points: NDArray[np.float64], view_origin: NDArray[np.float64] | None) -> str:
    """Check numbers (N, 3) and the camera position (3,) before anything is computed from them."""
    if len(points) < MIN_POINTS:
        return f"{len(points)} points are too few: at least {MIN_POINTS} are needed"
    bad = int(np.count_nonzero(~np.all(np.isfinite(points), axis=1)))
    if bad:
        return f"{bad} points are NaN or infinite: leave out pixels without a reading"
    largest = float(np.abs(points).max())
    if largest > MAX_COORDINATE:
        return f"coordinates reach {largest:.3g} m: move the cloud nearer to the origin"
    if view_origin is not None and np.abs(view_origin).max() > MAX_CAMERA_COORDINATE:
        return f"the camera is {np.abs(view_origin).max():.3g} m away: are these metres?"
    return ""


def check_extent(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64] | None,
    plane: NDArray[np.float64] | None,
    options: FitOptions,
) -> str:
    """Check that a cloud (N, 3) without outliers determines a solid."""
    extents, _ = _principal(points)
    low, high = options.axis_range
    if np.ptp(points, axis=0).max() == 0.0:
        return "all points are the same point"
    if not low / 2 <= extents[0] <= 2 * high:
        return (
            f"the cloud spreads over {extents[0]:.3g} m (one σ): solids with semi-axes of "
            f"{low} to {high} m are fitted; are these metres?"
        )
    if extents[1] < MIN_EXTENT_RATIO * extents[0]:
        return "all points lie on one line"
    if extents[2] < MIN_EXTENT_RATIO * extents[0] and plane is None:
        return "all points lie on one plane: give the support plane, or another view"
    if len(points) < MIN_POINTS:
        return f"{len(points)} different points are too few: at least {MIN_POINTS} are needed"
    if view_origin is not None and np.linalg.norm(points - view_origin, axis=1).min() < low:
        return "a point lies at the camera: view_origin must be outside the cloud"
    if plane is None:
        return ""
    heights = points @ plane[:3] + plane[3]
    height = float(heights.mean())
    if abs(height) > 2 * high:
        return f"the support plane passes {abs(height):.3g} m from the cloud"
    if np.quantile(heights, 0.9) < 2.0 * options.noise:
        where = "in" if abs(height) <= 2.0 * options.noise else f"{-1e3 * height:.0f} mm under"
        return f"the points lie {where} the support plane: nothing rises from it"
    return ""


def check_not_flat(
    problem: FitProblem, criterion: float, has_plane: bool, options: FitOptions
) -> str:
    """Check that the best solid explains the points better than a plane or a line.

    On a support plane this always holds, because the plane gives a thin rod or a flat face its
    thickness. `criterion` is that of the best solid (:func:`model_selection.criterion`).
    """
    if has_plane:
        return ""
    squares = _principal(problem.points)[1] ** 2
    n, scale = problem.samples, problem.terms.cauchy_scale
    floor = 0.5 * options.noise / problem.unit
    limit = criterion + DEGENERATE_MARGIN
    max_square = (MAX_SPREAD_NOISE * options.noise / problem.unit) ** 2
    # A line has two directions of noise: take their mean, to compare with one surface normal.
    line = 0.5 * _robust_mean(squares[:, 1] + squares[:, 2], scale)
    line_wins = n * np.log(line + floor**2) + LINE_PARAMETERS * np.log(n) <= limit
    # A cloud thinner than the noise is a line even if the edge of a solid follows it closer.
    if line < (options.noise / problem.unit) ** 2 or (2.0 * line < max_square and line_wins):
        width = 1e3 * problem.unit * float(np.sqrt(line))
        return f"all points lie on one line to within {width:.1f} mm"
    plane = _robust_mean(squares[:, 2], scale)
    plane_wins = n * np.log(plane + floor**2) + PLANE_PARAMETERS * np.log(n) <= limit
    if plane < max_square and plane_wins:
        width = 1e3 * problem.unit * float(np.sqrt(plane))
        return (
            f"all points lie on one plane to within {width:.1f} mm: give the support plane, or "
            "another view"
        )
    return ""


def check_residuals(residuals: NDArray[np.float64], radius: float, options: FitOptions) -> str:
    """Check the residuals (M,), m, of a solid for a cloud of RMS radius `radius`, m."""
    spread = robust_spread(residuals)
    limit = max(MAX_SPREAD_NOISE * options.noise, MAX_SPREAD_SIZE * radius)
    if spread > limit:
        return (
            f"points spread {spread * 1e3:.1f} mm about the best solid, more than "
            f"{limit * 1e3:.1f} mm: is the cloud one solid?"
        )
    far = float(np.mean(np.abs(residuals) > limit))
    if far > MAX_FAR_SHARE:
        return (
            f"{100 * far:.0f} % of the points lie more than {limit * 1e3:.1f} mm from the best "
            "solid: is the cloud one solid?"
        )
    return ""


def check_size(shape: ShapeParameters, problem: FitProblem, options: FitOptions) -> str:
    """Check that the points determine the size of a solid."""
    low, high = np.log(np.array(options.axis_range) / problem.unit)
    radius = float(np.sqrt(np.sum(problem.points**2, axis=1).max()))
    if np.exp(shape.log_axes.max()) > MAX_EXTENT_RATIO * radius:
        return f"an extent grew to over {MAX_EXTENT_RATIO:g} times what was seen"
    if np.any(shape.log_axes >= high - BOUND_TOLERANCE):
        return f"an extent grew to its bound of {options.axis_range[1]} m: too little was seen"
    if np.any(shape.log_axes <= low + BOUND_TOLERANCE):
        return f"an extent shrank to its bound of {options.axis_range[0]} m: too little was seen"
    return ""


def check_covered_share(share: float, free_space: FreeSpace, parts: int) -> str:
    """Check the share of the pixels of so many parts in space seen to be empty outside holes."""
    # Most solids cover less, so that no hole needs to be searched.
    if share <= MAX_COVERED_SHARE:
        return ""
    holes = free_space.hole_share
    if holes > 0.0 and parts > 1 and share <= MAX_COVERED_WITH_HOLE:
        return ""
    why = "is the object bent, branched or several objects?"
    if holes > 0.0:
        why = f"the object has a hole, {100 * holes:.0f} % of its pixels"
    return f"{100 * share:.0f} % of the solid lies where the view shows empty space: {why}"


def _principal(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return standard deviations (3,) along the principal axes, largest first, and coordinates."""
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    coordinates = centred @ axes[:, ::-1]
    return np.sqrt(np.mean(coordinates**2, axis=0)), coordinates


def _robust_mean(squares: NDArray[np.float64], scale: float) -> float:
    """Return twice the mean Cauchy cost of squared distances (N,)."""
    return float(np.mean(scale**2 * np.log1p(squares / scale**2)))
