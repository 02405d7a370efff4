"""Find the gripper in a MuJoCo model: the motor that moves two jaws, their directions and stroke.

A gripper is a group of joints that equality constraints or fixed tendons couple, with a motor on
one of them. The mechanism is moved from end to end once, without gravity and contacts, and measured
at each step. So linkages with closed chains need no further description.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

from ..mujoco_import import import_mujoco
from .geom_extent import extent
from .joint_coupling import carrying_bodies, common_body, motor_and_joints

STEPS = 17
"""Number of measured openings."""
SETTLE_STEPS = 150
"""Physics steps until the mechanism stands still at one of them."""
SERVO_RATE = 150.0
"""Natural frequency of the servo that moves the motor, rad/s. A stiffer one needs a physics step
below 2 ms."""
PAD_LENGTH = 0.02
"""Length of the fingertips, along the approach, between which the opening is measured, m."""
SNAP_ANGLE = np.radians(15.0)
"""Angle within which the approach is set to an axis of the hand's body, rad."""


@dataclass(frozen=True, eq=False)
class JawMechanism:
    """Two jaws with one motor, and their positions from the open to the closed gripper."""

    root: str
    """Body that carries the jaws and the motor."""
    motor: str
    """Actuator that moves the jaws."""
    joints: tuple[str, ...]
    """Joints of the gripper in the order of the model."""
    jaws: tuple[tuple[str, ...], tuple[str, ...]]
    """Bodies of the jaws at -x and +x of the tool frame."""
    T_root_tool: RigidTransform
    """Tool frame: z along the approach, x along the closing direction, origin midway between the
    fingertips of the closed gripper."""
    widths: NDArray[np.float64]
    """Measured distances between the pads, (K,), increasing, m."""
    lengths: NDArray[np.float64]
    """Length of the motor's transmission at each of them, (K,), m or rad."""
    postures: NDArray[np.float64]
    """Positions of `joints` at each of them, (K, J), m or rad."""
    stiffness: float
    """Stiffness of a servo of the transmission's length with the natural frequency `SERVO_RATE`,
    N/m or Nm/rad."""
    force: float
    """Maximum closing force of each jaw by the limits of the motor, N; inf without limits."""

    @property
    def stroke(self) -> float:
        """Maximum distance between the pads, m."""
        return float(self.widths[-1])

    @property
    def ratio(self) -> float:
        """Mean change of the width per change of the transmission's length."""
        change = (self.widths[-1] - self.widths[0]) / (self.lengths[-1] - self.lengths[0])
        return float(change)

    def posture(self, width: float) -> NDArray[np.float64]:
        """Return the positions of `joints` (J,) at a distance between the pads in m."""
        return np.array([np.interp(width, self.widths, column) for column in self.postures.T])


def find_jaws(spec: Any, name: str) -> JawMechanism:
    """Find the gripper of a hand, or of a robot with one.

    Parameters
    ----------
    spec
        `MjSpec` of the hand or the robot. All its bodies must have names.
    name
        Name of the file for messages.

    Raises
    ------
    InputError
        If there is not exactly one gripper with two jaws.
    """
    mujoco = import_mujoco()
    model = _compile(spec, name)
    motor, joints = motor_and_joints(model, name)
    root = common_body(model, joints)
    copied = spec.copy()
    stiffness = _stiffness(model, motor)
    make_servo(copied, model.actuator(motor).name, stiffness)
    moved = _compile(copied, name)
    moved.opt.gravity[:] = 0.0
    moved.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    data = mujoco.MjData(moved)
    if moved.nkey:
        mujoco.mj_resetDataKeyframe(moved, data, 0)
    ends = _length_range(moved, motor, name)
    addresses = moved.jnt_qposadr[joints]
    lengths, postures, states = [], [], []
    for target in np.linspace(*ends, STEPS):
        data.ctrl[motor] = target
        for _ in range(SETTLE_STEPS):
            mujoco.mj_step(moved, data)
        lengths.append(float(data.actuator_length[motor]))
        postures.append(data.qpos[addresses].copy())
        states.append((data.qpos.copy(), _body_positions(data, root)))
    sides, axis = _sides(moved, root, states[0][1], states[-1][1], name)
    rotation = _tool_rotation(moved, data, root, sides, axis, name)
    gaps, tips = [], []
    for qpos, _ in states:
        data.qpos[:] = qpos
        mujoco.mj_forward(moved, data)
        gap, tip = _measure(moved, data, root, sides, rotation)
        gaps.append(gap)
        tips.append(tip)
    order = np.argsort(gaps)
    widths = np.maximum(np.array(gaps)[order], 0.0)
    if widths[-1] - widths[0] < 0.005:
        raise InputError(f"{name}: the jaws move by {1e3 * np.ptp(gaps):.1f} mm only")
    lengths_, postures_ = np.array(lengths)[order], np.array(postures)[order]
    ratio = abs((widths[-1] - widths[0]) / (lengths_[-1] - lengths_[0]))
    limited = bool(model.actuator_forcelimited[motor])
    force = np.abs(model.actuator_forcerange[motor]).max() / ratio if limited else np.inf
    return JawMechanism(
        root=moved.body(root).name,
        motor=moved.actuator(motor).name,
        joints=tuple(moved.joint(joint).name for joint in joints),
        jaws=(_names(moved, sides[0]), _names(moved, sides[1])),
        T_root_tool=RigidTransform.from_components(tips[order[0]], Rotation.from_matrix(rotation)),
        widths=widths,
        lengths=lengths_,
        postures=postures_,
        stiffness=stiffness,
        force=float(force),
    )


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


def _stiffness(model: Any, motor: int) -> float:
    """Return the stiffness of a servo with the natural frequency `SERVO_RATE`."""
    mujoco = import_mujoco()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    moment, solved = np.zeros((model.nu, model.nv)), np.zeros((1, model.nv))
    mujoco.mju_sparse2dense(
        moment, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
    )
    mujoco.mj_solveM(model, data, solved, moment[[motor]])
    return SERVO_RATE**2 / float(moment[motor] @ solved[0])


def _compile(spec: Any, name: str) -> Any:
    try:
        return spec.copy().compile()
    except ValueError as error:
        raise InputError(f"MuJoCo cannot compile {name}: {' '.join(str(error).split())}") from None


def _length_range(model: Any, motor: int, name: str) -> tuple[float, float]:
    """Return the range of the motor's transmission by the limits of its joints."""
    mujoco = import_mujoco()
    target = int(model.actuator_trnid[motor, 0])
    gear = float(model.actuator_gear[motor, 0])
    parts = {target: 1.0}
    if int(model.actuator_trntype[motor]) == int(mujoco.mjtTrn.mjTRN_TENDON):
        first = int(model.tendon_adr[target])
        wraps = range(first, first + int(model.tendon_num[target]))
        parts = {int(model.wrap_objid[w]): float(model.wrap_prm[w]) for w in wraps}
    for joint in parts:
        if not model.jnt_limited[joint]:
            raise InputError(f"{name}: joint {model.joint(joint).name} of the jaws has no range")
    ends = gear * np.sum([share * model.jnt_range[joint] for joint, share in parts.items()], axis=0)
    return float(ends[0]), float(ends[1])


def _body_positions(data: Any, root: int) -> NDArray[np.float64]:
    """Return the positions of all bodies in the frame of the root, (nbody, 3), m."""
    return (data.xpos - data.xpos[root]) @ data.xmat[root].reshape(3, 3)


def _sides(
    model: Any, root: int, start: NDArray[np.float64], end: NDArray[np.float64], name: str
) -> tuple[tuple[list[int], list[int]], NDArray[np.float64]]:
    """Return the bodies of both jaws, and the closing axis in the frame of the root."""
    moved = end - start
    bodies = [
        body
        for body in range(model.nbody)
        if root in carrying_bodies(model, body)[1:] and np.linalg.norm(moved[body]) > 1e-3
    ]
    pairs = [(i, j) for k, i in enumerate(bodies) for j in bodies[k + 1 :]]
    if not pairs:
        raise InputError(f"{name}: no two bodies of the gripper move")
    first, second = max(pairs, key=lambda pair: np.linalg.norm(moved[pair[0]] - moved[pair[1]]))
    axis = moved[first] - moved[second]
    axis = _snapped(axis / np.linalg.norm(axis))
    # The open gripper separates its sides: in the closed one the frames of both jaws may coincide.
    apart = [abs(float((place[first] - place[second]) @ axis)) for place in (start, end)]
    wide = start if apart[0] > apart[1] else end
    middle = 0.5 * (wide[first] + wide[second]) @ axis
    low = [body for body in bodies if wide[body] @ axis < middle]
    high = [body for body in bodies if wide[body] @ axis >= middle]
    return (low, high), axis


def _tool_rotation(
    model: Any,
    data: Any,
    root: int,
    sides: tuple[list[int], list[int]],
    axis: NDArray[np.float64],
    name: str,
) -> NDArray[np.float64]:
    """Return the rotation of the tool frame in that of the root, (3, 3)."""
    positions = _geom_positions(data, root)[_geoms(model, [*sides[0], *sides[1]])]
    if not len(positions):
        raise InputError(f"{name}: the jaws have no geoms that collide")
    approach = positions.mean(axis=0)
    approach = approach - (approach @ axis) * axis
    length = float(np.linalg.norm(approach))
    if length < 1e-3:
        raise InputError(f"{name}: the approach direction of the jaws is not clear")
    approach = _snapped(approach / length)
    return np.column_stack([axis, np.cross(approach, axis), approach])


def _snapped(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the axis of the frame within `SNAP_ANGLE` of a unit direction, else the direction."""
    main = int(np.argmax(np.abs(direction)))
    if abs(direction[main]) < np.cos(SNAP_ANGLE):
        return direction
    snapped = np.zeros(3)
    snapped[main] = np.sign(direction[main])
    return snapped


def _measure(
    model: Any,
    data: Any,
    root: int,
    sides: tuple[list[int], list[int]],
    rotation: NDArray[np.float64],
) -> tuple[float, NDArray[np.float64]]:
    """Return the distance between the pads, m, and the tool's origin in the root's frame, (3,)."""
    turn = data.xmat[root].reshape(3, 3)
    origin = data.xpos[root]
    x, y, z = (turn @ rotation).T
    both = [_geoms(model, side) for side in sides]
    tip = min(extent(model, data, geoms, z)[1] for geoms in both)
    ends = [
        [geom for geom in geoms if extent(model, data, [geom], z)[1] > tip - PAD_LENGTH]
        for geoms in both
    ]
    left, right = extent(model, data, ends[0], x)[1], extent(model, data, ends[1], x)[0]
    across = extent(model, data, [*ends[0], *ends[1]], y)
    place = 0.5 * (left + right) * x + 0.5 * (across[0] + across[1]) * y + tip * z
    # `extent` measures from the world's origin.
    return right - left, turn.T @ (place - origin)


def _geoms(model: Any, bodies: list[int]) -> list[int]:
    """Return the geoms of bodies that collide."""
    return [
        geom
        for geom in range(model.ngeom)
        if int(model.geom_bodyid[geom]) in bodies
        and (model.geom_contype[geom] or model.geom_conaffinity[geom])
    ]


def _geom_positions(data: Any, root: int) -> NDArray[np.float64]:
    return (data.geom_xpos - data.xpos[root]) @ data.xmat[root].reshape(3, 3)


def _names(model: Any, bodies: list[int]) -> tuple[str, ...]:
    return tuple(model.body(body).name for body in bodies)
