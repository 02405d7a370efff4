"""Close a gripper without physics: one number from open to closed moves all its joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from eyehand.errors import InputError

from .links import Links, couplings, tendon_joints
from .read_model import Model, load_mujoco

STEPS = 21
"""Postures from open to closed."""
LOOP_WEIGHT = 1e3
"""Weight of an open loop of 1 m, or a coupling that is 1 rad off, against the springs."""
SPRING_WEIGHT = 0.1
"""Weight of a spring's deflection. It decides what loops leave free."""
REST_WEIGHT = 1e-3
"""Weight of the distance of joints from the posture before."""
SHORT_SHARE = 0.05
"""Share of a joint's range that its motor must leave out to be reported."""
MAX_LOOP_ERROR = 2e-3
"""Maximum gap of a closed loop, m."""


@dataclass(frozen=True, eq=False)
class Drives:
    """Joints that are moved, with their positions in the two end postures."""

    joints: tuple[int, ...]
    """Joints that no other joint drives."""
    first: NDArray[np.float64]
    """Positions at one end of their ranges, m or rad."""
    last: NDArray[np.float64]
    """Positions at the other end, m or rad."""


def find_drives(links: Links, joints: list[int], given: tuple[float, float] | None) -> Drives:
    """Return the joints of a gripper that others follow, with their ranges.

    Parameters
    ----------
    links
        The links.
    joints
        Joints of the gripper.
    given
        Range of joints without a range, m or rad.

    Raises
    ------
    InputError
        If a joint has no range and none is given.
    """
    model, mujoco = links.model, load_mujoco()
    follows = _mimics(model)
    driven: set[int] = set()
    for actuator in range(model.nu):
        target = int(model.actuator_trnid[actuator, 0])
        kind = int(model.actuator_trntype[actuator])
        if kind == int(mujoco.mjtTrn.mjTRN_TENDON):
            driven |= set(tendon_joints(model, target))
        elif kind in (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)):
            driven.add(target)
    looped = _looped(links)
    free = [joint for joint in joints if joint not in follows]
    chosen = [joint for joint in free if joint in driven]
    # A motor on a joint that follows another one drives the other one.
    for group in couplings(links):
        if group & driven and not group & set(chosen):
            chosen += [joint for joint in free if joint in group and joint not in looped]
    chosen = chosen or [joint for joint in free if joint not in looped] or free[:1]
    ranges = np.array([_range(links, joint, given, alone=len(joints) == 1) for joint in chosen])
    return Drives(tuple(chosen), ranges[:, 0], ranges[:, 1])


def _mimics(model: Model) -> set[int]:
    """Return the joints that follow another joint by an equality constraint."""
    kind = int(load_mujoco().mjtEq.mjEQ_JOINT)
    return {
        int(model.eq_obj1id[e])
        for e in range(model.neq)
        if int(model.eq_type[e]) == kind and model.eq_active0[e] and model.eq_obj2id[e] >= 0
    }


def _looped(links: Links) -> set[int]:
    """Return the joints of closed loops that do not move directly on a link with several joints."""
    model, mujoco = links.model, load_mujoco()
    found: set[int] = set()
    for equality in range(model.neq):
        if int(model.eq_type[equality]) in (
            int(mujoco.mjtEq.mjEQ_CONNECT),
            int(mujoco.mjtEq.mjEQ_WELD),
        ):
            for body in (int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])):
                if model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_BODY:
                    found |= set(links.joints([links.of_body[body]]))
    return found


def _range(
    links: Links, joint: int, given: tuple[float, float] | None, *, alone: bool
) -> tuple[float, float]:
    model = links.model
    low, high = -np.inf, np.inf
    if model.jnt_limited[joint]:
        low, high = (float(value) for value in model.jnt_range[joint])
    least, most = _servo_range(model, joint)
    # A servo may use a part of the joint's range only.
    if max(low, least) < min(high, most):
        low, high = max(low, least), min(high, most)
    if given is not None and not (np.isfinite(low) and np.isfinite(high)):
        low, high = given
    if not (np.isfinite(low) and np.isfinite(high)):
        name = model.joint(joint).name
        if alone:
            raise InputError(
                f"no gripper is found: {name!r}, the last joint, turns without limits, as the "
                "wrist of an arm; --range LOW HIGH limits the joint of a jaw"
            )
        raise InputError(f"--range is needed: joint {name!r} has no limits")
    return low, high


def _servo_range(model: Model, joint: int) -> tuple[float, float]:
    """Return the range of a position servo on a joint; infinite without one."""
    for actuator in range(model.nu):
        aimed = int(model.actuator_trntype[actuator]) == int(load_mujoco().mjtTrn.mjTRN_JOINT)
        stiffness = -float(model.actuator_biasprm[actuator, 1])
        if (
            aimed
            and int(model.actuator_trnid[actuator, 0]) == joint
            and stiffness > 0
            and model.actuator_ctrllimited[actuator]
        ):
            gear = float(model.actuator_gear[actuator, 0]) or 1.0
            gain = float(model.actuator_gainprm[actuator, 0])
            ends = sorted(
                gain * float(end) / stiffness / gear for end in model.actuator_ctrlrange[actuator]
            )
            return ends[0], ends[1]
    return -np.inf, np.inf


class Posing:
    """A gripper that is posed by the shares of its drives' ranges.

    The drives are set, and the other joints follow: couplings and closed loops by least squares,
    springs where loops leave a choice.
    """

    def __init__(self, links: Links, joints: list[int], drives: Drives) -> None:
        mujoco = load_mujoco()
        model = links.model
        self.links, self.model, self.drives, self._mujoco = links, model, drives, mujoco
        self.data: Any = mujoco.MjData(model)
        kinds = mujoco.mjtDisableBit
        model.opt.disableflags |= (
            kinds.mjDSBL_CONTACT | kinds.mjDSBL_LIMIT | kinds.mjDSBL_FRICTIONLOSS
        )
        self._followers = [joint for joint in joints if joint not in drives.joints]
        self._place = model.jnt_qposadr[self._followers].astype(int)
        self._speed = model.jnt_dofadr[self._followers].astype(int)
        self._driven = model.jnt_qposadr[list(drives.joints)].astype(int)
        limited = model.jnt_limited[self._followers].astype(bool)
        # Joints that mimic others have the same limits. Rounding must not stop them there.
        limited &= ~np.isin(self._followers, sorted(_mimics(model)))
        spans = model.jnt_range[self._followers]
        self._low = np.where(limited, spans[:, 0], -np.inf)
        self._high = np.where(limited, spans[:, 1], np.inf)
        self._spring = SPRING_WEIGHT * np.sqrt(
            model.jnt_stiffness[self._followers].reshape(-1, 1)[:, 0]
        )
        self._rest = model.qpos_spring[self._place]
        self._rows = np.zeros(0, dtype=int)
        self.start = np.array(model.qpos0)
        if model.nkey:
            home = [k for k in range(model.nkey) if model.key(k).name == "home"]
            if home:
                self.start = np.array(model.key_qpos[home[0]])

    def unmoved(self, path: NDArray[np.float64]) -> list[str]:
        """Return the names of the joints that do not move along a path, (n, nq)."""
        still = np.ptp(path[:, self._place], axis=0) == 0.0
        moved = zip(self._followers, still, strict=True)
        return [self.model.joint(joint).name for joint, alone in moved if alone]

    def short_motors(self, opened: NDArray[np.float64]) -> list[str]:
        """Return a remark for each motor that ends before its joint in the open posture (nq,)."""
        remarks = []
        for joint in self.drives.joints:
            low, high = (float(value) for value in self.model.jnt_range[joint])
            most = _servo_range(self.model, joint)
            end = float(opened[self.model.jnt_qposadr[joint]])
            rest = min(high - end, end - low) if self.model.jnt_limited[joint] else 0.0
            if min(abs(end - one) for one in most) < 1e-6 and rest > SHORT_SHARE * (high - low):
                remarks.append(
                    f"the motor of joint {self.model.joint(joint).name!r} moves it from "
                    f"{most[0]:g} to {most[1]:g}, and its range is {low:g} to {high:g}: check the "
                    "ctrlrange, the jaws may open wider"
                )
        return remarks

    def path(self, first: NDArray[np.float64], last: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the postures (STEPS, nq) between two positions of the drives.

        Raises
        ------
        InputError
            If a loop cannot be closed in one of the postures.
        """
        # Solve from the file's own posture to the first end, then along the path.
        posture = self.start.copy()
        begin = posture[self._driven].copy()
        if self.model.neq:
            for share in np.linspace(0.0, 1.0, 6):
                posture = self._solved(posture, begin + share * (first - begin))
        found = []
        for share in np.linspace(0.0, 1.0, STEPS):
            posture = self._solved(posture, first + share * (last - first))
            found.append(posture)
        error = max(self._loop_error(posture) for posture in found)
        if error > MAX_LOOP_ERROR:
            raise InputError(
                f"the closed loops of the gripper leave gaps of {1e3 * error:.0f} mm; correct the "
                "ranges of its joints, or the anchors of <connect>, in the file"
            )
        return np.array(found)

    def pose(self, posture: NDArray[np.float64]) -> None:
        """Move the model to a posture (nq,)."""
        self.data.qpos[:] = posture
        self._mujoco.mj_kinematics(self.model, self.data)

    def _solved(
        self, near: NDArray[np.float64], driven: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the posture with given drives next to a posture."""
        posture = near.copy()
        posture[self._driven] = driven
        if not len(self._place) or not self.model.neq:
            return posture

        begin = np.clip(near[self._place], self._low, self._high)

        # The variables are changes: SciPy takes their size at the start as that of its first step.
        def residuals(change: NDArray[np.float64]) -> NDArray[np.float64]:
            values = posture[self._place] = begin + change
            errors = LOOP_WEIGHT * self._constraints(posture)[0]
            return np.concatenate(
                [errors, self._spring * (values - self._rest), REST_WEIGHT * change]
            )

        def slopes(change: NDArray[np.float64]) -> NDArray[np.float64]:
            posture[self._place] = begin + change
            jacobian = self._constraints(posture)[1][:, self._speed]
            rest = REST_WEIGHT * np.eye(len(change))
            return np.vstack([LOOP_WEIGHT * jacobian, np.diag(self._spring), rest])

        found = least_squares(
            residuals,
            np.zeros(len(begin)),
            jac=cast("Any", slopes),
            bounds=(self._low - begin, self._high - begin),
            method="dogbox",
            max_nfev=60,
        )
        posture[self._place] = begin + found.x
        return posture

    def _constraints(
        self, posture: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return errors (n,) and Jacobian (n, nv) of all equality constraints."""
        data, mujoco = self.data, self._mujoco
        data.qpos[:] = posture
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        mujoco.mj_tendon(self.model, data)
        mujoco.mj_makeConstraint(self.model, data)
        rows = np.asarray(data.efc_type) == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        self._rows = np.array(data.efc_id)[rows]
        jacobian = np.asarray(data.efc_J).reshape(-1, self.model.nv)
        return np.array(data.efc_pos)[rows], np.array(jacobian[rows])

    def _loop_error(self, posture: NDArray[np.float64]) -> float:
        """Return the largest gap of a closed loop that the gripper's joints move, m."""
        errors, jacobian = self._constraints(posture)
        kinds = self.model.eq_type[self._rows]
        eq = self._mujoco.mjtEq
        loop = (kinds == int(eq.mjEQ_CONNECT)) | (kinds == int(eq.mjEQ_WELD))
        mine = np.abs(jacobian[:, self._speed]).max(axis=1, initial=0.0) > 0
        return float(np.abs(errors[mine & loop]).max(initial=0.0))
