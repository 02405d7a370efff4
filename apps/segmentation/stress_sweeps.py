"""All sweeps of `eyehand stress segmentation`, in reading order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .camera_sweeps import camera_sweeps
from .input_sweeps import input_sweeps
from .neighbour_sweeps import neighbour_sweeps
from .shape_sweeps import shape_sweeps

if TYPE_CHECKING:
    from ..bench import Sweep
    from .stress_trial import SegmentCallable


def segmentation_sweeps() -> tuple[Sweep[SegmentCallable], ...]:
    """Return all sweeps of the segmentation."""
    return (*camera_sweeps(), *neighbour_sweeps(), *shape_sweeps(), *input_sweeps())
