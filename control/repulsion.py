"""Repulsion from obstacles: the cost of being near, and its gradient (eq. 6-7)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from eyehand.errors import InputError

from .options import ControlOptions
from .packed_options import DT, ETA, INFLUENCE, pack_options
from .proximity import Proximity

ROUNDING = 1e-9
"""Maximum relative excess over the stable gain, because the error message prints only three
digits."""


def repulsion_gradient(proximity: Proximity, options: ControlOptions) -> NDArray[np.float64]:
    """Return the gradient (n,) of the repulsion cost over the joints (eq. 7).

    Joint motion against the gradient avoids obstacles.

    The cost is η (d - d_B)² summed over all distances d below d_B (eq. 6). With the signed distance
    d and its rows ∂d/∂q the gradient is 2 η (d - d_B) ∂d/∂q. The chapter uses the length of the
    connecting vector instead of d. Its direction reverses when the bodies overlap, and pulls them
    deeper.
    """
    gradient = np.zeros(proximity.rows.shape[1])
    repel(proximity.distance, proximity.rows, pack_options(options), gradient)
    return gradient


def limited_gradient(proximity: Proximity, options: ControlOptions) -> NDArray[np.float64]:
    """Return :func:`repulsion_gradient`, limited so that it does not overshoot in one period.

    The gains of all repelling pairs add up (:func:`stable_eta`, with the Frobenius norm of their
    rows as an upper bound of the lever). A gradient with a gain above 1 is divided by it.
    """
    gradient = np.zeros(proximity.rows.shape[1])
    packed = pack_options(options)
    limit_gradient(gradient, repel(proximity.distance, proximity.rows, packed, gradient), packed)
    return gradient


@njit(cache=True)
def repel(distance, rows, options, gradient):
    """Add the gradient (n,) of eq. 7 for distances (P,) with rows (P, n).

    Return the sum of squares of the rows of repelling pairs.
    """
    square, eta = 0.0, options[ETA]
    for row in range(len(rows)):
        depth = options[INFLUENCE] - distance[row]
        if depth > 0.0:
            for joint in range(len(gradient)):
                gradient[joint] -= 2.0 * eta * depth * rows[row, joint]
                square += rows[row, joint] * rows[row, joint]
    return square


@njit(cache=True)
def limit_gradient(gradient, square, options):
    """Divide a gradient (n,) by its gain if that is above 1; `square` is the result of `repel`."""
    gain = 2.0 * options[ETA] * options[DT] * square
    if gain > 1.0:
        gradient /= gain


def stable_eta(lever: float, dt: float, beta: float = 1.0) -> float:
    """Return the largest η at which one step of dt never overshoots: β dt λmax(∇²H) = 1.

    The Hessian of one active pair is 2 η (∂d/∂q)ᵀ(∂d/∂q). `lever` is the largest norm of such a
    row, m; for several pairs it is the spectral norm of their rows. Above this η motions overshoot.
    Above twice this η they never settle. With a lever or β of 0, any η is stable and the result is
    inf.
    """
    gain = 2.0 * beta * dt * lever**2
    return 1.0 / gain if gain > 0.0 else math.inf


def require_stable(options: ControlOptions, lever: float) -> None:
    """Reject a repulsion that oscillates at this control period.

    Raises
    ------
    InputError
        If η is above :func:`stable_eta`. The message contains the largest valid η.
    """
    beta = 1.0 if isinstance(options.beta, str) else max(options.beta, 1.0)
    largest = stable_eta(lever, options.dt, beta)
    if options.eta > largest * (1.0 + ROUNDING):
        raise InputError(
            f"eta = {options.eta:g} with beta {beta:g} at dt = {1e3 * options.dt:g} ms has gain "
            f"{options.eta / largest:.2g}, and motions overshoot above 1: eta at most "
            f"{_round_down(largest)}, or dt at most "
            f"{_round_down(1e3 * options.dt * largest / options.eta)} ms"
        )


def _round_down(value: float) -> str:
    """Format a value with three digits, rounded down, so that the printed value is accepted."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.floor(value / unit) * unit:.3g}"
