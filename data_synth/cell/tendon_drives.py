"""Motors of a simulated tendon hand (position, tension or brake), and its sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.grasping import HandReading
from eyehand.grasping.hands import AnyCommand
from eyehand.tactile import TactileImage

from ..mujoco_import import import_mujoco
from .hand_interface import checked_values, finger_command, pad_forces

PALM_PAD = "palm_pad"
"""Geom of the palm's face; other pads have the name of their phalanx."""

POSITION_STIFFNESS = 4000.0
"""Stiffness of position control, N/m: 1 mm of error adds 4 N."""
POSITION_DAMPING = 60.0
"""Damping of position control, Ns/m. A finger has an effective mass of 2-4 kg at its tendon, so it
settles in 30 ms."""
POSITION_INTEGRAL = 60e3
"""Integral gain of position control, N/(m s): compensates the springs within 0.1 s."""
POSITION_SPEED = 0.030
"""Maximum tendon speed in position control, m/s: 2.5 rad/s at the knuckle."""
NO_LOAD_SPEED = 0.1
"""Tendon speed at which a motor that pulls has no tension left, m/s: 8 rad/s at the knuckle.
Without this limit, fingers that lose their object meet the thumb at 5 m/s and pass into it."""
SLIP_DAMPING = 4000.0
"""Damping of a slipping brake, Ns/m: 40 N above the limit slip at 10 mm/s."""


class TendonDrives:
    """Drives of a tendon hand in a MuJoCo model, run one physics step at a time.

    A held tendon is a brake: a limit on the tendon's length. The contact solver keeps it exactly,
    and it can only pull. The limits in the model change while the hand runs.

    Parameters
    ----------
    model, data
        `MjModel` and `MjData` with the hand in it.
    prefix
        Prefix of all names of the hand, as `MjSpec.attach` sets it.
    drives
        Names of the tendons, each with an actuator of the same name; by default all tendons with
        the prefix.

    Raises
    ------
    InputError
        If there are no such tendons, or one has no actuator.
    """

    def __init__(
        self, model: Any, data: Any, *, prefix: str = "", drives: Sequence[str] = ()
    ) -> None:
        mujoco = import_mujoco()
        self._mujoco, self._model, self._data = mujoco, model, data
        kinds = mujoco.mjtObj
        names = [model.tendon(t).name for t in range(model.ntendon)]
        self.drives = tuple(drives) or tuple(
            name.removeprefix(prefix) for name in names if name and name.startswith(prefix)
        )
        tendons = [_id(model, kinds.mjOBJ_TENDON, prefix + name) for name in self.drives]
        if not tendons:
            raise InputError(f"the hand {prefix!r} has no tendons to pull")
        self._tendons = np.array(tendons)
        self._motors = np.array(
            [_id(model, kinds.mjOBJ_ACTUATOR, prefix + name) for name in self.drives]
        )
        arms = np.array([tendon_arms(model, t) for t in tendons])
        joints = np.flatnonzero(np.any(arms != 0.0, axis=0))
        self.joints = tuple(model.joint(j).name.removeprefix(prefix) for j in joints)
        self._addresses = model.jnt_qposadr[joints]
        bodies = set(model.jnt_bodyid[joints].tolist())
        geoms = [
            g
            for g in range(model.ngeom)
            if model.geom_contype[g] | model.geom_conaffinity[g]
            and (int(model.geom_bodyid[g]) in bodies or model.geom(g).name == prefix + PALM_PAD)
        ]
        geoms.sort(key=lambda g: model.geom(g).name == prefix + PALM_PAD)
        self.pads = tuple(model.geom(g).name.removeprefix(prefix) for g in geoms)
        self._pad_of_geom = np.full(model.ngeom + 1, -1)
        self._pad_of_geom[geoms] = np.arange(len(geoms))
        # A tendon shortens as its finger closes; the open hand has every joint at its lower end.
        self._open = -arms[:, joints] @ model.jnt_range[joints, 0]
        self._signs = np.sign(-model.actuator_gear[self._motors, 0])
        self._max_tension = model.actuator_ctrlrange[self._motors, 1]
        # As a number: NumPy compares an array with the enum itself a hundred times slower.
        self._limit_kind = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON)
        count = len(tendons)
        self._modes: tuple[str, ...] = ("pull",) * count
        self._values = np.zeros(count)
        self._goal = np.full(count, np.nan)
        self._sum = np.zeros(count)

    def excursions(self) -> NDArray[np.float64]:
        """Return the excursion of each tendon from fully open, (D,), m."""
        return -self._data.ten_length[self._tendons] - self._open

    def command(self, command: AnyCommand) -> None:
        """Set a command; a drive whose mode changes continues from its current state.

        Raises
        ------
        InputError
            If there is not one finite value and one valid mode for each drive.
        """
        command = finger_command(command)
        values = checked_values(command, self.drives)
        now = self.excursions()
        tension = self._brakes() + np.abs(self._data.ctrl[self._motors])
        for k, (old, new) in enumerate(zip(self._modes, command.modes, strict=True)):
            tendon = self._tendons[k]
            if new == old:
                continue
            self._model.tendon_limited[tendon] = new == "hold"
            if new == "hold":
                self._model.tendon_range[tendon] = -1.0, self._data.ten_length[tendon]
            elif new == "position":
                self._goal[k], self._sum[k] = now[k], tension[k]
        self._modes, self._values = command.modes, values

    def apply(self) -> None:
        """Set the motors for the next physics step; call it after the state is computed."""
        model, data = self._model, self._data
        step = float(model.opt.timestep)
        now = self.excursions()
        speed = -data.ten_velocity[self._tendons]
        brakes = self._brakes()
        for k, mode in enumerate(self._modes):
            value, max_tension = self._values[k], self._max_tension[k]
            tension = 0.0
            if mode == "pull":
                left = min(max(1.0 - speed[k] / NO_LOAD_SPEED, 0.0), 1.0)
                tension = left * min(max(value, 0.0), max_tension)
            elif mode == "position":
                stride = POSITION_SPEED * step
                self._goal[k] += np.clip(value - self._goal[k], -stride, stride)
                error = self._goal[k] - now[k]
                self._sum[k] += POSITION_INTEGRAL * error * step
                self._sum[k] = min(max(self._sum[k], 0.0), max_tension)
                tension = self._sum[k] + POSITION_STIFFNESS * error - POSITION_DAMPING * speed[k]
                tension = min(max(tension, 0.0), max_tension)
            elif brakes[k] > value:
                give = (brakes[k] - value) / SLIP_DAMPING * step
                model.tendon_range[self._tendons[k], 1] += give
            data.ctrl[self._motors[k]] = self._signs[k] * tension

    def reading(self, tips: tuple[TactileImage, ...] = ()) -> HandReading:
        """Return the current sensor values, together with the given tactile images."""
        data = self._data
        return HandReading(
            excursions=self.excursions(),
            tensions=self._brakes() + np.abs(data.ctrl[self._motors]),
            angles=data.qpos[self._addresses].copy(),
            forces=pad_forces(self._data, self._pad_of_geom, len(self.pads)),
            tips=tips,
        )

    def _brakes(self) -> NDArray[np.float64]:
        """Return the tension of each brake, (D,), N."""
        data = self._data
        tensions = np.zeros(len(self._tendons))
        if "hold" not in self._modes or not data.nefc:
            return tensions
        rows = np.flatnonzero(data.efc_type == self._limit_kind)
        for row in rows:
            tensions[self._tendons == data.efc_id[row]] += data.efc_force[row]
        return tensions


def tendon_arms(model: Any, tendon: int) -> NDArray[np.float64]:
    """Return the moment arms of a fixed tendon about all joints, (J,), m; 0 where it has none.

    A positive arm lengthens the tendon as the angle grows.
    """
    arms = np.zeros(model.njnt)
    first = model.tendon_adr[tendon]
    for w in range(first, first + model.tendon_num[tendon]):
        arms[model.wrap_objid[w]] = model.wrap_prm[w]
    return arms


def _id(model: Any, kind: Any, name: str) -> int:
    found = import_mujoco().mj_name2id(model, kind, name)
    if found < 0:
        raise InputError(f"the hand has no {str(kind).rpartition('OBJ_')[2].lower()} {name!r}")
    return int(found)
