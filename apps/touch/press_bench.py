"""Press a simulated pad with a flat punch and a needle, and fit its decoder."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import (
    CONTROL_RATE,
    PAD_SITE,
    SENSORS,
    PadSimulation,
    Part,
    TactilePad,
    TouchObject,
    probe,
    run_bench,
)
from eyehand.tactile import (
    FeatureReader,
    FoamMemory,
    PressDecoder,
    calibrate,
    fit_creep,
    fit_decoder,
    fit_memory,
)

from .arm_rig import SensorName
from .commissioning import SEED

PLATE_DEPTHS = np.geomspace(5e-5, 2.0e-3, 16)
"""Depths of the punch, m: up to 80 % of the range of pressures of the calibration."""
NEEDLE_DEPTH = 2.8e-3
"""Depth of the needle, m."""
NEEDLE_PRESSES, MARGIN = 100, 0.02
"""Number of needle presses at random places, and their minimum distance from the border, m."""
NEEDLE_RADIUS = 0.001
"""Radius of the needle, m."""
REST_SECONDS, PRESS_SECONDS = {"plate": 12.0, "probe": 4.0}, 0.2
"""Time without contact before a press with each tool, s, in which the foam recovers, and time of a
press. The punch loads the whole pad, so the foam needs longer."""
MEAN_IMAGES = 25
"""Number of images at the end of each press whose mean is used."""
_FACING_DOWN = (0.0, 1.0, 0.0, 0.0)
_AWAY = np.array([0.0, 0.0, 0.05])


RELEASE_SECONDS, RELEASE_START = 4.0, 25
"""Time of the images after the release of the punch, s, and the first one that is used."""
HOLD_SECONDS, HOLD_DEPTH = 8.0, 1e-3
"""Time, s, and depth, m, for which the punch is held still. Foams creep with time constants of
seconds, and no tactel may reach full scale meanwhile."""


@lru_cache
def pressed_decoder(sensor: SensorName, seed: int, pad: int) -> tuple[PressDecoder, FoamMemory]:
    """Press a pad of an :class:`ArmRig` on a bench, and fit its decoder and its memory.

    The bench sets the depth and place of the tools exactly.

    Parameters
    ----------
    sensor
        Sensor model.
    seed
        Seed of the rig, >= 0.
    pad
        Number of the pad in the rig.
    """
    bench = _PressBench(sensor, seed, pad)
    rng = np.random.default_rng((seed, pad, 3))
    half = 0.5 * np.ptp(bench.pad.array.positions[:, :2], axis=0) + 0.5 * bench.pad.options.pitch
    places = rng.uniform(-1.0, 1.0, (NEEDLE_PRESSES, 2)) * (half - MARGIN)
    needles = [bench.press("probe", place, NEEDLE_DEPTH) for place in places]
    plates = [bench.press("plate", (0.0, 0.0), depth) for depth in PLATE_DEPTHS]
    decoder = fit_decoder(
        bench.pad.array, np.array(plates), PLATE_DEPTHS, np.array(needles), places, NEEDLE_RADIUS
    )
    return decoder, bench.memory()


@lru_cache
def pressed_memory(sensor: SensorName) -> FoamMemory:
    """Press a plate with one pad of a sensor model, and fit the memory of its foam."""
    return _PressBench(sensor, SEED, 0).memory()


class _PressBench:
    """A fixed pad, and two tools above it that are placed from outside."""

    def __init__(self, sensor: SensorName, seed: int, pad: int) -> None:
        mujoco = import_mujoco()
        spec = mujoco.MjSpec()
        spec.worldbody.add_site(name=PAD_SITE)
        plate = TouchObject("plate", (Part("box", (0.06, 0.06, 0.01), (0.0, 0.0, -0.01)),))
        for tool in (plate, probe()):
            body = spec.worldbody.add_body(name=tool.name, mocap=True)
            body.pos, body.quat = _AWAY, _FACING_DOWN
            tool.add_geoms(body, 0.1, 1)
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        readout = SENSORS[sensor].readout(seed=seed + pad)
        self.pad = TactilePad(model, data, readout=readout, sensor=SENSORS[sensor], seed=seed + pad)
        self._simulation = PadSimulation(
            model, data, [self.pad], image_rate=CONTROL_RATE, seed=seed
        )
        self._calibration = calibrate(run_bench(readout, seed=seed))
        self._reader = FeatureReader(self._calibration, self.pad.array)
        self._drift = np.zeros(len(self._calibration.rest))

    def memory(self) -> FoamMemory:
        """Fit the memory from the release of the punch, and from a press that is held."""
        loaded = self.press("plate", (0.0, 0.0), PLATE_DEPTHS[-1])
        released = self.images(RELEASE_SECONDS)
        times = np.arange(1, len(released) + 1) / CONTROL_RATE
        memory = fit_memory(loaded, released[RELEASE_START:], times[RELEASE_START:])
        held = self.hold("plate", (0.0, 0.0), HOLD_DEPTH, HOLD_SECONDS)[RELEASE_START:]
        times = np.arange(1, len(held) + 1) / CONTROL_RATE
        return fit_creep(memory, held, times)

    def press(
        self, tool: str, place: tuple[float, float] | NDArray[np.float64], depth: float
    ) -> NDArray[np.float64]:
        """Return the mean pressures (N,), Pa, at the end of a short press (see :meth:`hold`)."""
        return self.hold(tool, place, depth, PRESS_SECONDS)[-MEAN_IMAGES:].mean(axis=0)

    def hold(
        self,
        tool: str,
        place: tuple[float, float] | NDArray[np.float64],
        depth: float,
        seconds: float,
    ) -> NDArray[np.float64]:
        """Zero the pad, press a tool to a depth, m, at a place, m, and hold it.

        Returns the pressures (M, N), Pa, of the images of these seconds.
        """
        model, data = self._simulation.model, self._simulation.data
        body = int(model.body(tool).mocapid[0])
        samples = self._simulation.advance(duration=REST_SECONDS[tool])[-MEAN_IMAGES:]
        at_rest = np.mean([sample.raw for (sample,) in samples], axis=0)
        self._drift = at_rest - self._calibration.rest
        data.mocap_pos[body] = [*place, -depth]
        pressures = self.images(seconds)
        data.mocap_pos[body] = _AWAY
        return pressures

    def images(self, seconds: float) -> NDArray[np.float64]:
        """Return the pressures (M, N), Pa, of the images of the next seconds."""
        images = []
        for (sample,) in self._simulation.advance(duration=seconds):
            raw = np.clip(np.rint(sample.raw - self._drift), 0, None).astype(np.uint16)
            self._reader.read(raw)
            images.append(self._reader.image.pressures)
        return np.array(images)
