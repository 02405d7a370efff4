"""All sweeps of `eyehand stress segmentation`, in the order in which they are told."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..bench.sweep import select_sweeps
from .camera_sweeps import camera_sweeps
from .input_sweeps import input_sweeps
from .neighbour_sweeps import neighbour_sweeps
from .shape_sweeps import shape_sweeps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..bench.sweep import Sweep
    from .stress_trial import SegmentCallable


def segmentation_sweeps(only: Sequence[str] = ()) -> tuple[Sweep[SegmentCallable], ...]:
    """Give all sweeps, or those named.

    Raises
    ------
    InputError
        If there is no sweep of a name.
    """
    return select_sweeps(
        (*camera_sweeps(), *neighbour_sweeps(), *shape_sweeps(), *input_sweeps()), only
    )
