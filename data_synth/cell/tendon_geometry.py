"""Springs and moment arms of a tendon hand, measured in its MuJoCo model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from ..mujoco_import import import_mujoco

if TYPE_CHECKING:
    from collections.abc import Sequence

    Springs: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

_PROBE_RAD = 1e-4
"""Step of joint angles with which the tendons' moment arms are measured."""


def joint_springs(model: Any, joints: Sequence[str]) -> Springs:
    """Return stiffness, Nm/rad, rest angles, rad, and limits (J, 2), rad, of joints by name."""
    numbers = [model.joint(name).id for name in joints]
    limits = np.where(
        model.jnt_limited[numbers, None].astype(bool), model.jnt_range[numbers], [-np.pi, np.pi]
    )
    rest = model.qpos_spring[model.jnt_qposadr[numbers]]
    return model.jnt_stiffness[numbers].copy(), rest.copy(), limits


def moment_arms(
    model: Any, tendons: Sequence[str], joints: Sequence[str], springs: Springs
) -> NDArray[np.float64]:
    """Return the shortening of each tendon per joint angle in the rest posture, (D, J), m/rad."""
    mujoco = import_mujoco()
    data = mujoco.MjData(model)
    _, rest, limits = springs
    numbers = [model.tendon(name).id for name in tendons]
    places = np.array([model.joint(name).qposadr[0] for name in joints], dtype=np.intp)
    data.qpos[places] = np.clip(rest, *limits.T)

    def lengths() -> NDArray[np.float64]:
        mujoco.mj_fwdPosition(model, data)
        return data.ten_length[numbers].copy()

    start, moments = lengths(), np.zeros((len(numbers), len(rest)))
    for column, place in enumerate(places):
        data.qpos[place] += _PROBE_RAD
        moments[:, column] = (start - lengths()) / _PROBE_RAD
        data.qpos[place] -= _PROBE_RAD
    return moments


_MIN_STIFFNESS = 1e-3
"""Minimum stiffness of a joint, Nm/rad. The angle of a joint without a spring would be
undetermined."""
_MIN_RESIDUAL = 1e-9
"""Minimum residual of the least-squares problem. Below it, no angles satisfy all bounds."""


def tendon_posture(
    moment_arms: NDArray[np.float64],
    excursions: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    rest: NDArray[np.float64],
    limits: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Compute the joint angles of minimum spring energy that the tendons allow.

    A tendon shortens by at least its excursion. If other tendons close its joints farther, it is
    slack. Excursions beyond the joints' range move the joints to their limits.

    Parameters
    ----------
    moment_arms
        Shortening of each tendon per joint angle, (D, J), m/rad.
    excursions
        Excursion of each tendon from the posture without tension, (D,), m. Negative values count
        as 0.
    stiffness
        Stiffness of the joints' springs, (J,), Nm/rad.
    rest
        Joint angles at which the springs are relaxed, (J,), rad.
    limits
        Minimum and maximum joint angles, (J, 2), rad.

    Returns
    -------
    NDArray
        Joint angles (J,), rad, within the limits. If no angles satisfy all tendons, the rest
        posture within the limits is returned.

    Notes
    -----
    Least distance programming by non-negative least squares: Lawson and Hanson, Solving Least
    Squares Problems, 1974, chapter 23.
    """
    low, high = limits.T
    open_posture = np.clip(rest, low, high)
    max_shortening = np.maximum(moment_arms * low, moment_arms * high).sum(axis=1)
    pulled = np.minimum(np.maximum(excursions, 0.0) + moment_arms @ open_posture, max_shortening)
    eye = np.eye(len(rest))
    gradients, bounds = np.vstack([moment_arms, eye, -eye]), np.concatenate([pulled, low, -high])
    # In y = sqrt(k) (q - rest) the energy is |y|²/2, and the bounds are G y >= h.
    scale = 1.0 / np.sqrt(np.maximum(stiffness, _MIN_STIFFNESS))
    problem = np.vstack([(gradients * scale).T, bounds - gradients @ rest])
    target = np.append(np.zeros(len(rest)), 1.0)
    residual = problem @ nnls(problem, target)[0] - target
    if abs(residual[-1]) < _MIN_RESIDUAL:
        return open_posture
    return np.clip(rest - scale * residual[:-1] / residual[-1], low, high)
