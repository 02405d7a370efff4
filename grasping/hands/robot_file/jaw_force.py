"""The closing force of the jaws from the limits of motors and joints."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .jaw_motion import JawMotion
from .read_model import load_mujoco

FORCE_WITHOUT_LIMIT = (0.0, 40.0)
"""Closing force that is assumed where the file does not limit it, N."""
MIN_FORCE = 0.5
"""Least closing force that a gripper can have, N. Files often hold 0 as a placeholder."""
MAX_FORCE = 250.0
"""Greatest closing force of jaws that is believed, N. The strongest electric grippers of light arms
have 235 N. Files hold 10 Nm or 1000 N as placeholders."""
MAX_FINGER_FORCE = 100.0
"""The same for a finger of a hand, N: that of a strong human pinch."""
MIN_LEVER = 1e-4
"""Least motion of a motor or joint that counts, m or rad."""


def closing_force(motion: JawMotion, *, pinch: bool) -> tuple[tuple[float, float], str]:
    """Return the closing force of each jaw, minimum and maximum in N, and a remark.

    The force is that of virtual work: the work of all motors over the way that the pads close. It
    is the mean over the stroke. `pinch` says that two fingers of a hand are the jaws.
    """
    found = _limit(motion)
    assumed = (
        f"{FORCE_WITHOUT_LIMIT[0]:g} to {FORCE_WITHOUT_LIMIT[1]:g} N are assumed; "
        "--force LOW HIGH sets it"
    )
    if found is None:
        return FORCE_WITHOUT_LIMIT, f"the file does not limit the closing force: {assumed}"
    limits = f"the limits of its motors in the file give a closing force of {found:.0f} N"
    if found > (MAX_FINGER_FORCE if pinch else MAX_FORCE):
        return FORCE_WITHOUT_LIMIT, f"{limits}, which is not credible: {assumed}"
    advice = "compare it with the data sheet; --force LOW HIGH sets it"
    return (0.0, round(found, 1)), f"{limits}: {advice}"


def _limit(motion: JawMotion) -> float | None:
    """Return the maximum closing force of each jaw, N, or None if the file does not limit it."""
    model = motion.shapes.posing.model
    joints = motion.shapes.links.joints(motion.shapes.link_geoms)
    closed = float(motion.gaps[0] - motion.gaps[-1])
    ends = [_lengths(motion, posture) for posture in (0, len(motion.path) - 1)]
    travel = np.abs(ends[1] - ends[0])
    limits = [_motor_force(model, actuator) for actuator in range(model.nu)]
    used = [k for k in range(model.nu) if travel[k] > MIN_LEVER]
    if used:
        known = [limits[k] for k in used]
        work = sum(f * travel[k] for f, k in zip(known, used, strict=True) if f is not None)
        force = None if None in known else work / closed
    else:
        places = model.jnt_qposadr[joints]
        turned = np.abs(motion.path[-1, places] - motion.path[0, places])
        efforts = [
            float(np.abs(model.jnt_actfrcrange[j]).max()) if model.jnt_actfrclimited[j] else 0.0
            for j in joints
        ]
        force = float(np.dot(efforts, turned)) / closed
    return None if force is None or force < MIN_FORCE else float(force)


def _lengths(motion: JawMotion, posture: int) -> NDArray[np.float64]:
    """Return the lengths of all actuators in a posture, (nu,), m or rad."""
    mujoco = load_mujoco()
    motion.posed(posture)
    model, data = motion.shapes.posing.model, motion.shapes.posing.data
    mujoco.mj_comPos(model, data)
    mujoco.mj_tendon(model, data)
    mujoco.mj_transmission(model, data)
    return np.array(data.actuator_length)


def _motor_force(model: Any, actuator: int) -> float | None:
    """Return the greatest force or torque of an actuator, N or N m, or None without a limit."""
    if model.actuator_forcelimited[actuator]:
        return float(np.abs(model.actuator_forcerange[actuator]).max())
    motor = not np.any(model.actuator_biasprm[actuator])
    if motor and model.actuator_ctrllimited[actuator]:
        most = float(np.abs(model.actuator_ctrlrange[actuator]).max())
        return most * abs(float(model.actuator_gainprm[actuator, 0]))
    joint = int(model.actuator_trnid[actuator, 0])
    on_joint = int(model.actuator_trntype[actuator]) == int(load_mujoco().mjtTrn.mjTRN_JOINT)
    if on_joint and model.jnt_actfrclimited[joint]:
        return float(np.abs(model.jnt_actfrcrange[joint]).max())
    return None
