"""A force and torque sensor between the simulated arm and its hand."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mujoco_import import import_mujoco
from .hand_frame import find_frame

FORCE_NOISE_N, TORQUE_NOISE_NM = 0.06, 0.002
"""Standard deviation of a measurement. Sensors of this size resolve 1/16 N and 1/752 Nm."""
_STREAM = 1
"""Number that separates this noise from that of the camera."""


class WristSensor:
    """Measure what the hand's contacts transmit to the arm.

    Weight and inertia of the hand are subtracted, as by a sensor with an acceleration sensor beside
    it. Forces between parts of the hand cancel.

    Parameters
    ----------
    model, data
        `MjModel` and `MjData` of the world.
    frame
        Name of the site or body that is the hand's frame.
    seed
        Seed of the noise.
    """

    def __init__(self, model: Any, data: Any, frame: str, seed: int) -> None:
        self._mujoco, self._model, self._data = import_mujoco(), model, data
        body, self._site = find_frame(model, frame)
        # The sensor lies below the body of the frame: it carries all that moves with it.
        self._hand = [b for b in range(model.nbody) if _descends(model, b, body)]
        self._body = body
        self._rng = np.random.default_rng([seed, _STREAM])
        self.wrench: NDArray[np.float64] = np.zeros(6)
        """Newest measurement, (6,), N and Nm, in the hand's frame about its origin."""

    def measure(self) -> None:
        """Measure after a physics step."""
        data = self._data
        self._mujoco.mj_rnePostConstraint(self._model, data)
        # MuJoCo gives torque and force about the centre of mass of the whole robot.
        total = data.cfrc_ext[self._hand].sum(axis=0)
        centre = data.subtree_com[self._model.body_rootid[self._body]]
        if self._site < 0:
            origin, axes = data.xpos[self._body], data.xmat[self._body]
        else:
            origin, axes = data.site_xpos[self._site], data.site_xmat[self._site]
        axes = axes.reshape(3, 3)
        force = total[3:]
        torque = total[:3] + np.cross(centre - origin, force)
        noise = self._rng.standard_normal(6)
        noise[:3] *= FORCE_NOISE_N
        noise[3:] *= TORQUE_NOISE_NM
        self.wrench = np.concatenate([axes.T @ force, axes.T @ torque]) + noise


def _descends(model: Any, body: int, ancestor: int) -> bool:
    while body > ancestor:
        body = int(model.body_parentid[body])
    return body == ancestor
