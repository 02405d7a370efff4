"""How the pads of jaws turn while they close."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .jaw_motion import JawMotion

MAX_WEDGE = np.deg2rad(45.0)
"""Maximum angle between pads that turn. Objects slip out of a wider one: each pad holds up to the
angle of friction, 22° at a coefficient of 0.4."""


def pad_turn(motion: JawMotion) -> float:
    """Return by how much the pads turn while they close, rad."""
    first, last = _pad_frames(motion, (0, len(motion.path) - 1))
    return _angle(first, last)


def wedge_start(motion: JawMotion, closed: int) -> int:
    """Return the first posture in which turning pads enclose an angle that can hold something.

    The pads are parallel in the posture ``closed``.
    """
    frames = _pad_frames(motion, range(len(motion.path)))
    start = closed
    while start > 0 and _angle(frames[start - 1], frames[closed]) <= MAX_WEDGE:
        start -= 1
    return start


def _pad_frames(motion: JawMotion, postures: Sequence[int]) -> list[list[NDArray[np.float64]]]:
    """Return the orientation (3, 3) of the first pad of each side in postures."""
    data, frames = motion.shapes.posing.data, []
    for posture in postures:
        motion.posed(posture)
        frames.append([data.xmat[side[0]].reshape(3, 3).copy() for side in motion.pads])
    return frames


def _angle(one: list[NDArray[np.float64]], other: list[NDArray[np.float64]]) -> float:
    """Return the sum of the angles by which links have turned, rad."""
    cosines = [0.5 * (np.trace(a.T @ b) - 1.0) for a, b in zip(one, other, strict=True)]
    return float(np.arccos(np.clip(cosines, -1.0, 1.0)).sum())
