"""Copies of a frame on which a method that treats all pixels alike gives the same segments.

The disturbance of single readings leaves every sample of a method at its pixel. A mirrored frame,
or one without its first column, moves all samples: a result that depends on them changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from eyehand.perception import CameraIntrinsics, DepthFrame

MIRRORED = ((False, True), (True, False), (True, True))
"""Whether the rows and whether the columns of each mirrored copy are reversed."""
CROPPED = ((0, 1), (1, 0), (1, 2))
"""Rows and columns that are cut off at the upper and left border of each cropped copy."""


class MovedCopy(NamedTuple):
    """A mirrored or cropped copy of a frame."""

    frame: DepthFrame
    """The copy, without the pose of the camera: no pose mirrors an image."""
    reversed_axes: tuple[bool, bool]
    """Whether its rows and its columns are reversed."""
    cut: tuple[int, int]
    """Number of rows and columns that it lacks at the upper and left border."""

    def restore(self, labels: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return labels of the copy (H, W) at the pixels of the original; 0 where it lacks them."""
        restored = labels[_steps(self.reversed_axes)]
        return np.pad(restored, [(rows, 0) for rows in self.cut])


def moved_copies(frame: DepthFrame) -> Iterator[MovedCopy]:
    """Yield the mirrored and the cropped copies of a frame, 6 in all."""
    camera = frame.intrinsics
    for reversed_axes in MIRRORED:
        rows, columns = reversed_axes
        mirrored = replace(
            camera,
            cx=camera.width - 1 - camera.cx if columns else camera.cx,
            cy=camera.height - 1 - camera.cy if rows else camera.cy,
        )
        part = _steps(reversed_axes)
        yield MovedCopy(_selected(frame, part, mirrored), reversed_axes, (0, 0))
    for top, left in CROPPED:
        part = slice(top, None), slice(left, None)
        copy = _selected(frame, part, camera.cropped(*part))
        yield MovedCopy(copy, (False, False), (top, left))


def _steps(reversed_axes: tuple[bool, bool]) -> tuple[slice, slice]:
    rows, columns = (slice(None, None, -1 if turned else None) for turned in reversed_axes)
    return rows, columns


def _selected(frame: DepthFrame, part: tuple[slice, slice], camera: CameraIntrinsics) -> DepthFrame:
    colour = None if frame.colour is None else np.ascontiguousarray(frame.colour[part])
    depth = np.ascontiguousarray(frame.depth[part])
    return DepthFrame(depth, camera, colour=colour)
