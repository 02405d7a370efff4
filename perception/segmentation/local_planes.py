"""A plane in disparity around every pixel, fitted to windows that do not cross an edge.

In disparity q = 1/z a plane in space is linear in pixel coordinates. The noise of stereo and
structured light in disparity does not depend on distance, so one threshold fits the whole image.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..frame import CameraIntrinsics
from ..thread_pool import map_in_threads
from .options import SegmentationOptions
from .working_image import WorkingImage

GOOD_FIT = 2.0
"""Maximum squared error of a centred window, in σ², at which no shifted window is tried."""
SHIFT_GAIN = 0.6
"""A shifted window must have an error below this share of the centred one's. A lower value keeps
windows centred (smoother), a higher one makes creases sharper (noisier)."""
MIN_WINDOW_SHARE = 0.3
"""Minimum share of a window's pixels with readings. A plane through fewer is unreliable."""
STEP_SIGMAS = 6.0
"""Minimum step in disparity between two separate surfaces, in σ. A lower value splits noisy
surfaces, a higher one joins surfaces across small steps."""
CREASE_SIGMAS = 18.0
"""Maximum change of slope at a crease, in σ per px. A larger change counts as a step. A lower value
separates faces seen at a grazing angle, a higher one joins what is behind a round rim."""

MIN_ROWS = 32
"""Minimum rows of a band. The overhead of a smaller band exceeds the time that it saves."""


class LocalPlanes(NamedTuple):
    """Per-pixel planes ``q(u', v') = value + slope_u (u'-u) + slope_v (v'-v)``, without NaN."""

    value: NDArray[np.float32]
    """Disparity of the plane at the pixel, (H, W), 1/m; 0 = no plane."""
    slope_u: NDArray[np.float32]
    """Slope along columns, (H, W), 1/(m px)."""
    slope_v: NDArray[np.float32]
    """Slope along rows, (H, W), 1/(m px)."""
    rms: NDArray[np.float32]
    """Residual of the window centred on the pixel, (H, W), 1/m; -1 = no plane."""


def fit_local_planes(image: WorkingImage, options: SegmentationOptions) -> LocalPlanes:
    """Fit a plane in disparity around every pixel by least squares.

    With ``shift_windows`` the window may be shifted to one of eight sides where this fits the
    pixel clearly better (Kuwahara et al. 1976).
    """
    radius = options.window // 2
    centred = LocalPlanes(
        *run_in_row_bands(
            lambda q: fit_centred_windows(q, radius, MIN_WINDOW_SHARE),
            (image.disparity,),
            radius,
            options.threads,
        )
    )
    if not options.shift_windows:
        return centred
    value, slope_u, slope_v = run_in_row_bands(
        lambda q, *planes: select_windows(q, LocalPlanes(*planes), radius, image.noise, SHIFT_GAIN),
        (image.disparity, *centred),
        radius,
        options.threads,
    )
    return LocalPlanes(value, slope_u, slope_v, centred.rms)


def plane_normals(planes: LocalPlanes, camera: CameraIntrinsics) -> NDArray[np.float32]:
    """Return the unit normals towards the camera, (H, W, 3) float32; 0 where there is no plane.

    A plane n·X = 1 in space has q = n·(x/z, y/z, 1). So its value and slopes determine n.
    """
    return _normals(planes, (camera.fx, camera.fy, camera.cx, camera.cy))


@njit(cache=True, nogil=True)
def fit_centred_windows(q, radius, min_share):
    """Fit a plane to the window around each pixel; return value, slopes and rms as `LocalPlanes`.

    Each step moves the running sums of the window by one row or column. It shifts their origin
    by one pixel before it adds and removes readings.
    """
    rows, columns = q.shape
    value = np.zeros((rows, columns), np.float32)
    slope_u = np.zeros((rows, columns), np.float32)
    slope_v = np.zeros((rows, columns), np.float32)
    rms = np.full((rows, columns), np.float32(-1.0))
    min_count = max(min_share * (2 * radius + 1) ** 2, 4.0)
    sums, moments = np.zeros((6, columns)), np.zeros((10, columns))
    for v in range(-radius, rows):
        _move_column_sums(q, v, radius, sums)
        if v >= 0:
            _sum_windows(sums, radius, moments)
            _fit_row(q[v], min_count, moments, (value[v], slope_u[v], slope_v[v], rms[v]))
    return value, slope_u, slope_v, rms


@njit(cache=True, nogil=True)
def _move_column_sums(q, v, radius, sums):
    """Move the sums over each column of the window (6, W) to row v: of 1, v, v², q, v q, q²."""
    n, sv, svv, sq, svq = sums[0], sums[1], sums[2], sums[3], sums[4]
    for u in range(len(n)):
        svv[u] += n[u] - 2.0 * sv[u]
        sv[u] -= n[u]
        svq[u] -= sq[u]
    if v + radius < len(q):
        _add_row(q[v + radius], 1.0, np.float64(radius), sums)
    if v - radius - 1 >= 0:
        _add_row(q[v - radius - 1], -1.0, -radius - 1.0, sums)


@njit(cache=True, nogil=True)
def _add_row(q, sign, offset, sums):
    """Add one row of disparities (W,) to the column sums, `offset` rows below the centre."""
    n, sv, svv, sq, svq, sqq = sums[0], sums[1], sums[2], sums[3], sums[4], sums[5]
    # Without branches the compiler handles several columns at once. 0 is no reading.
    for u in range(len(q)):
        x = np.float64(q[u])
        one = sign if x > 0 else 0.0
        n[u] += one
        sv[u] += one * offset
        svv[u] += one * (offset * offset)
        sq[u] += sign * x
        svq[u] += sign * (offset * x)
        sqq[u] += sign * (x * x)


@njit(cache=True, nogil=True)
def _sum_windows(sums, radius, moments):
    """Compute the sums over the windows of one row, (10, W), as `_fit_row` takes them."""
    columns = sums.shape[1]
    n, sv, svv, sq, svq, sqq = sums[0], sums[1], sums[2], sums[3], sums[4], sums[5]
    tn = tv = tvv = tq = tvq = tqq = tu = tuu = tuv = tuq = 0.0
    for u in range(-radius, columns):
        tuu += tn - 2.0 * tu
        tuv -= tv
        tuq -= tq
        tu -= tn
        right, left = u + radius, u - radius - 1
        if right < columns:
            tn += n[right]
            tv += sv[right]
            tvv += svv[right]
            tq += sq[right]
            tvq += svq[right]
            tqq += sqq[right]
            tu += radius * n[right]
            tuu += radius * radius * n[right]
            tuv += radius * sv[right]
            tuq += radius * sq[right]
        if left >= 0:
            offset = -radius - 1.0
            tn -= n[left]
            tv -= sv[left]
            tvv -= svv[left]
            tq -= sq[left]
            tvq -= svq[left]
            tqq -= sqq[left]
            tu -= offset * n[left]
            tuu -= offset * offset * n[left]
            tuv -= offset * sv[left]
            tuq -= offset * sq[left]
        if u >= 0:
            moments[0, u], moments[1, u], moments[2, u] = tn, tu, tv
            moments[3, u], moments[4, u], moments[5, u] = tuu, tvv, tuv
            moments[6, u], moments[7, u], moments[8, u], moments[9, u] = tq, tuq, tvq, tqq


@njit(cache=True, nogil=True, error_model="numpy")
def _fit_row(q, min_count, moments, planes):
    """Fit the planes of one row of pixels from the sums over their windows."""
    n, su, sv, suu, svv = moments[0], moments[1], moments[2], moments[3], moments[4]
    suv, sq, suq, svq, sqq = moments[5], moments[6], moments[7], moments[8], moments[9]
    value, slope_u, slope_v, rms = planes
    for u in range(len(q)):
        of_window = su[u], sv[u], suu[u], svv[u], suv[u], sq[u], suq[u], svq[u], sqq[u]
        fitted, at, along_u, along_v, residual = plane_of_moments(max(n[u], 1.0), of_window)
        fitted &= (n[u] >= min_count) & (q[u] > 0)
        value[u] = at if fitted else 0.0
        slope_u[u] = along_u if fitted else 0.0
        slope_v[u] = along_v if fitted else 0.0
        rms[u] = residual if fitted else -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def plane_of_moments(n, moments):
    """Return whether the sums of n readings determine a plane; its value, slopes and rms residual.

    `moments` holds the sums of u, v, u², v², u v, q, u q, v q and q² about the window's centre.
    """
    su, sv, suu, svv, suv, sq, suq, svq, sqq = moments
    share = 1.0 / n
    mu, mv, mq = su * share, sv * share, sq * share
    cuu, cvv, cuv = suu * share - mu * mu, svv * share - mv * mv, suv * share - mu * mv
    cuq, cvq = suq * share - mu * mq, svq * share - mv * mq
    determinant = cuu * cvv - cuv * cuv
    fitted = (determinant >= 1e-3 * cuu * cvv) & (cuu >= 0.1) & (cvv >= 0.1)
    scale = 1.0 / (determinant if fitted else 1.0)
    b = (cuq * cvv - cvq * cuv) * scale
    c = (cvq * cuu - cuq * cuv) * scale
    residual = sqq * share - mq * mq - b * cuq - c * cvq
    return fitted, mq - b * mu - c * mv, b, c, np.sqrt(max(residual, 0.0))


@njit(cache=True, nogil=True)
def select_windows(q, planes, radius, noise, gain):
    """Return value and slopes of the best window, where a shifted one is clearly better."""
    value, slope_u, slope_v, rms = planes.value, planes.slope_u, planes.slope_v, planes.rms
    rows, columns = q.shape
    new_value, new_u, new_v = value.copy(), slope_u.copy(), slope_v.copy()
    for v in range(rows):
        for u in range(columns):
            here = q[v, u]
            if here <= 0:
                continue
            best = np.float32(1e9)
            if rms[v, u] >= 0:
                error = value[v, u] - here
                best = rms[v, u] * rms[v, u] + error * error
                if best < GOOD_FIT * noise * noise:
                    continue
                best *= gain * gain
            for dv in (-radius, 0, radius):
                for du in (-radius, 0, radius):
                    y, x = v + dv, u + du
                    if y < 0 or x < 0 or y >= rows or x >= columns or rms[y, x] < 0:
                        continue
                    at = value[y, x] - slope_u[y, x] * du - slope_v[y, x] * dv
                    error = at - here
                    cost = rms[y, x] * rms[y, x] + error * error
                    if cost < best:
                        best = cost
                        new_value[v, u] = at
                        new_u[v, u] = slope_u[y, x]
                        new_v[v, u] = slope_v[y, x]
    return new_value, new_u, new_v


@njit(cache=True, nogil=True)
def _normals(planes, pinhole):
    rows, columns = planes.value.shape
    normals = np.empty((rows, columns, 3), np.float32)
    row = np.empty((3, columns), np.float32)
    u_from_centre = np.arange(columns) - pinhole[2]
    for v in range(rows):
        row_normals(planes, v, pinhole, u_from_centre, row)
        for u in range(columns):
            normals[v, u, 0], normals[v, u, 1], normals[v, u, 2] = row[0, u], row[1, u], row[2, u]
    return normals


@njit(cache=True, nogil=True, error_model="numpy")
def row_normals(planes, v, pinhole, u_from_centre, normals):
    """Write the unit normals of row v to an array (3, W) float32, 0 where there is no plane.

    `u_from_centre` holds the distances of the columns from the principal point, (W,), px.
    """
    fx, fy, _, cy = pinhole
    value, slope_u, slope_v = planes.value[v], planes.slope_u[v], planes.slope_v[v]
    first, second, third = normals[0], normals[1], normals[2]
    v_from_centre = v - cy
    # Without branches the compiler handles several pixels at once.
    for u in range(len(value)):
        x, y = slope_u[u] * fx, slope_v[u] * fy
        z = value[u] - slope_u[u] * u_from_centre[u] - slope_v[u] * v_from_centre
        scale = -1.0 / np.sqrt(x * x + y * y + z * z)
        scale = scale if value[u] > 0 else 0.0
        first[u], second[u], third[u] = x * scale, y * scale, z * scale


def run_in_row_bands(
    function: Callable[..., tuple[NDArray, ...]],
    images: Sequence[NDArray],
    overlap: int,
    threads: int,
) -> tuple[NDArray, ...]:
    """Run ``function(*images)`` on bands of rows and join the results.

    Parameters
    ----------
    function
        Takes images (H, ...) and returns images with the same number of rows. Row v of a result
        may depend only on the rows from v - overlap to v + overlap. The bands run in parallel
        only if it releases the interpreter's lock (numba: ``nogil``). Threads of this kind cost
        microseconds; numba's own threading layers cost milliseconds on a loaded machine.
    images
        Arguments of `function`, all with the same number of rows.
    overlap
        Rows on each side that a row of the result depends on.
    threads
        Maximum number of bands.

    Returns
    -------
    tuple of NDArray
        The result of one call on the whole images.
    """
    rows = images[0].shape[0]
    bands = min(threads, rows // MIN_ROWS)
    if bands < 2:
        return function(*images)
    edges = np.linspace(0, rows, bands + 1).round().astype(int)

    def run(k: int) -> tuple[NDArray, ...]:
        first, last = max(edges[k] - overlap, 0), min(edges[k + 1] + overlap, rows)
        results = function(*(image[first:last] for image in images))
        return tuple(result[edges[k] - first : edges[k + 1] - first] for result in results)

    parts = map_in_threads(run, range(bands), bands)
    return tuple(np.concatenate(images) for images in zip(*parts, strict=True))
