"""Compiled residuals of a superquadric and their exact derivatives.

The residual of a point is its first-order normal distance r = (G - 1)/‖∇G‖ with the gauge
G = F^(ε1/2) (Sampson 1982 on the function of Solina and Bajcsy 1990). With h = log G, shares
p = ∂h/∂(log x, log y, log z) and n = ‖p/x‖ it reads r = (1 - e^-h)/n: all in logarithms, so that
exponents down to 0.02 neither overflow nor lose digits.

Parameters are ordered log a1, log a2, log a3, ε1, ε2, a rotation vector and a translation, the
last two in the solid's own axes: R ← R exp(δ), c ← c + R τ.
"""

from __future__ import annotations

import numpy as np
from numba import njit

PARAMETERS = 11
"""Length of the full parameter vector."""

_SMALL = 1e-7
_RAY_ITERATIONS = 60
_RAY_TOLERANCE = 1e-7
_BALL = 1.8  # every superquadric fits into a ball of sqrt(3) times its largest semi-axis


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def normal_equations(
    points,
    weights,
    rays,
    plane,
    origin,
    axes,
    eps,
    R,
    c,
    scale,
    ray_weight,
    plane_weight,
    plane_scale,
):
    """Robust cost with gradient (11,) and Gauss-Newton Hessian (11, 11) in one pass.

    Parameters
    ----------
    points
        (N, 3) cloud; `weights` (N,) sum to 1.
    rays
        (K, 3) unit directions from `origin` that the solid must not cross; K may be 0.
    plane
        (4,) support plane normal and offset; used when `plane_weight` > 0.
    axes, eps, R, c
        Logarithms of the semi-axes (3,), exponents (2,), rotation (3, 3), centre (3,).
    scale, plane_scale
        Cauchy scales of point and plane residuals, in the cloud's unit.

    Notes
    -----
    The cost is Σ w s²/2 log(1 + r²/s²) over points, plus the mean squared depth by which rays
    enter the solid, plus the Cauchy cost of the gap between solid and support plane.
    """
    cost = 0.0
    gradient = np.zeros(PARAMETERS)
    hessian = np.zeros((PARAMETERS, PARAMETERS))
    row = np.empty(PARAMETERS)
    local = np.empty(3)
    for i in range(points.shape[0]):
        _to_local(points[i, 0], points[i, 1], points[i, 2], R, c, local)
        r = distance_row(local, axes, eps, row)
        cost += weights[i] * _cauchy(r, scale)
        _accumulate(gradient, hessian, row, r, weights[i] / (1.0 + (r / scale) ** 2))
    if rays.shape[0] > 0 and ray_weight > 0.0:
        share = ray_weight / rays.shape[0]
        for i in range(rays.shape[0]):
            depth = _ray_row(rays[i], origin, axes, eps, R, c, row, local)
            if depth > 0.0:
                cost += share * 0.5 * depth * depth
                _accumulate(gradient, hessian, row, depth, share)
    if plane_weight > 0.0:
        gap = _plane_row(plane, axes, eps, R, c, row, local)
        cost += plane_weight * _cauchy(gap, plane_scale)
        _accumulate(gradient, hessian, row, gap, plane_weight / (1.0 + (gap / plane_scale) ** 2))
    for j in range(PARAMETERS):
        for k in range(j):
            hessian[k, j] = hessian[j, k]
    return cost, gradient, hessian


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def distances(points, axes, eps, R, c):
    """First-order signed distances (N,) of points (N, 3)."""
    out = np.empty(points.shape[0])
    row = np.empty(PARAMETERS)
    local = np.empty(3)
    for i in range(points.shape[0]):
        _to_local(points[i, 0], points[i, 1], points[i, 2], R, c, local)
        out[i] = distance_row(local, axes, eps, row)
    return out


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def distance_row(local, axes, eps, row):
    """Residual r of a point in shape coordinates; fills `row` (11,) with its derivatives."""
    x, y, z = _off_zero(local[0]), _off_zero(local[1]), _off_zero(local[2])
    e1, e2 = eps[0], eps[1]
    k1, k2 = 2.0 / e1, 2.0 / e2
    ax = k2 * (np.log(abs(x)) - axes[0])
    ay = k2 * (np.log(abs(y)) - axes[1])
    log_a, u1, u2 = _log_sum(ax, ay)
    t = e2 / e1 * log_a
    s = k1 * (np.log(abs(z)) - axes[2])
    log_f, w, w3 = _log_sum(t, s)
    h = 0.5 * e1 * log_f
    p1, p2, p3 = w * u1, w * u2, w3
    g1, g2, g3 = p1 / x, p2 / y, p3 / z
    n = np.sqrt(g1 * g1 + g2 * g2 + g3 * g3)
    falling = np.exp(-h)
    r = (1.0 - falling) / n

    # Derivatives of the shares by the logarithms of the coordinates (symmetric).
    q, o = w * w3 * k1, w * k2 * u1 * u2
    d11, d12, d13 = q * u1 * u1 + o, q * u1 * u2 - o, -q * u1
    d22, d23, d33 = q * u2 * u2 + o, -q * u2, q
    f1, f2, f3 = g1 / x / n, g2 / y / n, g3 / z / n
    along, across = falling / n, r / n
    r1 = along * p1 - across * (f1 * d11 + f2 * d12 + f3 * d13)
    r2 = along * p2 - across * (f1 * d12 + f2 * d22 + f3 * d23)
    r3 = along * p3 - across * (f1 * d13 + f2 * d23 + f3 * d33)
    row[0], row[1], row[2] = -r1, -r2, -r3

    spread = log_a - u1 * ax - u2 * ay
    dw = w * w3 * (s - t) / e1
    row[3] = along * 0.5 * (log_f - w * t - w3 * s) - across * (
        f1 * dw * u1 + f2 * dw * u2 - f3 * dw
    )
    dw = w * w3 * spread / e1
    du = -u1 * u2 * (ax - ay) / e2
    row[4] = along * 0.5 * w * spread - across * (
        f1 * (dw * u1 + w * du) + f2 * (dw * u2 - w * du) - f3 * dw
    )
    v1 = r1 / x + across * g1 * g1 / (x * n)
    v2 = r2 / y + across * g2 * g2 / (y * n)
    v3 = r3 / z + across * g3 * g3 / (z * n)
    _pose_part(row, v1, v2, v3, x, y, z)
    return r


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _ray_row(direction, origin, axes, eps, R, c, row, local):
    """Depth s (1 - min G) by which a ray enters the solid, and its derivatives.

    By the envelope theorem the derivative at the minimum over the ray needs no derivative of
    the minimiser. s is the smallest semi-axis.
    """
    to_centre = (
        direction[0] * (c[0] - origin[0])
        + direction[1] * (c[1] - origin[1])
        + direction[2] * (c[2] - origin[2])
    )
    reach = np.exp(max(axes[0], axes[1], axes[2])) * _BALL
    # A ray that misses the bounding ball misses the solid.
    miss = 0.0
    for k in range(3):
        gap = origin[k] + to_centre * direction[k] - c[k]
        miss += gap * gap
    if miss > reach * reach:
        return 0.0
    low, high = to_centre - reach, to_centre + reach
    g_low, s_low = _gauge_on_ray(low, direction, origin, axes, eps, R, c, local)
    g_high, s_high = _gauge_on_ray(high, direction, origin, axes, eps, R, c, local)
    gauge = 1.0
    for iteration in range(_RAY_ITERATIONS):
        if s_low >= 0.0 or s_high <= 0.0:
            return 0.0
        # A convex function lies above its tangents: where they meet is a bound and a good guess.
        t = (g_high - g_low + s_low * low - s_high * high) / (s_low - s_high)
        if g_low + s_low * (t - low) >= 1.0:
            return 0.0
        if iteration % 3 == 2 or not (low < t < high):
            t = 0.5 * (low + high)
        gauge, slope = _gauge_on_ray(t, direction, origin, axes, eps, R, c, local)
        if slope < 0.0:
            low, g_low, s_low = t, gauge, slope
        else:
            high, g_high, s_high = t, gauge, slope
        if high - low < _RAY_TOLERANCE * reach or abs(slope) * reach < _RAY_TOLERANCE:
            break
    if gauge >= 1.0:
        return 0.0
    x, y, z = _off_zero(local[0]), _off_zero(local[1]), _off_zero(local[2])
    p1, p2, p3, h1, h2 = _shares(x, y, z, axes, eps)
    smallest = 0
    for k in range(1, 3):
        if axes[k] < axes[smallest]:
            smallest = k
    s = np.exp(axes[smallest])
    outward = -s * gauge
    row[0], row[1], row[2] = -outward * p1, -outward * p2, -outward * p3
    row[smallest] += s * (1.0 - gauge)
    row[3], row[4] = outward * h1, outward * h2
    _pose_part(row, outward * p1 / x, outward * p2 / y, outward * p3 / z, x, y, z)
    return s * (1.0 - gauge)


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _plane_row(plane, axes, eps, R, c, row, local):
    """Height of the solid's lowest point over the plane, and its derivatives.

    The support function is the dual gauge: exponents 2 - ε on inverse semi-axes.
    """
    for k in range(3):
        local[k] = -(R[0, k] * plane[0] + R[1, k] * plane[1] + R[2, k] * plane[2])
    dual_axes = -axes
    dual_eps = 2.0 - eps
    x, y, z = _off_zero(local[0]), _off_zero(local[1]), _off_zero(local[2])
    support = np.exp(_log_gauge(x, y, z, dual_axes, dual_eps))
    p1, p2, p3, h1, h2 = _shares(x, y, z, dual_axes, dual_eps)
    height = plane[0] * c[0] + plane[1] * c[1] + plane[2] * c[2] + plane[3]
    row[0], row[1], row[2] = -support * p1, -support * p2, -support * p3
    row[3], row[4] = support * h1, support * h2
    # The direction turns like a point about the origin; the centre moves along the normal.
    _pose_part(row, -support * p1 / x, -support * p2 / y, -support * p3 / z, x, y, z)
    row[8], row[9], row[10] = -local[0], -local[1], -local[2]
    return height - support


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _shares(x, y, z, axes, eps):
    """Shares p (3 values) and the derivatives of log G by ε1 and ε2."""
    e1, e2 = eps[0], eps[1]
    ax = 2.0 / e2 * (np.log(abs(x)) - axes[0])
    ay = 2.0 / e2 * (np.log(abs(y)) - axes[1])
    log_a, u1, u2 = _log_sum(ax, ay)
    t = e2 / e1 * log_a
    s = 2.0 / e1 * (np.log(abs(z)) - axes[2])
    log_f, w, w3 = _log_sum(t, s)
    h1 = 0.5 * (log_f - w * t - w3 * s)
    h2 = 0.5 * w * (log_a - u1 * ax - u2 * ay)
    return w * u1, w * u2, w3, h1, h2


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _log_gauge(x, y, z, axes, eps):
    ax = 2.0 / eps[1] * (np.log(abs(x)) - axes[0])
    ay = 2.0 / eps[1] * (np.log(abs(y)) - axes[1])
    az = 2.0 / eps[0] * (np.log(abs(z)) - axes[2])
    log_a, _, _ = _log_sum(ax, ay)
    log_f, _, _ = _log_sum(eps[1] / eps[0] * log_a, az)
    return 0.5 * eps[0] * log_f


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _gauge_on_ray(t, direction, origin, axes, eps, R, c, local):
    """G and dG/dt at `origin + t direction`; leaves the point in `local`."""
    _to_local(
        origin[0] + t * direction[0],
        origin[1] + t * direction[1],
        origin[2] + t * direction[2],
        R,
        c,
        local,
    )
    x, y, z = _off_zero(local[0]), _off_zero(local[1]), _off_zero(local[2])
    e1, e2 = eps[0], eps[1]
    ax = 2.0 / e2 * (np.log(abs(x)) - axes[0])
    ay = 2.0 / e2 * (np.log(abs(y)) - axes[1])
    log_a, u1, u2 = _log_sum(ax, ay)
    log_f, w, w3 = _log_sum(e2 / e1 * log_a, 2.0 / e1 * (np.log(abs(z)) - axes[2]))
    gauge = np.exp(0.5 * e1 * log_f)
    p1, p2, p3 = w * u1, w * u2, w3
    slope = 0.0
    for k in range(3):
        along = R[k, 0] * p1 / x + R[k, 1] * p2 / y + R[k, 2] * p3 / z
        slope += along * direction[k]
    return gauge, gauge * slope


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _pose_part(row, v1, v2, v3, x, y, z):
    """Rotation and translation derivatives of a function with spatial gradient v at (x, y, z)."""
    row[5], row[6], row[7] = v2 * z - v3 * y, v3 * x - v1 * z, v1 * y - v2 * x
    row[8], row[9], row[10] = -v1, -v2, -v3


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _to_local(x, y, z, R, c, local):
    dx, dy, dz = x - c[0], y - c[1], z - c[2]
    for k in range(3):
        local[k] = R[0, k] * dx + R[1, k] * dy + R[2, k] * dz


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _accumulate(gradient, hessian, row, r, weight):
    for j in range(PARAMETERS):
        scaled = weight * row[j]
        gradient[j] += scaled * r
        for k in range(j + 1):
            hessian[j, k] += scaled * row[k]


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _cauchy(r, scale):
    return 0.5 * scale * scale * np.log1p((r / scale) ** 2)


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _off_zero(x):
    if abs(x) < _SMALL:
        return _SMALL if x >= 0.0 else -_SMALL
    return x


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "arcp", "nsz"})
def _log_sum(a, b):
    """log(exp a + exp b) and the two shares of the sum, without overflow."""
    if a > b:
        ratio = np.exp(b - a)
        share = 1.0 / (1.0 + ratio)
        return a + np.log1p(ratio), share, ratio * share
    ratio = np.exp(a - b)
    share = 1.0 / (1.0 + ratio)
    return b + np.log1p(ratio), ratio * share, share
