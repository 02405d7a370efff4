"""Selection of the twist components that touch controls: the projector P of eq. (13)."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SelectionMatrix:
    """The diagonal of the projector P of eq. (13), along and about the sensor's axes."""

    slide_x: bool = False
    """Slide along x until the centre of pressure has the goal's x."""
    slide_y: bool = False
    """Slide along y until the centre of pressure has the goal's y."""
    press: bool = False
    """Move along z until pressure or force has the goal's value."""
    roll_x: bool = False
    """Rotate about x, through the centre of pressure, until that centre has the goal's y."""
    roll_y: bool = False
    """Rotate about y, through the centre of pressure, until that centre has the goal's x."""
    turn: bool = False
    """Rotate about z until the imprint's long axis has the goal's orientation."""

    def projector(self) -> NDArray[np.float64]:
        """Return P as a matrix, (6, 6)."""
        return np.diag(np.array(astuple(self), dtype=float))


TRACK_POSITION = SelectionMatrix(slide_x=True, slide_y=True)
"""Track the contact position; the pressure is not controlled (section 3.3)."""

TRACK = SelectionMatrix(slide_x=True, slide_y=True, press=True)
"""Track a contact point at a given pressure (section 4.1)."""

ROLL = SelectionMatrix(slide_x=True, slide_y=True, press=True, roll_x=True, roll_y=True)
"""Track the contact and roll until the pad lies flat on the object (section 4.2)."""

EDGE = SelectionMatrix(press=True, turn=True)
"""Align with an edge (section 4.3)."""

CABLE = SelectionMatrix(slide_x=True, slide_y=True, press=True, turn=True)
"""Follow a cable, with an external twist along y (section 4.4)."""

EXPLORE = SelectionMatrix(True, True, True, True, True, True)
"""Move over an unknown surface, with an external twist (section 4.5)."""

PRESS = SelectionMatrix(press=True)
"""Control the pressure alone; the external twist moves the pad along the surface."""

PRESETS = {
    "track_position": TRACK_POSITION,
    "track": TRACK,
    "roll": ROLL,
    "edge": EDGE,
    "cable": CABLE,
    "explore": EXPLORE,
    "press": PRESS,
}
"""The presets by name."""
