"""Contacts in a simulated cell, by names such as "robot", "table" and those of objects."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .grasp_world import ROBOT_PREFIX, GraspWorld

_ROBOT = 0
_PEDESTAL = "pedestal"
_FIXED = ("table", "tray", _PEDESTAL)


class ContactRecord:
    """The contacts of the robot, recorded at every physics step.

    Parameters
    ----------
    model, data
        `MjModel`, `MjData` of the world.
    world
        The world.
    """

    def __init__(self, model: Any, data: Any, world: GraspWorld) -> None:
        self._data = data
        self._names = ("robot", *_FIXED, *world.object_names)
        numbers = {name: k for k, name in enumerate(self._names)}
        self._owner = np.array([numbers[_owner(model, g)] for g in range(model.ngeom)])
        self._touched = np.zeros(len(self._names), dtype=bool)

    @property
    def robot(self) -> NDArray[np.bool_]:
        """Mask of the geoms of the robot and its pedestal, (ngeom,)."""
        return (self._owner == _ROBOT) | (self._owner == self._names.index(_PEDESTAL))

    def record(self) -> None:
        """Record the robot's contacts in the current state."""
        if self._data.ncon:
            owners = self._owner[self._data.contact.geom]
            mine = (owners == _ROBOT).any(axis=1)
            self._touched[owners[mine].ravel()] = True

    def take_touched(self) -> set[str]:
        """Return the names of what the robot touched since the last call, and clear the record."""
        names = {self._names[k] for k in np.flatnonzero(self._touched) if k != _ROBOT}
        self._touched[:] = False
        return names

    def touching(self, name: str) -> set[str]:
        """Return the names of what an object touches now; "robot" may be one."""
        if not self._data.ncon:
            return set()
        number = self._names.index(name)
        owners = self._owner[self._data.contact.geom]
        involved = owners[(owners == number).any(axis=1)].ravel()
        return {self._names[k] for k in set(involved.tolist()) if k != number}


def _owner(model: Any, geom: int) -> str:
    body = int(model.geom_bodyid[geom])
    name = model.body(body).name
    if name.startswith(ROBOT_PREFIX):
        return "robot"
    if body == 0:
        return _PEDESTAL if model.geom(geom).name.startswith(_PEDESTAL) else "table"
    # Only the files of robots contain bodies without a name.
    return name or "robot"
