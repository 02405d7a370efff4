"""A synthetic pad: saturating tactels, noise, integer counts, and a calibration run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.tactile import BenchRun

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class SyntheticPad:
    """Tactels that read offset + span * p / (p + half), with different constants per tactel."""

    offset: NDArray[np.float64]
    span: NDArray[np.float64]
    half: NDArray[np.float64]
    noise: float = 2.0

    @classmethod
    def draw(cls, count: int = 256, seed: int = 0, noise: float = 2.0) -> SyntheticPad:
        """Draw the constants of the tactels from a seed."""
        rng = np.random.default_rng(seed)
        return cls(
            rng.uniform(80.0, 160.0, count),
            rng.uniform(3000.0, 3600.0, count),
            rng.uniform(2000.0, 4500.0, count),
            noise,
        )

    def raw(self, pressures, rng: np.random.Generator | None = None) -> NDArray[np.uint16]:
        """Return the counts (N,) for pressures (N,), Pa."""
        counts = self.offset + self.span * pressures / (pressures + self.half)
        if rng is not None:
            counts = counts + rng.normal(0.0, self.noise, len(counts))
        return np.clip(np.rint(counts), 0, 4095).astype(np.uint16)

    def bench(self, seed: int = 0) -> BenchRun:
        """Record 50 readings at rest and 4 at each of 100 loads up to 10 kPa."""
        rng = np.random.default_rng(seed)
        loads = np.concatenate([np.zeros(50), np.repeat(np.geomspace(5.0, 1e4, 100), 4)])
        return BenchRun(
            loads, np.array([self.raw(np.full(len(self.offset), p), rng) for p in loads])
        )
