"""The gripper in a simulated robot: its jaws as described, and the motors that move them.

A gripper has one motor for both jaws, or one for each joint of two fingers. `describe_hand` says
how the joints move with the width. This module adds what a simulation needs: the motors, their
positions at each width, and what each contributes to the closing force.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.grasping.hands import JawPostures, describe_hand

from ..mujoco_import import import_mujoco
from .robot_file import compile_robot, read_robot

SERVO_RATE = 150.0
"""Natural frequency of the servos of the motors, rad/s. A stiffer one needs a physics step below
2 ms."""
PAD_MIDDLE = 0.01
"""Distance of the middle of a pad from the fingertips, m."""
MIN_MOTION = 1e-3
"""Least motion of a joint that needs a motor, m or rad."""
MIN_OVERLAP = 1e-3
"""Overlap of two parts of a gripper from which on it comes from rough shapes, m."""
HINGE_ARMATURE, SLIDE_ARMATURE = 1e-3, 0.5
"""Inertia of the geared motor of a finger's joint where the file has none, kg m² and kg. It makes
the servo of a small fingertip as stiff as that of a real hand. With that of a hinge for a slide,
the light jaws of a YuMi gripper stall on an object. The value for slides is an estimate."""
MAX_ARMATURE = 100.0
"""Maximum inertia as a multiple of those. A file of the Spot gripper has 1 kg m² and a 3 kN motor.
With a usual force, such jaws take 1.6 s to close, and rebound from the object."""


@dataclass(frozen=True, eq=False)
class JawMechanism:
    """Two jaws with their motors, and their positions from the closed to the open gripper."""

    root: str
    """Body that carries the jaws."""
    motors: tuple[str, ...]
    """Actuators that move the jaws: one for both, or one for each joint of two fingers."""
    joints: tuple[str, ...]
    """Joints of the gripper in the order of the model."""
    jaws: tuple[tuple[str, ...], tuple[str, ...]]
    """Bodies of the jaws at -x and +x of the tool frame."""
    T_root_tool: RigidTransform
    """Tool frame: z along the approach, x along the closing direction, origin midway between the
    fingertips of the closed gripper."""
    widths: NDArray[np.float64]
    """Distances between the pads, (K,), increasing, m."""
    lengths: NDArray[np.float64]
    """Length of each motor's transmission at each of them, (K, M), m or rad."""
    postures: NDArray[np.float64]
    """Positions of `joints` at each of them, (K, J), m or rad."""
    slopes: NDArray[np.float64]
    """Change of the width per change of each length, (K, M). A force of 1 N of both jaws is a force
    of `slopes` on the motors."""
    stiffness: NDArray[np.float64]
    """Stiffness of a servo of each length with the natural frequency `SERVO_RATE`, (M,), N/m or
    Nm/rad."""
    force: float
    """Maximum closing force of each jaw by the limits of the motors, N; inf without limits."""
    overlaps: frozenset[tuple[str, str]]
    """Pairs of bodies that overlap in one of the postures, besides the two jaws."""

    @property
    def stroke(self) -> float:
        """Maximum distance between the pads, m."""
        return float(self.widths[-1])

    def posture(self, width: float) -> NDArray[np.float64]:
        """Return the positions of `joints` (J,) at a distance between the pads in m."""
        return np.array([np.interp(width, self.widths, column) for column in self.postures.T])


def find_jaws(path: Path) -> JawMechanism:
    """Find the gripper in the MJCF file of a hand, or of a robot with one.

    Raises
    ------
    InputError
        If there is no gripper, or its motors do not move its joints.
    """
    # A linkage takes a second to describe, and each scene of a run asks for it.
    return _find_jaws(path, path.stat().st_mtime_ns if path.is_file() else 0)


@functools.lru_cache(maxsize=4)
def _find_jaws(path: Path, modified: int) -> JawMechanism:
    found = describe_hand(path).postures
    spec = read_robot(path)
    name_parts(spec)
    limit_armature(spec, found.joints)
    model = compile_robot(spec, path.name)
    mujoco = import_mujoco()
    data = mujoco.MjData(model)
    motors = _motors(model, data, found, path.name)
    if len(motors) > 1:
        limit_armature(spec, found.joints, least=1.0)
        model = compile_robot(spec, path.name)
        data = mujoco.MjData(model)
    addresses = [int(model.joint(name).qposadr[0]) for name in found.joints]
    lengths, slopes, touching = [], [], set[tuple[str, str]]()
    for width, posture in zip(found.widths, found.positions, strict=True):
        data.qpos[addresses] = posture
        mujoco.mj_forward(model, data)
        lengths.append(data.actuator_length[motors].copy())
        touching |= _overlaps(model, data, int(model.body(found.body).id))
        slopes.append(_slopes(model, data, found, motors, float(width)))
    along = np.array(lengths)
    if len(motors) == 1:
        travel = along[-1] - along[0]
        if abs(float(travel[0])) < 1e-6:
            raise InputError(f"{path.name}: the motor does not move the jaws")
        slopes = [(found.widths[-1] - found.widths[0]) / travel] * len(along)
    limits = _limits(model, motors)
    sides = found.sides
    opposed = {pair for a in sides[0] for b in sides[1] for pair in ((a, b), (b, a))}
    force = np.min(limits / np.maximum(np.abs(slopes), 1e-9).max(axis=0))
    return JawMechanism(
        root=found.body,
        motors=tuple(model.actuator(motor).name for motor in motors),
        joints=found.joints,
        jaws=sides,
        T_root_tool=found.T_body_tool,
        widths=found.widths,
        lengths=along,
        postures=found.positions,
        slopes=np.array(slopes),
        stiffness=_stiffness(model, motors),
        force=float(force),
        overlaps=frozenset(touching - opposed),
    )


def _overlaps(model: Any, data: Any, root: int) -> set[tuple[str, str]]:
    """Return the pairs of bodies on a body whose shapes overlap."""
    found = set()
    for contact in data.contact:
        bodies = [int(model.geom_bodyid[geom]) for geom in contact.geom]
        if contact.dist < -MIN_OVERLAP and all(_carries(model, root, body) for body in bodies):
            found.add((model.body(bodies[0]).name, model.body(bodies[1]).name))
    return found


def _carries(model: Any, root: int, body: int) -> bool:
    while body > root:
        body = int(model.body_parentid[body])
    return body == root


def name_parts(spec: Any) -> None:
    """Give a name to each body, joint and actuator of a spec (`MjSpec`) that has none."""
    for kind, parts in (
        ("body", spec.bodies[1:]),
        ("joint", spec.joints),
        ("actuator", spec.actuators),
    ):
        for number, part in enumerate(parts):
            part.name = part.name or f"{kind}_{number}"


def limit_armature(spec: Any, joints: Sequence[str], least: float = 0.0) -> None:
    """Limit the inertia of the motors at joints of a spec (`MjSpec`).

    It is at least ``least`` times, and at most `MAX_ARMATURE` times, the usual one.
    """
    slide = import_mujoco().mjtJoint.mjJNT_SLIDE
    for joint in spec.joints:
        if joint.name in joints:
            usual = SLIDE_ARMATURE if joint.type == slide else HINGE_ARMATURE
            joint.armature = min(max(joint.armature, least * usual), MAX_ARMATURE * usual)


def make_servo(spec: Any, motor: str, stiffness: float) -> None:
    """Make an actuator of a spec (`MjSpec`) a position servo of its transmission's length.

    Its limits of force are kept. Those of the control are removed, because the length is the
    control. The servo of a file may be too soft: that of the Menagerie's Panda holds an object of
    40 mm with 1 N.
    """
    mujoco = import_mujoco()
    actuator = next(one for one in spec.actuators if one.name == motor)
    damping = 2.0 * stiffness / SERVO_RATE
    actuator.dyntype = mujoco.mjtDyn.mjDYN_NONE
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    actuator.gainprm[0] = stiffness
    actuator.biasprm[:3] = [0.0, -stiffness, -damping]
    actuator.ctrllimited = False


def _motors(model: Any, data: Any, found: JawPostures, name: str) -> NDArray[np.intp]:
    """Return the actuators that move joints of the gripper: one, or one for each free joint."""
    import_mujoco().mj_forward(model, data)
    columns = [int(model.joint(joint).dofadr[0]) for joint in found.joints]
    moments = _moments(model, data)[:, columns] != 0.0
    motors = np.flatnonzero(np.any(moments, axis=1))
    idle = ~np.any(moments, axis=0) & (np.ptp(found.positions, axis=0) > MIN_MOTION)
    if not len(motors) or (len(motors) > 1 and not model.neq and idle.any()):
        names = ", ".join(np.array(found.joints)[idle])
        raise InputError(
            f"{name}: one motor must move both jaws, or one motor each joint of the fingers; "
            f"no motor moves {names}"
        )
    return motors


def _moments(model: Any, data: Any) -> NDArray[np.float64]:
    """Return the moments of the actuators, (nu, nv)."""
    moments = np.zeros((model.nu, model.nv))
    import_mujoco().mju_sparse2dense(
        moments, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
    )
    return moments


def _slopes(
    model: Any, data: Any, found: JawPostures, motors: NDArray[np.intp], width: float
) -> NDArray[np.float64]:
    """Return the change of the width per change of each motor's length, (M,)."""
    mujoco = import_mujoco()
    body = model.body(found.body).id
    T_world_body = RigidTransform.from_components(
        data.xpos[body], type(found.T_body_tool.rotation).from_matrix(data.xmat[body].reshape(3, 3))
    )
    T_world_tool = T_world_body * found.T_body_tool
    closing = T_world_tool.rotation.as_matrix()[:, 0]
    change = np.zeros(model.nv)
    for pad, side in zip(found.pads, (-1.0, 1.0), strict=False):
        jacobian = np.zeros((3, model.nv))
        middle = T_world_tool.apply([0.5 * side * width, 0.0, -PAD_MIDDLE])
        mujoco.mj_jac(model, data, jacobian, None, middle, model.body(pad).id)
        change += side * (closing @ jacobian)
    columns = [int(model.joint(joint).dofadr[0]) for joint in found.joints]
    inverse = np.linalg.pinv(_moments(model, data)[motors][:, columns])
    return change[columns] @ inverse


def _limits(model: Any, motors: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the force limit of each motor, (M,), N or Nm; inf without a limit."""
    most = np.abs(model.actuator_forcerange[motors]).max(axis=1)
    return np.where(model.actuator_forcelimited[motors].astype(bool), most, np.inf)


def _stiffness(model: Any, motors: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the stiffness of servos with the natural frequency `SERVO_RATE`, (M,)."""
    mujoco = import_mujoco()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    moments = _moments(model, data)[motors]
    solved = np.zeros_like(moments)
    mujoco.mj_solveM(model, data, solved, moments)
    return SERVO_RATE**2 / np.sum(moments * solved, axis=1)
