"""Conversion between depth frames and clouds. An organised cloud has one point per pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..frame import CameraIntrinsics, DepthFrame
from .intrinsics import CameraFile
from .point_table import PointTable

MAX_PIXEL_ERROR = 1.0
"""Maximum distance, px, between a point's projection and its pixel in a pinhole image."""

INLIER_PERCENT = 95.0
"""Minimum percentage of points within `MAX_PIXEL_ERROR`. The others may be outliers of stereo."""

OUTLIER_DEVIATIONS = 3.0
"""Pixel error, in robust standard deviations, above which a point is excluded from the fit."""

MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""

MIN_SLOPE = 1e-6
"""Minimum increase of x/z per column. It corresponds to a focal length of a million pixels."""

MAX_GRID_ERROR = 0.2
"""Maximum median distance, px, of projected points from the middles of pixels, along rows and
along columns. It is 0.25 for points that do not come from the pixels of the camera."""

MIN_NEIGHBOURS = 0.6
"""Minimum share of the pixels around the points that have a point too. Thinned clouds have fewer,
and their objects are lost or cut: with 0.31 of the pixels 33 of 80 were not found."""

MAX_FITS = 20
"""Maximum number of line fits, with outliers removed between them. Real clouds need 2 to 6."""


def frame_from_cloud(table: PointTable, camera: CameraFile | None = None) -> DepthFrame:
    """Convert a cloud in the camera's optical frame to a depth frame.

    Parameters
    ----------
    table : PointTable
        One point per pixel, row by row; a NaN coordinate or z = 0 means no reading. A cloud
        without a grid, whose points may have any order, needs `camera`.
    camera : CameraFile, optional
        The camera, if it is known. It must project the points onto their pixels. If None, the
        intrinsics are computed from the points.

    Raises
    ------
    InputError
        If the cloud has neither a grid nor a camera, has no reading or a point behind the camera,
        or is not a pinhole image. `DepthFrame` makes further checks.
    """
    if camera is not None and not has_grid(table):
        table = table_on_grid(table, camera.intrinsics)
    check_organised(table)
    points = table.points.reshape(table.height, table.width, 3)
    valid = np.isfinite(points).all(axis=-1)
    depth = np.where(valid, points[..., 2], 0.0)
    if (depth < 0).any():
        raise InputError(
            f"{np.count_nonzero(depth < 0)} points lie behind the camera (lowest z "
            f"{depth.min():.4g} m): expected the optical frame, x right, y down, z forward"
        )
    if not (depth > 0).any():
        raise InputError("no point has a reading: every z is NaN or 0")
    if camera is None:
        intrinsics, pose = recover_intrinsics(points), None
    else:
        intrinsics, pose = camera.intrinsics, camera.T_world_camera
        _check_projection(points, intrinsics)
    with np.errstate(over="ignore"):
        depth = depth.astype(np.float32)
    colour = None
    if table.colours is not None:
        colour = table.colours.reshape(table.height, table.width, 3)
    return DepthFrame(depth, intrinsics, pose, colour)


def cloud_from_frame(frame: DepthFrame) -> PointTable:
    """Convert a frame to an organised float32 cloud in the camera frame; NaN means no reading."""
    depth = np.where(frame.valid, frame.depth, np.nan)
    points = frame.intrinsics.rays() * depth[..., None]
    colours = None if frame.colour is None else frame.colour.reshape(-1, 3)
    height, width = depth.shape
    return PointTable(points.astype(np.float32).reshape(-1, 3), colours, width, height)


def recover_intrinsics(points: NDArray[np.floating]) -> CameraIntrinsics:
    """Compute the pinhole camera that projects each point of an organised cloud to its pixel.

    The model ``u = fx x/z + cx``, ``v = fy y/z + cy`` is fitted by linear least squares. The pixel
    is the independent variable, because it is exact and x/z is measured. The first line is a robust
    fit through medians. Then outliers are excluded by the median absolute deviation, and the line
    is fitted again, until the set of inliers does not change.

    Parameters
    ----------
    points : (H, W, 3) float array
        Points in the camera's optical frame, m or any unit; NaN or z = 0 means no reading.

    Raises
    ------
    InputError
        If the readings lie in fewer than two columns or rows, if x/z does not grow with the column
        or y/z with the row, or if more than 5 % of the readings miss their pixel by more than
        `MAX_PIXEL_ERROR`.
    """
    height, width = points.shape[:2]
    u, v, x_z, y_z = _pixels_and_slopes(points)
    fx, cx = _fit_axis(u, x_z, "column", "x")
    fy, cy = _fit_axis(v, y_z, "row", "y")
    intrinsics = CameraIntrinsics(fx, fy, cx, cy, width, height)
    _check_projection(points, intrinsics)
    return intrinsics


def table_on_grid(table: PointTable, intrinsics: CameraIntrinsics) -> PointTable:
    """Assign the points of a cloud to the pixels of the camera that measured them.

    The order of the points does not matter, and pixels without a reading may be missing. Of two
    points on one pixel, the nearer one is kept.

    Parameters
    ----------
    table : PointTable
        Points in the camera's optical frame, m.
    intrinsics : CameraIntrinsics
        The camera.

    Raises
    ------
    InputError
        If at most half of the points lie in the image, they do not lie at the middles of pixels,
        or the cloud was thinned.
    """
    k = intrinsics
    read = np.flatnonzero(np.isfinite(table.points).all(axis=1) & (table.points[:, 2] != 0))
    x, y, z = table.points[read].astype(np.float64).T
    with np.errstate(over="ignore"):
        u, v = k.fx * x / z + k.cx, k.fy * y / z + k.cy
    inside = (z > 0) & (np.abs(u - (k.width - 1) / 2) < k.width / 2)
    inside &= np.abs(v - (k.height - 1) / 2) < k.height / 2
    if not np.count_nonzero(inside) > len(read) / 2:
        raise InputError(
            f"{np.count_nonzero(inside)} of {len(read)} points lie in the image of the camera: "
            "expected its optical frame, x right, y down, z forward"
        )
    nearest_last = np.flatnonzero(inside)[np.argsort(-z[inside], kind="stable")]
    u, v, index = u[nearest_last], v[nearest_last], read[nearest_last]
    column, row = np.rint(u).astype(int), np.rint(v).astype(int)
    points = np.full((k.height, k.width, 3), np.nan, dtype=table.points.dtype)
    points[row, column] = table.points[index]
    filled = np.pad(np.isfinite(points[..., 2]).astype(np.int8), 1)
    beside = [np.roll(filled, shift, axis) for axis in (0, 1) for shift in (-1, 1)]
    around: NDArray[np.int8] = np.sum(beside, axis=0)
    share = float(around[filled > 0].mean()) / 4.0
    if share < MIN_NEIGHBOURS:
        raise InputError(
            f"the points have a neighbour on {100 * share:.0f} % of the pixels beside them, "
            f"expected >= {100 * MIN_NEIGHBOURS:g} %: give the cloud before it was thinned, for "
            "example by voxels, and the intrinsics of its resolution"
        )
    error = float(max(np.median(np.abs(u - column)), np.median(np.abs(v - row))))
    if error > MAX_GRID_ERROR:
        raise InputError(
            f"the points lie {error:.2f} px from the middles of the camera's pixels (median), "
            f"expected <= {MAX_GRID_ERROR:g} px: give the intrinsics of the camera that measured "
            "them, and points that were neither moved nor rounded"
        )
    colours = None
    if table.colours is not None:
        colours = np.zeros((k.height, k.width, 3), dtype=np.uint8)
        colours[row, column] = table.colours[index]
        colours = colours.reshape(-1, 3)
    return PointTable(points.reshape(-1, 3), colours, k.width, k.height)


def check_organised(table: PointTable) -> None:
    """Check that the points of a cloud form a pixel grid.

    Raises
    ------
    InputError
        If there is a single row or column, or the size of the grid is not the number of points.
    """
    count = len(table.points)
    if not has_grid(table):
        raise InputError(
            f"the cloud has no pixel grid ({count} points, width {table.width or 'not given'}, "
            f"height {table.height}): give the file of the camera that measured it (--camera, in "
            "Python camera=); for the cloud of one object use `eyehand fit`"
        )
    if table.width * table.height != count:
        raise InputError(
            f"the cloud declares {table.width}x{table.height} px but holds {count} points, "
            f"expected {table.width * table.height}"
        )


def has_grid(table: PointTable) -> bool:
    """Return whether the file of a cloud gives the size of a pixel grid."""
    return table.width > 1 and table.height > 1


def _pixels_and_slopes(points: NDArray[np.floating]) -> tuple[NDArray[np.float64], ...]:
    valid = np.isfinite(points).all(axis=-1) & (points[..., 2] > 0)
    v, u = np.nonzero(valid)
    x, y, z = points[valid].astype(np.float64).T
    with np.errstate(over="ignore"):
        return u.astype(np.float64), v.astype(np.float64), x / z, y / z


def _fit_axis(
    pixel: NDArray[np.float64], slope: NDArray[np.float64], line: str, axis: str
) -> tuple[float, float]:
    """Fit focal length and principal point, px, of ``pixel = focal * slope + centre``."""
    if np.unique(pixel).size < 2:
        raise InputError(
            f"the readings lie in a single {line}, so the camera cannot be computed: "
            "pass camera intrinsics"
        )
    per_pixel, offset = _median_line(pixel, slope)
    kept = np.zeros(len(pixel), dtype=bool)
    for _ in range(MAX_FITS):
        # The negated comparison also rejects NaN.
        if not per_pixel > MIN_SLOPE:
            raise InputError(
                f"the cloud is not a pinhole image in the camera frame: {axis}/z does not grow "
                f"with the {line}; expected x right, y down, z forward"
            )
        with np.errstate(over="ignore", invalid="ignore"):
            error = np.abs((slope - offset) / per_pixel - pixel)
        deviation = MAD_TO_SIGMA * float(np.median(error))
        previous = kept
        # A point within MAX_PIXEL_ERROR is never an outlier. In a good cloud the far points are
        # the noisier ones, and a fit without them would be biased.
        kept = error <= max(OUTLIER_DEVIATIONS * deviation, MAX_PIXEL_ERROR)
        if np.array_equal(kept, previous) or np.unique(pixel[kept]).size < 2:
            break
        per_pixel, offset = np.polynomial.polynomial.polyfit(pixel[kept], slope[kept], 1)[::-1]
    return float(1.0 / per_pixel), float(-offset / per_pixel)


def _median_line(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float]:
    """Fit a line through the medians of the outer thirds (Tukey, 1977); return slope and offset.

    If both limits of the outer thirds are the same x, the points below and above the mean are used
    instead.
    """
    low, high = np.quantile(x, (1 / 3, 2 / 3))
    left, right = x <= low, x >= high
    if low == high:
        left, right = x < x.mean(), x > x.mean()
    step = float(np.median(x[right]) - np.median(x[left]))
    with np.errstate(over="ignore", invalid="ignore"):
        slope = float(np.median(y[right]) - np.median(y[left])) / step
        return slope, float(np.median(y - slope * x))


def _check_projection(points: NDArray[np.floating], intrinsics: CameraIntrinsics) -> None:
    u, v, x_z, y_z = _pixels_and_slopes(points)
    with np.errstate(over="ignore", invalid="ignore"):
        error = np.hypot(
            intrinsics.fx * x_z + intrinsics.cx - u, intrinsics.fy * y_z + intrinsics.cy - v
        )
        error_percentile = float(np.percentile(error, INLIER_PERCENT))
    if not error_percentile <= MAX_PIXEL_ERROR:
        raise InputError(
            "the cloud is not a pinhole image in the camera frame: "
            f"{100.0 - INLIER_PERCENT:g} % of the points miss their pixels by at least "
            f"{error_percentile:.3g} px at fx={intrinsics.fx:.5g}, fy={intrinsics.fy:.5g}, "
            f"cx={intrinsics.cx:.5g}, cy={intrinsics.cy:.5g}, expected <= {MAX_PIXEL_ERROR:g} px"
        )
