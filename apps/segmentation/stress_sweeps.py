"""All sweeps of `eyehand stress segmentation`, in reading order."""

from __future__ import annotations

from .agreement_sweeps import AGREEMENT_SWEEPS
from .camera_sweeps import CAMERA_SWEEPS
from .furnished_sweeps import FURNISHED_SWEEPS
from .input_sweeps import INPUT_SWEEPS
from .neighbour_sweeps import NEIGHBOUR_SWEEPS
from .shape_sweeps import SHAPE_SWEEPS

SEGMENTATION_SWEEPS = (
    *CAMERA_SWEEPS,
    *NEIGHBOUR_SWEEPS,
    *SHAPE_SWEEPS,
    *FURNISHED_SWEEPS,
    *INPUT_SWEEPS,
    *AGREEMENT_SWEEPS,
)
"""All sweeps of the segmentation."""
