"""All sweeps of `eyehand stress segmentation`, in the order in which they are told."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.errors import InputError

from .stress_camera_cases import camera_sweeps
from .stress_input_cases import input_sweeps
from .stress_neighbour_cases import neighbour_sweeps
from .stress_shape_cases import shape_sweeps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .stress_sweep import Sweep


def segmentation_sweeps(only: Sequence[str] = ()) -> tuple[Sweep, ...]:
    """Give all sweeps, or those named.

    Raises
    ------
    InputError
        If there is no sweep of a name.
    """
    sweeps = (*camera_sweeps(), *neighbour_sweeps(), *shape_sweeps(), *input_sweeps())
    names = [sweep.name for sweep in sweeps]
    for name in only:
        if name not in names:
            raise InputError(f"no sweep is called {name!r}, expected of {', '.join(names)}")
    return tuple(sweep for sweep in sweeps if not only or sweep.name in only)
