"""Which of the six twist components touch controls: the projector P of eq. 13."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np


@dataclass(frozen=True)
class SelectionMatrix:
    """The diagonal of the projector P, by name; all along the sensor's axes."""

    slide_x: bool = False
    """Slide along x until the centre of pressure is where the goal has it."""
    slide_y: bool = False
    """Slide along y likewise."""
    press: bool = False
    """Move along z until pressure or force is the goal's."""
    roll_x: bool = False
    """Turn about x, through the centre of pressure, until the centre's y is the goal's."""
    roll_y: bool = False
    """Turn about y likewise until its x is."""
    turn: bool = False
    """Turn about z until the imprint's long axis has the goal's orientation."""

    def projector(self) -> np.ndarray:
        """Give P, (6, 6)."""
        return np.diag(np.array(astuple(self), dtype=float))


TRACK_POSITION = SelectionMatrix(slide_x=True, slide_y=True)
"""Keep the contact's place on the pad; pressure is not controlled (section 3.3)."""

TRACK = SelectionMatrix(slide_x=True, slide_y=True, press=True)
"""Track a contact point with a pressure (section 4.1)."""

ROLL = SelectionMatrix(slide_x=True, slide_y=True, press=True, roll_x=True, roll_y=True)
"""Track the contact, and roll until the pad lies flat on it (section 4.2)."""

EDGE = SelectionMatrix(press=True, turn=True)
"""Turn with an edge (section 4.3)."""

CABLE = SelectionMatrix(slide_x=True, slide_y=True, press=True, turn=True)
"""Follow a cable, with an outer motion along y (section 4.4)."""

EXPLORE = SelectionMatrix(True, True, True, True, True, True)
"""Run over an unknown surface, with an outer motion (section 4.5)."""

PRESS = SelectionMatrix(press=True)
"""Only keep the pressure; what moves the pad along the surface comes from outside."""

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
