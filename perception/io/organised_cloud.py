"""Conversion between depth frames and organised clouds, which have one point per pixel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from ..frame import CameraIntrinsics, DepthFrame
from .point_table import PointTable

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .intrinsics import CameraFile

MAX_PIXEL_ERROR = 1.0
"""Maximum distance, px, between a point's projection and its pixel in a pinhole image."""

JUDGED_SHARE_PCT = 95.0
"""Minimum share of points within `MAX_PIXEL_ERROR`. The others may be outliers of stereo."""

OUTLIER_DEVIATIONS = 3.0
"""Points that miss their pixel by more robust standard deviations are outliers of the fit."""

MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""

MIN_SLOPE_PER_PIXEL = 1e-6
"""Minimum increase of x/z per column. It corresponds to a focal length of a million pixels."""

FIT_ROUNDS = 20
"""Maximum rounds of fitting and outlier removal. Real clouds need 2 to 6."""


def frame_from_grid(table: PointTable, camera: CameraFile | None = None) -> DepthFrame:
    """Convert an organised cloud in the camera's optical frame to a depth frame.

    Parameters
    ----------
    table : PointTable
        One point per pixel, row by row; a NaN coordinate or z = 0 means no reading.
    camera : CameraFile, optional
        The camera, when it is known; it must project the points onto their pixels. Without it
        the intrinsics are recovered from the points.

    Raises
    ------
    InputError
        If the cloud is not organised, lies behind the camera, or is no pinhole image; see also
        `DepthFrame`.
    """
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


def grid_from_frame(frame: DepthFrame) -> PointTable:
    """Convert a frame to an organised cloud, camera frame, float32, NaN = no reading."""
    depth = np.where(frame.valid, frame.depth, np.nan)
    points = frame.intrinsics.rays() * depth[..., None]
    colours = None if frame.colour is None else frame.colour.reshape(-1, 3)
    height, width = depth.shape
    return PointTable(points.astype(np.float32).reshape(-1, 3), colours, width, height)


def recover_intrinsics(points: NDArray[np.floating]) -> CameraIntrinsics:
    """Compute the pinhole camera that projects each point of an organised cloud to its pixel.

    The model ``u = fx x/z + cx``, ``v = fy y/z + cy`` is fitted by linear least squares with the
    pixel as the independent variable (it is exact, x/z is measured), outliers being left out
    by their median absolute deviation until the set no longer changes, from a resistant line on.

    Parameters
    ----------
    points : (H, W, 3) float array
        Points in the camera's optical frame, m or any unit; NaN or z = 0 means no reading.

    Raises
    ------
    InputError
        If the readings lie in fewer than two columns or rows, or 5 % of them miss their pixel by
        more than `MAX_PIXEL_ERROR`.
    """
    height, width = points.shape[:2]
    u, v, x_z, y_z = _pixels_and_slopes(points)
    fx, cx = _fit_axis(u, x_z, "column", "x")
    fy, cy = _fit_axis(v, y_z, "row", "y")
    intrinsics = CameraIntrinsics(fx, fy, cx, cy, width, height)
    _check_projection(points, intrinsics)
    return intrinsics


def check_organised(table: PointTable) -> None:
    """Check that the points of a cloud form a pixel grid.

    Raises
    ------
    InputError
        If there is a single row, or the grid's size is not the number of points.
    """
    count = len(table.points)
    if table.width <= 1 or table.height <= 1:
        raise InputError(
            f"the cloud is not organised ({count} points, width {table.width or 'not given'}, "
            f"height {table.height}): a frame needs one point per pixel; "
            "for the cloud of one object use `eyehand fit`"
        )
    if table.width * table.height != count:
        raise InputError(
            f"the cloud says {table.width}x{table.height} px but holds {count} points, "
            f"expected {table.width * table.height}"
        )


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
            f"the readings lie in a single {line}, from which no camera can be found: "
            "give camera intrinsics"
        )
    per_pixel, offset = _resistant_line(pixel, slope)
    kept = np.zeros(len(pixel), dtype=bool)
    for _ in range(FIT_ROUNDS):
        # The negated comparison also rejects NaN.
        if not per_pixel > MIN_SLOPE_PER_PIXEL:
            raise InputError(
                f"the cloud is not a pinhole image in the camera frame: {axis}/z does not grow "
                f"with the {line}; expected x right, y down, z forward"
            )
        with np.errstate(over="ignore", invalid="ignore"):
            error = np.abs((slope - offset) / per_pixel - pixel)
        deviation = MAD_TO_SIGMA * float(np.median(error))
        settled = kept
        # Within the error allowed nothing is an outlier: leaving out the far, noisier points of a
        # good cloud would bias the camera.
        kept = error <= max(OUTLIER_DEVIATIONS * deviation, MAX_PIXEL_ERROR)
        if np.array_equal(kept, settled) or np.unique(pixel[kept]).size < 2:
            break
        per_pixel, offset = np.polynomial.polynomial.polyfit(pixel[kept], slope[kept], 1)[::-1]
    return float(1.0 / per_pixel), float(-offset / per_pixel)


def _resistant_line(at: NDArray[np.float64], value: NDArray[np.float64]) -> tuple[float, float]:
    """Fit a line through the medians of the outer thirds (Tukey, 1977); return slope and offset.

    If more than a third of the points share one abscissa, halves replace the thirds.
    """
    low, high = np.quantile(at, (1 / 3, 2 / 3))
    left, right = at <= low, at >= high
    if low == high:
        left, right = at < at.mean(), at > at.mean()
    step = float(np.median(at[right]) - np.median(at[left]))
    with np.errstate(over="ignore", invalid="ignore"):
        gradient = float(np.median(value[right]) - np.median(value[left])) / step
        return gradient, float(np.median(value - gradient * at))


def _check_projection(points: NDArray[np.floating], intrinsics: CameraIntrinsics) -> None:
    u, v, x_z, y_z = _pixels_and_slopes(points)
    with np.errstate(over="ignore", invalid="ignore"):
        error = np.hypot(
            intrinsics.fx * x_z + intrinsics.cx - u, intrinsics.fy * y_z + intrinsics.cy - v
        )
        judged = float(np.percentile(error, JUDGED_SHARE_PCT))
    if not judged <= MAX_PIXEL_ERROR:
        raise InputError(
            f"the cloud is not a pinhole image in the camera frame: the points miss their pixels "
            f"by up to {judged:.3g} px at fx={intrinsics.fx:.5g}, fy={intrinsics.fy:.5g}, "
            f"cx={intrinsics.cx:.5g}, cy={intrinsics.cy:.5g}, expected <= {MAX_PIXEL_ERROR:g} px"
        )
