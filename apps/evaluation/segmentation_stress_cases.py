"""All sweeps of `eyehand stress segmentation`, in the order in which they are told."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .stress_camera_cases import camera_sweeps
from .stress_input_cases import input_sweeps
from .stress_neighbour_cases import neighbour_sweeps
from .stress_shape_cases import shape_sweeps
from .stress_sweep import chosen_sweeps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .stress_sweep import Sweep
    from .stress_trial import Method


def segmentation_sweeps(only: Sequence[str] = ()) -> tuple[Sweep[Method], ...]:
    """Give all sweeps, or those named.

    Raises
    ------
    InputError
        If there is no sweep of a name.
    """
    return chosen_sweeps(
        (*camera_sweeps(), *neighbour_sweeps(), *shape_sweeps(), *input_sweeps()), only
    )
