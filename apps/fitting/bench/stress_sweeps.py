"""All sweeps of `eyehand stress fit`, in reading order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .cloud_sweeps import cloud_sweeps
from .solid_sweeps import solid_sweeps

if TYPE_CHECKING:
    from ...bench import Sweep
    from .stress_trial import FitCallable


def fit_sweeps() -> tuple[Sweep[FitCallable], ...]:
    """Return all sweeps of the fit."""
    return (*cloud_sweeps(), *solid_sweeps())
