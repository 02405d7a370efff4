"""Size and material of the simulated pad."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from eyehand.errors import InputError

from .foam import Foam


@dataclass(frozen=True)
class PadOptions:
    """Size and material of the pad.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    rows: int = 16
    """Tactels along y."""
    columns: int = 16
    """Tactels along x."""
    pitch: float = 0.005
    """Distance between the centres of two tactels, m: smaller resolves finer shapes."""
    foam: Foam = field(default_factory=Foam)
    """The layer of foam that covers the tactels."""
    friction: float = 0.6
    """Coulomb's coefficient between foam and objects."""

    def __post_init__(self) -> None:
        if self.rows < 1 or self.columns < 1 or not 0 < self.pitch < np.inf:
            raise InputError(
                "rows, columns and pitch must be > 0, got "
                f"{self.rows}, {self.columns}, {self.pitch} m"
            )
        if not 0 <= self.friction < np.inf:
            raise InputError(f"friction must be >= 0, got {self.friction}")
