"""All sweeps of `eyehand stress fit`, in the order in which they are told."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .stress_cloud_cases import cloud_sweeps
from .stress_solid_cases import solid_sweeps

if TYPE_CHECKING:
    from .stress_fit_trial import Method
    from .stress_sweep import Sweep


def fit_sweeps() -> tuple[Sweep[Method], ...]:
    """All sweeps of the fit."""
    return (*cloud_sweeps(), *solid_sweeps())
