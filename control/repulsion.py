"""Repulsion from obstacles: the cost of being near, and its gradient (eq. 6-7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import ControlOptions
    from .proximity import Proximity


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


def stable_eta(lever: float, dt: float, beta: float = 1.0) -> float:
    """Largest η at which one step of dt never overshoots: β dt λmax(∇²H) = 1.

    The Hessian of one active pair is 2 η (∂d/∂q)ᵀ(∂d/∂q); `lever` is the largest norm of such a
    row, m. From twice that value on, motions oscillate.
    """
    return 1.0 / (2.0 * max(beta, 1e-12) * dt * lever**2)


def require_stable(options: ControlOptions, lever: float) -> None:
    """Refuse a repulsion that oscillates at this control period.

    Raises
    ------
    InputError
        If η passes :func:`stable_eta`; the message gives the largest that does not.
    """
    beta = 1.0 if isinstance(options.beta, str) else max(options.beta, 1.0)
    largest = stable_eta(lever, options.dt, beta)
    if options.eta > largest:
        raise InputError(
            f"eta = {options.eta:g} with beta {beta:g} at dt = {1e3 * options.dt:g} ms has gain "
            f"{options.eta / largest:.2g}, above 1 motions overshoot: eta at most {largest:.3g}, "
            f"or dt at most {1e3 * options.dt * largest / options.eta:.3g} ms"
        )
