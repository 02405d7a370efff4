"""Whether a look tells enough to act on: a table, level, where it should be, and readings of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from eyehand.perception import DepthFrame, Scene

    from .tray import Tray

LEAST_READINGS = 0.4
"""Share of the image that must have a reading, 0.8 to 0.9 being usual: with less, objects fall into
pieces too small to be told from noise, and the table looks empty."""
MOST_TILT = np.radians(3.0)
"""Between the table seen and the level, rad: a table stands level and is seen to 0.5°, so that more
means that the camera is not where it is told to be, by centimetres over the table."""
MOST_STEP = 0.3
"""Between the table seen and the tray's floor, m: more is another surface, such as the floor."""
UP = np.array([0.0, 0.0, 1.0])


def doubts(frame: DepthFrame, scene: Scene, tray: Tray) -> str:
    """Tell why a look is nothing to act on; empty when it is.

    An empty scene means a clear table only where the table itself was seen.

    Parameters
    ----------
    frame
        Depth image, its pose known.
    scene
        What was made of it, in the world's frame.
    tray
        Where things are put.
    """
    share = float(frame.valid.mean())
    if share < LEAST_READINGS:
        return f"cannot see: {share:.0%} of the image has a reading, need {LEAST_READINGS:.0%}"
    support = scene.support
    if support is None:
        return "cannot see a table: no level surface in view"
    tilt = float(np.arccos(np.clip(support.normal @ UP, -1.0, 1.0)))
    if tilt > MOST_TILT:
        return (
            f"the table seen tilts by {np.degrees(tilt):.1f}°, more than "
            f"{np.degrees(MOST_TILT):.0f}°: is the camera where it is told to be?"
        )
    off = float(support.normal @ tray.centre + support.offset)
    if abs(off) > MOST_STEP:
        where = "below" if off > 0 else "above"
        return f"cannot see the table: the surface seen lies {abs(off):.2f} m {where} the tray"
    return ""
