"""The kinematics of a robot from an MJCF or URDF file: controlled joints and a controlled frame."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eyehand.errors import InputError

from .array_checks import checked_array, read_only
from .joint_defaults import SCALAR_JOINTS, home_posture, joint_acceleration, joint_speed
from .kinematics_kernels import frame_state
from .mujoco_binding import Data, Model, Spec, address, mujoco
from .robot_source import Source, compile_spec, read_robot
from .robot_state import RobotState

_Array = NDArray[np.float64]
_FrameArrays = tuple[NDArray[np.bool_], _Array, _Array, _Array, _Array]


_ORIGIN = np.zeros(3)
_FLOAT = np.dtype(np.float64)


class RobotModel:
    """A robot with n controlled joints and one controlled frame. Create it with :meth:`load`.

    One model is for one thread, because it computes in MuJoCo's buffers. Its results are copies.
    """

    joint_names: tuple[str, ...]
    """Names of the controlled joints, in the order of the columns of every Jacobian."""
    n: int
    """Number of controlled joints."""
    lower: NDArray[np.float64]
    """Lower joint limits (n,), rad (m for a slide joint), -inf where there is none."""
    upper: NDArray[np.float64]
    """Upper joint limits (n,), inf where there is none."""
    home: NDArray[np.float64]
    """Home posture (n,)."""
    speed: NDArray[np.float64]
    """Joint speed limits (n,), rad/s or m/s."""
    acceleration: NDArray[np.float64]
    """Joint acceleration limits (n,), rad/s² or m/s²; inf where there is none."""
    jerk: NDArray[np.float64]
    """Joint jerk limits (n,), rad/s³ or m/s³; inf where there is none."""
    frame: str
    """Name of the controlled frame: a site or a body."""

    @classmethod
    def load(
        cls,
        source: Source,
        frame: str,
        *,
        home: ArrayLike | None = None,
        joints: Sequence[str] | None = None,
        speed: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        jerk: ArrayLike | None = None,
        package_dirs: Sequence[str | Path] = (),
    ) -> RobotModel:
        """Load a robot.

        Parameters
        ----------
        source
            Path of an MJCF or URDF file, XML text, or an ``MjSpec``, which is copied. Mesh paths
            are relative to the file.
        frame
            Name of the site or body to control. A site has priority over a body of the same name.
        home
            Home posture (n,). Default: the keyframe ``home``, else the middle of the joint limits
            (0 where there are none). Joints that are not controlled stay at home.
        joints
            Names of the controlled hinge and slide joints, in the order of ``q``. Default: all but
            those of grippers, in the order of the file. A joint belongs to a gripper if an equality
            constraint or a tendon couples it to another joint.
        speed
            Joint speed limits, one number or (n,), rad/s or m/s. Default: the numeric
            ``joint_speed`` of an MJCF, else the ``<limit velocity>`` of a URDF, else 1.5 rad/s for
            a hinge joint and 0.5 m/s for a slide joint.
        acceleration
            Joint acceleration limits, one number or (n,), rad/s² or m/s²; inf for none. Default:
            the numeric ``joint_acceleration`` of an MJCF, else 7.5 rad/s² for a hinge joint and
            2.5 m/s² for a slide joint.
        jerk
            Joint jerk limits, one number or (n,), rad/s³ or m/s³; inf for none. Default: the
            numeric ``joint_jerk`` of an MJCF, else 500 1/s times the acceleration limit.
        package_dirs
            Folders that hold the packages of a URDF with ``package://`` paths. The folders of the
            environment variables ROS_PACKAGE_PATH and AMENT_PREFIX_PATH follow.

        Raises
        ------
        InputError
            If the file cannot be read, a name is unknown, a controlled joint is a free or ball
            joint, or home or a limit is invalid.
        """
        spec = read_robot(source, package_dirs)
        return cls(spec, frame, home, joints, (speed, acceleration, jerk))

    def __init__(
        self,
        spec: Spec,
        frame: str,
        home: ArrayLike | None,
        joints: Sequence[str] | None,
        given: tuple[ArrayLike | None, ArrayLike | None, ArrayLike | None],
    ) -> None:
        self.spec = spec
        self.model = model = compile_spec(spec)
        self.data = data = mujoco.MjData(model)
        self.joints = _joint_ids(model, joints)
        self.n = len(self.joints)
        # MuJoCo numbers joints from base to tip.
        in_order = bool(np.all(np.diff(self.joints) > 0))
        self._from_base = None if in_order else read_only(np.argsort(self.joints))
        self.joint_names = tuple(model.joint(int(joint)).name for joint in self.joints)
        qpos_indices = model.jnt_qposadr[self.joints]
        self.hinge = model.jnt_type[self.joints] == mujoco.mjtJoint.mjJNT_HINGE
        limited = model.jnt_limited[self.joints].astype(bool)
        span = model.jnt_range[self.joints]
        self.lower = read_only(np.where(limited, span[:, 0], -np.inf))
        self.upper = read_only(np.where(limited, span[:, 1], np.inf))
        posture = home_posture(model, self.joints, home)
        self.home_qpos = read_only(posture)
        self.home = read_only(posture[qpos_indices])
        speed, acceleration, jerk = given
        self.speed = read_only(joint_speed(model, self.joints, speed))
        limits = joint_acceleration(model, self.joints, acceleration, jerk)
        self.acceleration, self.jerk = map(read_only, limits)
        self.moves = _moves(model, self.joints)
        self.frame = frame
        self.frame_body, position, matrix = _frame(model, data, frame)
        self.frame_in_body = _frame_in_body(model, frame)
        data.qpos[:] = posture
        frame_moves = np.ascontiguousarray(self.moves[self.frame_body])
        self._frame = (frame_moves, data.xanchor, data.xaxis, position, matrix)
        self.joint_table = np.column_stack([qpos_indices, self.joints, self.hinge]).astype(np.int64)
        """(n, 3): index in ``qpos``, id, 1 for a hinge and 0 for a slide joint."""
        self._addresses = (address(model), address(data))
        self.at(self.home)

    def duplicate(self) -> RobotModel:
        """Return the same robot with buffers of its own, for another thread."""
        other = copy.copy(self)
        other.data = data = mujoco.MjData(self.model)
        data.qpos[:] = self.home_qpos
        _, position, matrix = _frame(self.model, data, self.frame)
        other._frame = (self._frame[0], data.xanchor, data.xaxis, position, matrix)
        other._addresses = (address(self.model), address(data))
        other.at(self.home)
        return other

    def at(self, q: ArrayLike) -> RobotState:
        """Compute pose and Jacobian of the controlled frame at joint positions ``q`` (n,).

        Raises
        ------
        InputError
            If q is not n finite numbers.
        """
        q = self.checked(q)
        point, rotation, jacobian = self._at(q, self._frame, _ORIGIN)
        # The constructor would check these valid arrays again, and double the time.
        state = object.__new__(RobotState)
        vars(state).update(
            q=q,
            position=point,
            rotation=rotation,
            jacobian=jacobian,
            lower=self.lower,
            upper=self.upper,
            home=self.home,
            speed=self.speed,
            acceleration=self.acceleration,
            jerk=self.jerk,
            from_base=self._from_base,
        )
        return state

    def point_jacobian(self, q: ArrayLike, body: str, point: ArrayLike) -> NDArray[np.float64]:
        """Compute the linear Jacobian (3, n) of a point fixed to a body, world axes.

        Parameters
        ----------
        q
            Joint positions (n,).
        body
            Name of the body or site.
        point
            The point in the frame of the body or site (3,), m.

        Raises
        ------
        InputError
            If q or the point has a wrong shape or is not finite, or the body is unknown.
        """
        q = self.checked(q)
        offset = checked_array("point", point, (3,))
        body_id, position, matrix = _frame(self.model, self.data, body)
        moves = np.ascontiguousarray(self.moves[body_id])
        frame = (moves, self.data.xanchor, self.data.xaxis, position, matrix)
        return self._at(q, frame, offset)[2][:3].copy()

    def limits(self, *, instant: bool = False) -> NDArray[np.float64]:
        """Return the limits (n, 5) for kernels: lower, upper, speed, acceleration, jerk.

        With ``instant``, those of acceleration and jerk are infinite.
        """
        changes = np.column_stack([self.acceleration, self.jerk])
        changes = np.full_like(changes, np.inf) if instant else changes
        return np.column_stack([self.lower, self.upper, self.speed, changes])

    def checked(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return a copy (n,) of joint positions; raise an :class:`InputError` if invalid."""
        numbers = self.numbers(q)
        if not math.isfinite(np.vdot(numbers, numbers)):
            raise InputError(f"q must be finite, got {numbers.tolist()}")
        return numbers

    def numbers(self, q: ArrayLike) -> NDArray[np.float64]:
        """Return a copy (n,) of joint positions that may be infinite or NaN.

        Raises
        ------
        InputError
            If q has another shape, or is not real numbers.
        """
        # Every control cycle calls this, so it is faster than `checked_array`.
        if type(q) is np.ndarray and q.dtype is _FLOAT and q.shape == (self.n,):
            return q.copy()
        if isinstance(q, np.ndarray) and q.dtype.kind == "c":
            raise InputError(f"q must be {self.n} real numbers, got {q.tolist()}")
        try:
            numbers = np.array(q, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"q must be {self.n} numbers, got {q!r}") from None
        if numbers.shape != (self.n,):
            raise InputError(
                f"q must have shape ({self.n},), one number for each of "
                f"{', '.join(self.joint_names)}, got {numbers.shape}"
            )
        return numbers

    def _at(
        self, q: NDArray[np.float64], frame: _FrameArrays, offset: NDArray[np.float64]
    ) -> tuple:
        return frame_state(*self._addresses, q, self.data.qpos, self.joint_table, *frame, offset)


def _joint_ids(model: Model, names: Sequence[str] | None) -> NDArray[np.int64]:
    known = {model.joint(joint).name: joint for joint in range(model.njnt)}
    scalar = {name: j for name, j in known.items() if int(model.jnt_type[j]) in SCALAR_JOINTS}
    choices = ", ".join(scalar) or "none"
    if isinstance(names, str):
        raise InputError(f"joints must be a list of names, got {names!r}")
    for name in names or ():
        if name not in known:
            raise InputError(f"unknown joint {name!r}; hinge and slide joints: {choices}")
        if name not in scalar:
            raise InputError(
                f"joint {name!r} is a free or ball joint, which cannot be controlled; "
                f"hinge and slide joints: {choices}"
            )
    if names is None:
        # Not from `scalar`: several joints may have no name.
        joints = [j for j in range(model.njnt) if int(model.jnt_type[j]) in SCALAR_JOINTS]
        coupled = _coupled_joints(model)
        joints = [j for j in joints if j not in coupled] or joints
    else:
        joints = [scalar[name] for name in names]
        if len(set(joints)) != len(joints):
            raise InputError(f"joints must differ, got {list(names)}")
    if not joints:
        raise InputError(f"the robot needs at least one controlled joint; there are: {choices}")
    return np.array(joints, dtype=np.int64)


def _coupled_joints(model: Model) -> set[int]:
    """Return the joints that an equality constraint or a tendon couples to another joint."""
    coupled = set()
    for equality in range(model.neq):
        joints = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
        if int(model.eq_type[equality]) == mujoco.mjtEq.mjEQ_JOINT and min(joints) >= 0:
            coupled.update(joints)
    for tendon in range(model.ntendon):
        first = int(model.tendon_adr[tendon])
        wraps = range(first, first + int(model.tendon_num[tendon]))
        joints = [
            int(model.wrap_objid[k])
            for k in wraps
            if int(model.wrap_type[k]) == mujoco.mjtWrap.mjWRAP_JOINT
        ]
        if len(joints) > 1:
            coupled.update(joints)
    return coupled


def _frame(
    model: Model, data: Data, name: str
) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """Return the body that carries the frame, and views of its origin (3,) and axes (9,)."""
    sites = {model.site(site).name: site for site in range(model.nsite)}
    bodies = {model.body(body).name: body for body in range(1, model.nbody)}
    if name and name in sites:
        site = sites[name]
        return int(model.site_bodyid[site]), data.site_xpos[site], data.site_xmat[site]
    if name and name in bodies:
        body = bodies[name]
        return body, data.xpos[body], data.xmat[body]
    raise InputError(
        f"unknown frame {name!r}; there are sites {', '.join(filter(None, sites)) or 'none'}; "
        f"bodies {', '.join(filter(None, bodies)) or 'none'}"
    )


def _frame_in_body(model: Model, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return origin (3,) and quaternion (w, x, y, z) of a known frame in its body."""
    for site in range(model.nsite):
        if model.site(site).name == name:
            return model.site_pos[site].copy(), model.site_quat[site].copy()
    return np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])


def _moves(model: Model, joints: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return the mask (bodies, n) of the controlled joints that move each body."""
    moves = np.zeros((model.nbody, len(joints)), dtype=bool)
    for body in range(1, model.nbody):
        moves[body] = moves[model.body_parentid[body]] | (model.jnt_bodyid[joints] == body)
    return moves
