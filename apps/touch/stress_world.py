"""Simulation for stress sweeps: a pad on a carrier with lag, above movable objects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, exp
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import (
    CONTROL_RATE,
    IMAGE_RATE,
    PAD_SITE,
    SENSORS,
    PadOptions,
    PadSimulation,
    SensorModel,
    TactilePad,
    TactileReadout,
    TouchObject,
    run_bench,
)
from eyehand.tactile import Calibration, ContactFeatures, FeatureOptions, FeatureReader, calibrate
from eyehand.tactile.sensors import SensorFault, SensorInfo, SensorMonitor, TactileFrame

CYCLE = 1.0 / CONTROL_RATE
"""Duration of a control cycle, s."""
LAG = 0.015
"""Time constant of the carrier's velocity, s. It equals that of the arm's joints."""
TACTELS = 256
"""Number of tactels of the default pad."""
START_HEIGHT = 0.002
"""Initial height of the pad's centre above the top of the objects, m."""
TABLE_HALF = 0.02
"""Half the thickness of the table that free objects lie on, m."""


@dataclass(frozen=True)
class Electronics:
    """The properties of a pad's read-out."""

    seed: int
    """Random seed of the characteristics and faults."""
    sensor: SensorModel = SENSORS["good"]
    """Sensor model."""
    dead: tuple[int, ...] = ()
    """Tactels that read nothing, beside those of the model."""


class CarriedPad:
    """A pad that faces down and moves by twists in its own frame.

    The carrier follows with a lag and a delay of one cycle, as an arm does. Contact forces do not
    act on the carrier.

    Parameters
    ----------
    objects
        Movable objects under the pad, with their tops at the world's origin.
    electronics
        Read-out of the pad.
    place
        Initial position (3,) of the pad in the world, m. z points up.
    lean
        Rotation vector (3,) of the initial tilt from straight down, rad, in the pad frame.
    mass
        Mass of objects that lie free on a table, kg. Without it the objects are held in place.
    features
        Options of the contact features.
    play
        Free play between the carrier and the pad along the world's z, m.
    friction
        Coulomb's coefficient between foam and objects; that of `PadOptions` if not given.
    """

    def __init__(
        self,
        objects: Sequence[TouchObject],
        electronics: Electronics,
        *,
        place: Sequence[float] = (0.0, 0.0, START_HEIGHT),
        lean: Sequence[float] = (0.0, 0.0, 0.0),
        mass: float | None = None,
        features: FeatureOptions | None = None,
        play: float = 0.0,
        friction: float | None = None,
    ) -> None:
        self._place = np.array(place, float)
        self._play, self._height = play, float(self._place[2])
        self._rotation = Rotation.from_rotvec([np.pi, 0.0, 0.0]) * Rotation.from_rotvec(lean)
        readout, calibration = _calibrated(electronics)
        model, data, softness = compiled_world(objects, mass)
        self._data = data
        self._put()
        import_mujoco().mj_kinematics(model, data)
        pad = TactilePad(
            model,
            data,
            options=None if friction is None else PadOptions(friction=friction),
            softness=softness,
            readout=readout,
            sensor=electronics.sensor,
            seed=electronics.seed,
        )
        self._simulation = PadSimulation(
            model, data, (pad,), image_rate=CONTROL_RATE, seed=electronics.seed
        )
        self._reader = FeatureReader(calibration, pad.array, features)
        info = SensorInfo("stressed pad", pad.array, CONTROL_RATE)
        self._monitor = SensorMonitor(info, calibration)
        self.fault: SensorFault | None = None
        """Fault of the sensor in the last cycle."""
        self._velocity = np.zeros(6)
        self._waiting = np.zeros(6)
        self.force = 0.0
        """True normal force, N."""
        self.features: ContactFeatures
        """Contact features of the last image."""
        # Until the first image has arrived, the sensor repeats it.
        for _ in range(1 + ceil(electronics.sensor.wait / CYCLE)):
            self.step(np.zeros(6))
        self._monitor, self.fault = SensorMonitor(info, calibration), None

    @property
    def tilt(self) -> float:
        """Angle between the pad's outward normal and straight down, rad."""
        return float(np.arccos(np.clip(-self._rotation.as_matrix()[2, 2], -1.0, 1.0)))

    @property
    def heading(self) -> float:
        """Rotation of the pad about its normal, rad."""
        x, y = self._rotation.as_matrix()[:2, 0]
        return float(np.arctan2(y, x))

    def step(
        self, twist: NDArray[np.float64], lifts: Callable[[float], Sequence[float]] | None = None
    ) -> None:
        """Simulate one control cycle.

        Parameters
        ----------
        twist
            Commanded twist [v; ω] (6,) in the pad frame, m/s and rad/s.
        lifts
            Function from the time, s, to the upward displacement of each held object, m.
        """
        command, self._waiting = self._waiting, np.asarray(twist, float)
        self._velocity = self._velocity + (1.0 - exp(-CYCLE / LAG)) * (command - self._velocity)
        origin, attitude, begin = self._place, self._rotation, self._simulation.time

        def move(time: float) -> None:
            elapsed = time - begin
            self._place = origin + attitude.apply(self._velocity[:3]) * elapsed
            self._rotation = attitude * Rotation.from_rotvec(self._velocity[3:] * elapsed)
            self._put()
            if lifts:
                for number, lift in enumerate(lifts(time)):
                    self._data.mocap_pos[1 + number, 2] = lift

        reading = self._simulation.advance(duration=CYCLE, on_step=move)[-1][0]
        self.force = reading.force
        self.fault = self._monitor.check(TactileFrame(reading.time, reading.raw), CYCLE)
        self.features = self._reader.read(reading.raw)

    def _put(self) -> None:
        half, height = 0.5 * self._play, float(self._place[2])
        self._height = min(max(self._height, height - half), height + half)
        self._data.mocap_pos[0] = (*self._place[:2], self._height)
        self._data.mocap_quat[0] = self._rotation.as_quat(scalar_first=True)


@lru_cache(maxsize=64)
def _calibrated(electronics: Electronics) -> tuple[TactileReadout, Calibration]:
    readout = electronics.sensor.readout(TACTELS, electronics.seed)
    readout = replace(readout, dead=(*readout.dead, *electronics.dead))
    return readout, calibrate(run_bench(readout, seed=electronics.seed))


def compiled_world(
    objects: Sequence[TouchObject], mass: float | None = None
) -> tuple[Any, Any, dict]:
    """Return model, data and softness of a carrier and of objects, with mocap bodies in order.

    Objects with a mass lie free on a table.
    """
    mujoco = import_mujoco()
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / IMAGE_RATE
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.worldbody.add_body(name="carrier", mocap=True).add_site(name=PAD_SITE)
    softness = {}
    for touch_object in objects:
        body = spec.worldbody.add_body(name=touch_object.name, mocap=mass is None)
        if mass is not None:
            body.add_freejoint()
        softness |= touch_object.add_geoms(body, mass or 1.0, contact_bits=1)
    if mass is not None:
        height = max(-p.place[2] + p.size[2] for item in objects for p in item.parts)
        table = spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_BOX)
        table.size = [0.2, 0.2, TABLE_HALF]
        table.pos = [0.0, 0.0, -height - TABLE_HALF]
    model = spec.compile()
    return model, mujoco.MjData(model), softness
