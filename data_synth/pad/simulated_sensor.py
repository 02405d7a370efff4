"""A simulated pad as a tactile sensor."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.tactile.sensors import SensorInfo, TactileFrame

if TYPE_CHECKING:
    from collections.abc import Callable

    from .pad_simulation import PadSimulation


class SimulatedSensor:
    """A pad of a simulation, read as a real sensor. It implements `TactileSensor`.

    Parameters
    ----------
    simulation
        The simulation. Each reading advances it by one image.
    pad
        Number of the pad.
    name
        Name of the sensor.
    shear
        Whether images contain the shear stress on each tactel.
    on_step
        Called with the time, s, at each step of the simulation, to move bodies.
    """

    def __init__(
        self,
        simulation: PadSimulation,
        pad: int = 0,
        *,
        name: str = "simulated pad",
        shear: bool = False,
        on_step: Callable[[float], None] | None = None,
    ) -> None:
        self._simulation, self._pad, self._on_step = simulation, pad, on_step
        array = simulation.pads[pad].array
        self._info = SensorInfo(name, array, simulation.image_rate, shear=shear)

    @property
    def info(self) -> SensorInfo:
        """Description of the sensor."""
        return self._info

    def read(self, timeout: float = 1.0) -> TactileFrame | None:
        """Advance the simulation to the next image and return it.

        It returns None if the image comes later than the timeout, s, which then passes.
        """
        period = 1.0 / self._info.rate
        samples = self._simulation.advance(duration=min(period, timeout), on_step=self._on_step)
        if not samples:
            return None
        sample = samples[-1][self._pad]
        shear = self._simulation.pads[self._pad].true_shear.copy() if self._info.shear else None
        return TactileFrame(sample.time, sample.raw, shear)

    def close(self) -> None:
        """Do nothing: there is no device."""
