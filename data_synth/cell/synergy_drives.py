"""Drives of a simulated hand with joint motors: each finger closes as if a tendon pulled it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.grasping import HandReading
from eyehand.grasping.hands import AnyCommand
from eyehand.tactile import TactileImage

from ..mujoco_import import import_mujoco
from .hand_description import THUMB, HandDescription
from .hand_interface import checked_values, finger_command, pad_forces
from .name_suggestions import suggest_names

HINGE_ARM_M = 0.012
"""Moment arm of a finger's virtual tendon at its first joint. It equals that of the included hand,
so the same tension gives the same force at the fingertips."""
SLIDE_ARM = HINGE_ARM_M / 0.090
"""Travel of the virtual tendon per travel of a sliding jaw, m/m. The jaw presses as hard as a
finger of 90 mm."""
TAPER = 0.45
"""Moment arm at each further joint, as a share of the arm at the joint before: the fingertip is
nearer to it. With less, a force on the tip bends the finger back; with more, it curls in."""
POSITION_RATE = 60.0
"""Natural frequency of position control, rad/s. A higher one is stiffer, and oscillates at a
physics step of 2 ms."""
HOLD_RATE = 120.0
"""Natural frequency of joints that hold their position, rad/s."""
PULL_SHARE = 0.15
"""Stiffness that keeps a pulled finger on its closing line, as a share of that of position control.
Less wraps objects better; more keeps the tip's face parallel."""
POSITION_SPEED = 0.030
"""Maximum speed of a drive in position control, m/s."""
THUMB_RESERVE = 1.2
"""The tensions of all fingers add up to at most the thumb's largest tension over this, because the
thumb opposes them all."""


class SynergyDrives:
    """Executes hand commands on a hand whose motors move joints, one physics step at a time.

    Each finger is one drive. Its closing line is the straight line in joint space from the open to
    the closed posture. A virtual tendon closes the finger; its moment arms decrease towards the
    tip, and its excursion, m, is 0 in the open posture. Mode *position* controls where the joints
    are along the line. Mode *pull* applies the joint torques of a tension, and a soft spring keeps
    the joints near the line. Mode *hold* stiffly keeps each joint where it is, up to the torques of
    a tension.

    Joint torques are converted to motor controls with each motor's gain and bias. A position servo
    gets a goal ahead of the joint. Limits of force and control are kept.

    Parameters
    ----------
    model, data
        `MjModel` and `MjData` with the hand in it.
    description
        Joints and pads of each finger.
    prefix
        Prefix of all names of the hand, as `MjSpec.attach` sets it.

    Raises
    ------
    InputError
        If a joint or geom is missing, or a finger has no motor.
    """

    def __init__(
        self, model: Any, data: Any, description: HandDescription, *, prefix: str = ""
    ) -> None:
        mujoco = import_mujoco()
        self._mujoco, self._model, self._data = mujoco, model, data
        fingers = description.fingers
        self.drives = tuple(finger.name for finger in fingers)
        self.joints, self.pads = description.joint_names, description.pad_names
        names = [name for finger in fingers for name in finger.joints]
        ranges = [pair for finger in fingers for pair in finger.joints.values()]
        owner = [k for k, finger in enumerate(fingers) for _ in finger.joints]
        self._count = len(names)
        names += list(description.still)
        ranges += [(place, place) for place in description.still.values()]
        numbers = np.array([_id(model, mujoco.mjtObj.mjOBJ_JOINT, prefix + n) for n in names])
        self._addresses, self._rates = model.jnt_qposadr[numbers], model.jnt_dofadr[numbers]
        self._open, self._closed = np.array(ranges, dtype=np.float64).T
        self._limits = np.where(
            model.jnt_limited[numbers, None].astype(bool), model.jnt_range[numbers], [-1e3, 1e3]
        )
        self._owner = np.array(owner + [-1] * len(description.still))
        self._motors, moments = _motors(model, numbers)
        # Maps joint torques to motor forces. With one motor per joint it is the exact inverse.
        self._shares = np.linalg.pinv(moments.T)
        moved = np.any(moments != 0.0, axis=0)
        slides = model.jnt_type[numbers] == int(mujoco.mjtJoint.mjJNT_SLIDE)
        self._arms = _arms(self._open, self._closed, self._owner, moved, slides)
        for k, finger in enumerate(fingers):
            if not np.any(self._arms[k]):
                raise InputError(
                    f"finger {finger.name}: none of {', '.join(finger.joints)} has a motor; give "
                    "one of them a <position> or <motor> actuator on the joint or a fixed tendon"
                )
        self.full = np.sum(self._arms * (self._closed - self._open), axis=1)
        """Excursions of the closed posture, (D,), m."""
        inertia = model.dof_M0[self._rates]
        self._position_gains = inertia * POSITION_RATE**2, 2.0 * inertia * POSITION_RATE
        self._hold = inertia * HOLD_RATE**2, 2.0 * inertia * HOLD_RATE
        self._max_tension = self._max_tensions(moments)
        self._pad_of_geom = _pads(model, description, prefix)
        self._modes: tuple[str, ...] = ("position",) * len(fingers)
        self._values = np.zeros(len(fingers))
        self._goal = self.excursions()
        self._kept = data.qpos[self._addresses].copy()
        self._tensions = np.zeros(len(fingers))

    def excursions(self) -> NDArray[np.float64]:
        """Return the excursion of each drive from fully open, (D,), m."""
        return self._arms @ (self._data.qpos[self._addresses] - self._open)

    def posture(self, excursions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the joint positions at excursions (D,), m: (J,), rad or m, still joints last."""
        along = np.append(excursions / self.full, 0.0)[self._owner]
        return np.clip(self._open + along * (self._closed - self._open), *self._limits.T)

    def pose(self, excursions: NDArray[np.float64]) -> None:
        """Set the joint positions of the data to the posture at excursions (D,), m."""
        self._data.qpos[self._addresses] = self.posture(excursions)
        self._goal = np.array(excursions, dtype=np.float64)
        self._kept = self._data.qpos[self._addresses].copy()

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
        for k, (old, new) in enumerate(zip(self._modes, command.modes, strict=True)):
            if new == "position" and old != "position":
                self._goal[k] = now[k]
            elif new == "hold" and old != "hold":
                mine = self._owner == k
                self._kept[mine] = self._data.qpos[self._addresses[mine]]
        self._modes, self._values = command.modes, values

    def apply(self) -> None:
        """Set the motors for the next physics step; call it after the state is computed."""
        model, data = self._model, self._data
        stride = POSITION_SPEED * float(model.opt.timestep)
        q, speed = data.qpos[self._addresses], data.qvel[self._rates]
        now = self.excursions()
        pulling = [k for k, m in enumerate(self._modes) if m == "pull" and self.drives[k] != THUMB]
        share = self._max_tension[self.drives.index(THUMB)] / (THUMB_RESERVE * max(len(pulling), 1))
        goal, pull = now.copy(), np.zeros(len(self.drives))
        for k, (mode, value) in enumerate(zip(self._modes, self._values, strict=True)):
            if mode == "position":
                self._goal[k] += np.clip(value - self._goal[k], -stride, stride)
                goal[k] = self._goal[k]
            elif mode == "pull":
                pull[k] = min(
                    max(value, 0.0), self._max_tension[k], share if k in pulling else np.inf
                )
        target = self.posture(goal)
        stiffness, damping = (part.copy() for part in self._position_gains)
        limit = np.full(len(q), np.inf)
        for k, mode in enumerate(self._modes):
            mine = self._owner == k
            moved = mine & (self._arms[k] != 0.0)
            if mode == "pull":
                stiffness[moved] *= PULL_SHARE
            elif mode == "hold":
                target[mine] = self._kept[mine]
                stiffness[mine], damping[mine] = self._hold[0][mine], self._hold[1][mine]
                limit[moved] = np.abs(self._arms[k, moved]) * max(self._values[k], 0.0)
        still = ~np.any(self._arms != 0.0, axis=0)
        stiffness[still], damping[still] = self._hold[0][still], self._hold[1][still]
        torque = np.clip(stiffness * (target - q), -limit, limit) - damping * speed
        torque += self._arms.T @ pull
        self._tensions = self._arms @ torque / np.sum(self._arms**2, axis=1)
        # Weight and inertia are compensated, and do not count as tension of the grip.
        weight = data.qfrc_bias[self._rates] - data.qfrc_gravcomp[self._rates]
        self._drive(torque + weight)

    def reading(self, tips: tuple[TactileImage, ...] = ()) -> HandReading:
        """Return the current sensor values, together with the given tactile images."""
        angles = self._data.qpos[self._addresses[: self._count]]
        low, high = self._open[: self._count], self._closed[: self._count]
        return HandReading(
            excursions=self.excursions(),
            tensions=np.maximum(self._tensions, 0.0),
            angles=np.where(high < low, -angles, angles),
            forces=pad_forces(self._data, self._pad_of_geom, len(self.pads)),
            tips=tips,
        )

    def _drive(self, torque: NDArray[np.float64]) -> None:
        model, data, motors = self._model, self._data, self._motors
        force = self._shares @ torque
        bias = model.actuator_biasprm[motors]
        force -= bias[:, 0] + bias[:, 1] * data.actuator_length[motors]
        force -= bias[:, 2] * data.actuator_velocity[motors]
        control = force / model.actuator_gainprm[motors, 0]
        limited = model.actuator_ctrllimited[motors].astype(bool)
        low, high = model.actuator_ctrlrange[motors].T
        data.ctrl[motors] = np.where(limited, np.clip(control, low, high), control)

    def _max_tensions(self, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the tension at which a motor of each drive first reaches its limit, (D,), N."""
        model, motors = self._model, self._motors
        most = np.where(
            model.actuator_forcelimited[motors].astype(bool),
            np.abs(model.actuator_forcerange[motors]).max(axis=1),
            np.inf,
        )
        plain = (model.actuator_biasprm[motors, 1] == 0) & (
            model.actuator_ctrllimited[motors].astype(bool)
        )
        torque = model.actuator_gainprm[motors, 0] * model.actuator_ctrlrange[motors, 1]
        most = np.where(plain, np.minimum(most, np.abs(torque)), most)
        forces = np.abs(self._shares @ self._arms.T)
        with np.errstate(divide="ignore"):
            return np.min(np.where(forces > 0, most[:, None] / forces, np.inf), axis=0)


def _arms(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    owner: NDArray[np.intp],
    moved: NDArray[np.bool_],
    slides: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """Compute the moment arms of the virtual tendons, (D, J), m/rad (m/m for slides)."""
    arms = np.zeros((owner.max() + 1, len(owner)))
    for k in range(len(arms)):
        change = np.where((owner == k) & moved, end - start, 0.0)
        if not change.any():
            continue
        number = np.cumsum(change != 0.0) - 1
        unit = np.where(slides, SLIDE_ARM, HINGE_ARM_M)
        arms[k] = unit * TAPER ** np.maximum(number, 0) * np.sign(change)
    return arms


def _motors(model: Any, joints: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Find the motors that move joints, (A,), and the joints' moments on them, (A, J)."""
    mujoco = import_mujoco()
    on_joint, on_tendon = int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_TENDON)
    column = {int(joint): k for k, joint in enumerate(joints)}
    motors, moments = [], []
    for motor in range(model.nu):
        kind, target = int(model.actuator_trntype[motor]), int(model.actuator_trnid[motor, 0])
        parts: dict[int, float] = {}
        if kind == on_joint:
            parts = {target: 1.0}
        elif kind == on_tendon:
            first = model.tendon_adr[target]
            for w in range(first, first + model.tendon_num[target]):
                if int(model.wrap_type[w]) == int(mujoco.mjtWrap.mjWRAP_JOINT):
                    parts[int(model.wrap_objid[w])] = float(model.wrap_prm[w])
        row = np.zeros(len(joints))
        for joint, moment in parts.items():
            if joint in column:
                row[column[joint]] = moment * model.actuator_gear[motor, 0]
        if row.any():
            motors.append(motor)
            moments.append(row)
    if not motors:
        raise InputError("no motor moves a joint of the hand's description")
    return np.array(motors), np.array(moments)


def _pads(model: Any, description: HandDescription, prefix: str) -> NDArray[np.intp]:
    """Return the pad number of each geom, (ngeom,); -1 for none."""
    kind = import_mujoco().mjtObj.mjOBJ_GEOM
    pad_of_geom = np.full(model.ngeom, -1)
    fingertips = [name for finger in description.fingers for name in finger.pads]
    for k, name in enumerate(fingertips):
        pad_of_geom[_id(model, kind, prefix + name)] = k
    for name in description.palm:
        pad_of_geom[_id(model, kind, prefix + name)] = len(fingertips)
    return pad_of_geom


def _id(model: Any, kind: Any, name: str) -> int:
    mujoco = import_mujoco()
    found = mujoco.mj_name2id(model, kind, name)
    if found >= 0:
        return int(found)
    joint = kind == mujoco.mjtObj.mjOBJ_JOINT
    what, count = ("joint", model.njnt) if joint else ("geom", model.ngeom)
    names = [mujoco.mj_id2name(model, kind, k) or "" for k in range(count)]
    raise InputError(
        f"the hand's description names a {what} {name!r}, which its MJCF file does not have; "
        + suggest_names(name, names)
    )
