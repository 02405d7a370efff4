"""Repulsion from obstacles: the cost of being near, and its gradient (eq. 6-7)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import ControlOptions
    from .proximity import Proximity

ROUNDING = 1e-9
"""A gain above the stable one by no more of it is that gain: it may come from our own message."""


def repulsion_cost(distance: NDArray[np.float64], options: ControlOptions) -> float:
    """Cost H_ca of distances (P,), m: η (d - d_B)² summed over what is nearer than d_B (eq. 6)."""
    depth = np.maximum(options.influence - distance, 0.0)
    return options.eta * float(depth @ depth)


def repulsion_gradient(proximity: Proximity, options: ControlOptions) -> NDArray[np.float64]:
    """Gradient (n,) of the cost over the joints; moving against it leads away (eq. 7).

    With the signed distance d and its rows ∂d/∂q it reads 2 η (d - d_B) ∂d/∂q. As printed, with
    the length of the connecting vector, the direction turns round once the bodies overlap and
    pulls them deeper.
    """
    depth = np.maximum(options.influence - proximity.distance, 0.0)
    return -2.0 * options.eta * (depth @ proximity.rows)


def limited_gradient(proximity: Proximity, options: ControlOptions) -> NDArray[np.float64]:
    """Gradient (n,) of :func:`repulsion_gradient`, held below what overshoots in one period.

    Where many pairs push at a time their gains add up (:func:`stable_eta`, the lever bounded by
    the Frobenius norm of the pushing rows); a gain above 1 is divided out.
    """
    gradient = repulsion_gradient(proximity, options)
    pushing = proximity.rows[proximity.distance < options.influence]
    gain = 2.0 * options.eta * options.dt * float(np.vdot(pushing, pushing))
    return gradient / gain if gain > 1.0 else gradient


def stable_eta(lever: float, dt: float, beta: float = 1.0) -> float:
    """Largest η at which one step of dt never overshoots: β dt λmax(∇²H) = 1.

    The Hessian of one active pair is 2 η (∂d/∂q)ᵀ(∂d/∂q); `lever` is the largest norm of such a
    row, m; of several pairs at a time, the spectral norm of their rows. Beyond, motions overshoot;
    from twice that value on, they never settle. Where nothing moves (a lever or β of 0), any η is
    stable and this is inf.
    """
    gain = 2.0 * beta * dt * lever**2
    return 1.0 / gain if gain > 0.0 else math.inf


def require_stable(options: ControlOptions, lever: float) -> None:
    """Refuse a repulsion that oscillates at this control period.

    Raises
    ------
    InputError
        If η passes :func:`stable_eta`; the message gives the largest that does not.
    """
    beta = 1.0 if isinstance(options.beta, str) else max(options.beta, 1.0)
    largest = stable_eta(lever, options.dt, beta)
    if options.eta > largest * (1.0 + ROUNDING):
        raise InputError(
            f"eta = {options.eta:g} with beta {beta:g} at dt = {1e3 * options.dt:g} ms has gain "
            f"{options.eta / largest:.2g}, above 1 motions overshoot: eta at most "
            f"{_round_down(largest)}, or dt at most "
            f"{_round_down(1e3 * options.dt * largest / options.eta)} ms"
        )


def _round_down(value: float) -> str:
    """Print with three digits that are never above the value: what is printed is accepted."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.floor(value / unit) * unit:.3g}"
