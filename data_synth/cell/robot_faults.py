"""Faults that stop the simulated robot: invalid commands, and failures of the simulation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.grasping.hands import AnyCommand

from ..mujoco_import import import_mujoco

WARNINGS = ("BADQPOS", "BADQVEL", "BADQACC", "BADCTRL")
"""MuJoCo's warnings of a state that is not finite or too large."""


def command_fault(velocity: NDArray[np.float64], command: AnyCommand | None) -> str:
    """Return why a command is invalid; empty for a valid one.

    Parameters
    ----------
    velocity
        Joint velocities of the arm, (n,), rad/s.
    command
        Command for the hand's drives, or None.
    """
    if not np.isfinite(velocity).all():
        return f"commanded joint velocities are not finite: {velocity.tolist()}"
    if command is not None and not np.isfinite(command.values).all():
        return f"commanded hand values are not finite: {command.values.tolist()}"
    return ""


def simulation_fault(data: Any) -> str:
    """Return why the state of a simulation (`mujoco.MjData`) is invalid; empty for a valid one."""
    counts = data.warning.number
    kinds = import_mujoco().mjtWarning
    for name in WARNINGS:
        if counts[int(getattr(kinds, f"mjWARN_{name}"))]:
            return f"the simulation failed: {name} at {data.time:.3f} s"
    if not np.isfinite(data.qpos).all():
        return f"the simulation failed: a position is not finite at {data.time:.3f} s"
    return ""
