"""Springs and moment arms of a tendon hand, measured in its MuJoCo model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..mujoco_import import import_mujoco

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

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
