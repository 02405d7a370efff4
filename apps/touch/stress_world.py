"""A pad on a carrier that follows late, over objects that can be moved away: touch under stress."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import exp
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import (
    CONTROL_RATE,
    IMAGE_RATE,
    PAD_SITE,
    PadSimulation,
    TactilePad,
    TactileReadout,
    run_bench,
)
from eyehand.tactile import FeatureReader, calibrate

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Any

    from numpy.typing import NDArray

    from eyehand.data_synth.pad import TouchObject
    from eyehand.tactile import Calibration, ContactFeatures, FeatureOptions

CYCLE = 1.0 / CONTROL_RATE
"""Of control, s."""
LAG = 0.015
"""Time constant with which the carrier follows a velocity, s, as the arm's joints."""
TACTELS = 256
"""Of the usual pad."""
START_HEIGHT = 0.002
"""Of the pad's middle over the objects' tops at the start, m."""
TABLE_HALF = 0.02
"""Half the thickness of the table that free objects lie on, m."""


@dataclass(frozen=True)
class Electronics:
    """What a pad's read-out is like."""

    seed: int
    """Of its characteristics and faults."""
    noise: float = 2.0
    """Standard deviation of a reading, counts."""
    dead: float = 0.0
    """Share of tactels that read nothing."""
    saturated: float = 0.0
    """Share of tactels that read full scale."""


class CarriedPad:
    """A pad that is moved by twists in its own frame, looking down.

    The carrier follows with a lag and one cycle late, as an arm does; nothing stops it.

    Parameters
    ----------
    objects
        What lies under it, tops at the world's origin; each can be moved.
    electronics
        Of the pad.
    place
        Where the pad starts, (3,), m, in the world; z is up.
    lean
        Rotation vector of its first attitude from looking straight down, (3,), rad, in its frame.
    mass
        kg, of objects that lie free on a table; they are held in place when not given.
    features
        How contacts are found.
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
    ) -> None:
        self._place = np.array(place, float)
        self._rotation = Rotation.from_rotvec([np.pi, 0.0, 0.0]) * Rotation.from_rotvec(lean)
        readout, calibration = _calibrated(electronics)
        model, data, softness = _compiled(objects, mass)
        self._data = data
        self._put()
        import_mujoco().mj_kinematics(model, data)
        pad = TactilePad(model, data, softness=softness, readout=readout)
        self._simulation = PadSimulation(
            model, data, (pad,), image_rate=CONTROL_RATE, seed=electronics.seed
        )
        self._reader = FeatureReader(calibration, pad.array, features)
        self.trusted = calibration.working / TACTELS
        """Share of tactels that the calibration found to work."""
        self._velocity = np.zeros(6)
        self._waiting = np.zeros(6)
        self.force = 0.0
        """True normal force, N."""
        self.features: ContactFeatures
        """What the last image says."""
        self.step(np.zeros(6))

    @property
    def tilt(self) -> float:
        """Angle between where the pad looks and straight down, rad."""
        return float(np.arccos(np.clip(-self._rotation.as_matrix()[2, 2], -1.0, 1.0)))

    @property
    def heading(self) -> float:
        """Angle that the pad has turned by about its normal, rad."""
        x, y = self._rotation.as_matrix()[:2, 0]
        return float(np.arctan2(y, x))

    def step(
        self, twist: NDArray[np.float64], lifts: Callable[[float], Sequence[float]] | None = None
    ) -> None:
        """Go through one cycle.

        Parameters
        ----------
        twist
            Wished twist [v; ω] in the pad's frame, (6,), m/s and rad/s.
        lifts
            Of the time, s: by how much each held object is moved up, m.
        """
        wish, self._waiting = self._waiting, np.asarray(twist, float)
        self._velocity = self._velocity + (1.0 - exp(-CYCLE / LAG)) * (wish - self._velocity)
        origin, attitude, begin = self._place, self._rotation, self._simulation.time

        def move(time: float) -> None:
            passed = time - begin
            self._place = origin + attitude.apply(self._velocity[:3]) * passed
            self._rotation = attitude * Rotation.from_rotvec(self._velocity[3:] * passed)
            self._put()
            if lifts:
                for number, lift in enumerate(lifts(time)):
                    self._data.mocap_pos[1 + number, 2] = lift

        moment = self._simulation.advance(duration=CYCLE, on_step=move)[-1][0]
        self.force = moment.force
        self.features = self._reader.read(moment.raw)

    def _put(self) -> None:
        self._data.mocap_pos[0] = self._place
        self._data.mocap_quat[0] = self._rotation.as_quat(scalar_first=True)


@lru_cache(maxsize=64)
def _calibrated(electronics: Electronics) -> tuple[TactileReadout, Calibration]:
    e = electronics
    drawn = np.random.default_rng(e.seed).permutation(TACTELS).tolist()
    dead, saturated = round(e.dead * TACTELS), round(e.saturated * TACTELS)
    readout = TactileReadout.draw(
        TACTELS, seed=e.seed, dead=tuple(drawn[:dead]), saturated=tuple(drawn[dead:][:saturated])
    )
    readout = replace(readout, noise=e.noise)
    return readout, calibrate(run_bench(readout, seed=e.seed))


def _compiled(objects: Sequence[TouchObject], mass: float | None) -> tuple[Any, Any, dict]:
    mujoco = import_mujoco()
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / IMAGE_RATE
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.worldbody.add_body(name="carrier", mocap=True).add_site(name=PAD_SITE)
    softness = {}
    for thing in objects:
        body = spec.worldbody.add_body(name=thing.name, mocap=mass is None)
        if mass is not None:
            body.add_freejoint()
        for number, part in enumerate(thing.parts):
            name = f"{thing.name}_{number}"
            kind = getattr(mujoco.mjtGeom, f"mjGEOM_{part.kind.upper()}")
            geom = body.add_geom(name=name, type=kind)
            geom.size[: len(part.size)] = part.size
            geom.pos, geom.quat = part.place, part.quat_wxyz
            geom.mass = (mass or 1.0) / len(thing.parts)
            if thing.foam:
                softness[name] = thing.foam
    if mass is not None:
        height = max(-p.place[2] + p.size[2] for thing in objects for p in thing.parts)
        table = spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_BOX)
        table.size = [0.2, 0.2, TABLE_HALF]
        table.pos = [0.0, 0.0, -height - TABLE_HALF]
    model = spec.compile()
    return model, mujoco.MjData(model), softness
