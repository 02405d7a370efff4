"""The area in which the pads of two jaws oppose each other, and what lies between them."""

from __future__ import annotations

import numpy as np

from eyehand.errors import InputError

from .jaw_motion import JawMotion
from .shapes import clipped_box

SIDE_MARGIN = 0.1
"""Share of the opening beside each pad that does not count as between the jaws."""
MIN_PAD = 5e-4
"""Least width and height of pads, m."""


def opposed_pads(motion: JawMotion) -> tuple[float, float, float]:
    """Return least y, greatest y and height of the area in which both pads oppose each other, m.

    Raises
    ------
    InputError
        If there is none.
    """
    extents = [motion.pad_extent(side, len(motion.path) - 1) for side in (0, 1)]
    low, high = max(e[0] for e in extents), min(e[1] for e in extents)
    height = float(motion.tips[-1]) - max(e[2] for e in extents)
    if high - low < MIN_PAD or height < MIN_PAD:
        beside = f" and lie {1e3 * (low - high):.0f} mm beside each other" if high < low else ""
        raise InputError(
            "no gripper is found: the pads of the jaws do not oppose each other"
            f"{beside}; --pinch BODY BODY uses two fingers of a hand"
        )
    return low, high, height


def between_jaws(motion: JawMotion, posture: int, low_y: float, high_y: float) -> float:
    """Return the greatest z of what lies between the pads behind them, m; -inf if nothing does.

    Parameters
    ----------
    motion
        The jaws.
    posture
        Number of the posture.
    low_y, high_y
        Least and greatest y of the pads, m.
    """
    motion.posed(posture)
    margin = SIDE_MARGIN * motion.gaps[posture]
    low = np.array([motion.faces[posture, 1] + margin, low_y, -np.inf])
    high = np.array([motion.faces[posture, 0] - margin, high_y, np.inf])
    links = [link for side in motion.jaws.sides for link in side]
    parts = [motion.fixed(), motion.of_links(links)]
    points = clipped_box(np.concatenate(parts), low, high).reshape(-1, 3)
    return float(points[:, 2].max()) if len(points) else -np.inf
