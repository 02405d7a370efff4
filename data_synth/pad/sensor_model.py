"""Named models of tactile sensors: how far the pad and its electronics are from perfect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from eyehand.errors import InputError

from .tactile_readout import TactileReadout


@dataclass(frozen=True)
class SensorModel:
    """The imperfections of a pad, its electronics and the arm that carries it.

    The defaults are a good sensor: it is noisy, but has no memory, and its friction never reaches
    the image.

    Raises
    ------
    InputError
        If a value is negative or not finite, or a share is greater than 1.
    """

    noise: float = 2.0
    """Standard deviation of a reading from one image to the next, counts."""
    common_noise: float = 0.0
    """Standard deviation of the noise that all readings of an image share, counts."""
    hysteresis: float = 0.0
    """Share of the previous load that is still read after a quick unloading, 0..1."""
    creep: float = 0.0
    """Share by which a reading rises in time under a constant load."""
    gain_spread: float = 0.0
    """Standard deviation of the log of each tactel's gain since its calibration."""
    drift: float = 0.0
    """Mean change of the readings at rest by temperature, counts per minute."""
    lag: float = 0.0
    """Time constant with which readings follow the pressure, s."""
    wait: float = 0.0
    """Time from a reading to its arrival, s."""
    backlash: float = 0.0
    """Free play of each of the arm's joints, rad."""
    shear: float = 0.0
    """Share of the foam's thickness over which friction turns the layer, 0..1. A real layer has 1:
    friction holds at rest and moves the image. With 0 it is viscous at low speed, and the image
    shows the normal forces alone."""
    dead: float = 0.0
    """Share of tactels that read nothing."""
    saturated: float = 0.0
    """Share of tactels that read full scale."""

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not 0 <= value < np.inf:
                raise InputError(f"{item.name} must be finite and >= 0, got {value}")
        if max(self.hysteresis, self.shear, self.dead + self.saturated) > 1:
            raise InputError(
                "hysteresis, shear and the share of faulty tactels must be <= 1, got "
                f"{self.hysteresis}, {self.shear} and {self.dead} + {self.saturated}"
            )

    def readout(self, tactels: int = 256, seed: int = 0) -> TactileReadout:
        """Draw the characteristics and the faulty tactels of one pad of this model.

        Parameters
        ----------
        tactels
            Number of tactels, >= 1.
        seed
            Source of the characteristics and faults, >= 0.

        Raises
        ------
        InputError
            If the number or the seed is out of range.
        """
        order = np.random.default_rng(seed).permutation(tactels).tolist()
        dead, saturated = round(self.dead * tactels), round(self.saturated * tactels)
        return TactileReadout.draw(
            tactels,
            seed=seed,
            noise=self.noise,
            common_noise=self.common_noise,
            dead=tuple(order[:dead]),
            saturated=tuple(order[dead:][:saturated]),
        )


SENSORS: Mapping[str, SensorModel] = {
    "ideal": SensorModel(noise=0.0),
    "good": SensorModel(),
    "real": SensorModel(
        noise=4.0,
        common_noise=1.0,
        hysteresis=0.10,
        creep=0.05,
        gain_spread=0.10,
        drift=3.0,
        wait=0.008,
        backlash=float(np.radians(0.01)),
        shear=1.0,
    ),
    "harsh": SensorModel(
        noise=8.0,
        common_noise=2.0,
        hysteresis=0.10,
        creep=0.15,
        gain_spread=0.20,
        drift=6.0,
        lag=0.025,
        wait=0.016,
        backlash=float(np.radians(0.03)),
        shear=1.0,
    ),
}
"""Sensor models by name, from the kindest to the harshest."""
