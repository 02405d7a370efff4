"""Several depth images of a robot that stands still, as one with fewer holes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame


def steady(frames: Sequence[DepthFrame]) -> DepthFrame:
    """Fuse depth images: each pixel has the median of the readings it got.

    A pixel is a hole only where no image has a reading. Of an even number the nearer of the two
    middle ones counts: their mean would lie between an object and what is behind it.

    Parameters
    ----------
    frames
        One at least, oldest first, all through one lens. Only those from where the newest was
        taken count.

    Returns
    -------
    DepthFrame
        The newest with that depth.
    """
    newest = frames[-1]
    stack = np.stack([frame.depth for frame in frames if _from_the_same_place(frame, newest)])
    if len(stack) == 1:
        return newest
    valid = stack > 0.0
    ranked = np.sort(np.where(valid, stack, np.inf), axis=0)
    middle = np.maximum(valid.sum(axis=0) - 1, 0) // 2
    depth = np.take_along_axis(ranked, middle[None], axis=0)[0]
    return replace(newest, depth=_without_holes_at_infinity(depth).astype(newest.depth.dtype))


def _from_the_same_place(frame: DepthFrame, newest: DepthFrame) -> bool:
    ours, theirs = frame.T_world_camera, newest.T_world_camera
    if ours is None or theirs is None:
        return ours is theirs
    return bool(np.array_equal(ours.as_matrix(), theirs.as_matrix()))


def _without_holes_at_infinity(depth: NDArray[np.floating]) -> NDArray[np.floating]:
    return np.where(np.isfinite(depth), depth, 0.0)
