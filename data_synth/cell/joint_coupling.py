"""Find the motor of a gripper and the joints that it moves, by constraints and tendons."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..mujoco_import import import_mujoco


def motor_and_joints(model: Any, name: str) -> tuple[int, NDArray[np.intp]]:
    """Return the number of the motor and the joints coupled with it.

    Raises
    ------
    InputError
        If not exactly one motor moves coupled joints. ``name`` is the file in the message.
    """
    group = _coupled_groups(model)
    found: dict[int, list[int]] = {}
    for motor in range(model.nu):
        driven = _driven_joints(model, motor)
        groups = {int(group[joint]) for joint in driven}
        if len(groups) == 1 and np.count_nonzero(group == min(groups)) >= 2:
            found.setdefault(min(groups), []).append(motor)
    if len(found) != 1 or len(next(iter(found.values()))) != 1:
        motors = ", ".join(model.actuator(m).name for motors in found.values() for m in motors)
        raise InputError(
            f"{name}: one motor must move two jaws that an equality constraint or a fixed tendon "
            f"couples; found {motors or 'none'}"
        )
    ((number, (motor,)),) = found.items()
    return motor, np.flatnonzero(group == number)


def _coupled_groups(model: Any) -> NDArray[np.intp]:
    """Return the group of each joint, (njnt,). Coupled joints have the same group."""
    mujoco = import_mujoco()
    group = np.arange(model.njnt)
    loops = int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)

    def join(joints: list[int]) -> None:
        for joint in joints[1:]:
            group[group == group[joint]] = group[joints[0]]

    for number in range(model.neq):
        kind = int(model.eq_type[number])
        first, second = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
        if kind == int(mujoco.mjtEq.mjEQ_JOINT) and second >= 0:
            join([first, second])
        elif kind in loops and int(model.eq_objtype[number]) == int(mujoco.mjtObj.mjOBJ_BODY):
            join(_joints_between(model, first, second))
    for tendon in range(model.ntendon):
        join(_tendon_joints(model, tendon))
    return group


def _driven_joints(model: Any, motor: int) -> list[int]:
    mujoco = import_mujoco()
    kind, target = int(model.actuator_trntype[motor]), int(model.actuator_trnid[motor, 0])
    if kind == int(mujoco.mjtTrn.mjTRN_JOINT):
        return [target]
    if kind == int(mujoco.mjtTrn.mjTRN_TENDON):
        return _tendon_joints(model, target)
    return []


def _tendon_joints(model: Any, tendon: int) -> list[int]:
    wrap_joint = int(import_mujoco().mjtWrap.mjWRAP_JOINT)
    first = int(model.tendon_adr[tendon])
    wraps = range(first, first + int(model.tendon_num[tendon]))
    return [int(model.wrap_objid[w]) for w in wraps if int(model.wrap_type[w]) == wrap_joint]


def _joints_between(model: Any, first: int, second: int) -> list[int]:
    """Return the joints on the paths from two bodies to their nearest common body."""
    above = [carrying_bodies(model, first), carrying_bodies(model, second)]
    bodies = set(above[0]) ^ set(above[1])
    return [joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) in bodies]


def carrying_bodies(model: Any, body: int) -> list[int]:
    """Return a body and all bodies that carry it, the world last."""
    found = [body]
    while found[-1] > 0:
        found.append(int(model.body_parentid[found[-1]]))
    return found


def common_body(model: Any, joints: NDArray[np.intp]) -> int:
    """Return the nearest body that carries all joints."""
    parents = [int(model.body_parentid[model.jnt_bodyid[joint]]) for joint in joints]
    shared = set.intersection(*(set(carrying_bodies(model, body)) for body in parents))
    return max(shared, key=lambda body: len(carrying_bodies(model, body)))
