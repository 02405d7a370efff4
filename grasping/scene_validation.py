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
LEAST_HEIGHT, MOST_HEIGHT = 0.01, 0.5
"""Readings so high over the table, m, are of something on it: lower may be noise, higher is a lamp
or a person."""
NOISE_SIGMAS = 6.0
"""Spreads of the table's own readings about it that are noise."""
CELL = 0.03
"""Side of the squares in plan by which such readings are summed, m: about a small object."""
LEAST_SEEN = 1e-4
"""Area seen in one of them from which something stands there, m²: flying pixels over an empty table
add up to 0.2 cm², a ball of 15 mm shows 1.8 cm²."""
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
    seen = unexplained(frame, scene) if not scene.objects else 0.0
    if seen > LEAST_SEEN:
        return (
            f"cannot tell a clear table: readings of {1e4 * seen:.0f} cm² above it belong to no "
            "object that was made out"
        )
    return ""


def unexplained(frame: DepthFrame, scene: Scene) -> float:
    """Sum what was seen over the table and belongs to no object.

    Parameters
    ----------
    frame
        Depth image, its pose known.
    scene
        What was made of it, in the world's frame; one not made of this image leaves nothing
        unexplained.

    Returns
    -------
    float
        Largest area, across the line of sight, within a square of `CELL` in plan, m².
    """
    labels, support, place = scene.segmentation.labels, scene.support, frame.T_world_camera
    if support is None or place is None or labels.shape != frame.depth.shape:
        return 0.0
    free = frame.valid & (labels == 0)
    points = place.apply(frame.points()[free])
    height = support.height(points)
    low = max(LEAST_HEIGHT, NOISE_SIGMAS * support.tolerance)
    table = points[np.abs(height) < low, :2]
    if not len(table):
        return 0.0
    first, last = table.min(axis=0), table.max(axis=0)
    over = (height >= low) & (height < MOST_HEIGHT)
    over &= ((points[:, :2] >= first) & (points[:, :2] <= last)).all(axis=1)
    # Squares overlap by half, so that no edge cuts a small thing in two.
    half = 0.5 * CELL
    cells = ((points[over, :2] - first) / half).astype(np.intp)
    lens = frame.intrinsics
    areas = frame.depth[free][over].astype(np.float64) ** 2 / (lens.fx * lens.fy)
    sums = np.zeros(((last - first) / half).astype(np.intp) + 2)
    np.add.at(sums, tuple(cells.T), areas)
    rows = sums[1:] + sums[:-1]
    return float((rows[:, 1:] + rows[:, :-1]).max())
