"""What the drives of all simulated hands share: checks of commands, and contact forces."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.grasping import HandCommand
from eyehand.grasping.hands import AnyCommand


def checked_values(command: HandCommand, drives: tuple[str, ...]) -> NDArray[np.float64]:
    """Return a copy of a command's values, (D,).

    Raises
    ------
    InputError
        If there is not one finite value and one valid mode for each drive.
    """
    values = np.array(command.values, dtype=np.float64)
    if len(command.modes) != len(drives) or values.shape != (len(drives),):
        raise InputError(
            f"a command needs a mode and a value for each of {', '.join(drives)}, got "
            f"{len(command.modes)} modes and {values.shape} values"
        )
    if not np.isfinite(values).all():
        raise InputError(f"command values must be finite, got {values.tolist()}")
    for mode in command.modes:
        if mode not in ("position", "pull", "hold"):
            raise InputError(f"drive mode must be position, pull or hold, got {mode!r}")
    return values


def finger_command(command: AnyCommand) -> HandCommand:
    """Return the command of a hand with fingers; raise an `InputError` for one of jaws."""
    if not isinstance(command, HandCommand):
        raise InputError(f"a hand with fingers needs a HandCommand, got {command}")
    return command


def pad_forces(data: Any, pad_of_geom: NDArray[np.intp], pads: int) -> NDArray[np.float64]:
    """Return the sum of the normal contact forces on each pad, (pads,), N.

    Parameters
    ----------
    data
        `MjData` after a physics step.
    pad_of_geom
        Number of the pad to which each geom belongs, (ngeom,); -1 for none.
    pads
        Number of pads.
    """
    forces = np.zeros(pads + 1)
    if data.nefc:
        rows = data.contact.efc_address
        # In an elliptic cone the first row of a contact is its normal force.
        normal = np.where(rows >= 0, data.efc_force[np.maximum(rows, 0)], 0.0)
        for side in range(2):
            np.add.at(forces, pad_of_geom[data.contact.geom[:, side]], normal)
    return forces[:-1]
