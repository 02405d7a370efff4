"""A simulated glove: tactile patches on the inner faces of all phalanges and the palm."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import SENSORS, SensorModel
from eyehand.data_synth.pad.calibration_bench import MAX_LOAD_PA as PAD_MAX_LOAD_PA
from eyehand.data_synth.pad.sensor_memory import SensorMemory
from eyehand.errors import InputError
from eyehand.tactile import Glove, TactileArray
from eyehand.tactile.sensors import SensorInfo, TactileFrame

PITCH_M = 0.005
"""Greatest distance between tactels. Each face has as many as cover it."""
SPREAD_M = 0.0025
"""Standard deviation of the image of a point force through the glove's foam."""
MAX_LOAD_PA = 1e6
"""Highest pressure that the tactels measure, Pa. A point force of 30 N makes 0.8 MPa."""
RATE = 250.0
"""Images per second."""
LINKS = ("proximal", "middle", "distal")
"""Ends of the names of phalanx geoms."""
PALM = "palm_pad"
THUMB = "thumb"


class SimulatedGlove:
    """A glove on the hand of a MuJoCo model, read as one sensor. It implements `TactileSensor`.

    Patches are on box geoms named ``<finger>_proximal``, ``_middle``, ``_distal`` and ``palm_pad``.
    The inner face of a finger is at +x of its box, of the thumb at -x, of the palm at +z. The frame
    of a patch has its origin in the middle of this face and z outwards; y is along the link.

    Parameters
    ----------
    model, data
        ``mujoco.MjModel`` and ``mujoco.MjData``. The caller advances the physics.
    prefix
        Prefix of the names of the hand.
    sensor
        Sensor model; "good" of `SENSORS` if not given.
    seed
        Source of characteristics, gains and noise, >= 0.

    Raises
    ------
    InputError
        If the model has no such geom or no site ``palm``.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        prefix: str = "",
        sensor: SensorModel | None = None,
        seed: int = 0,
    ) -> None:
        self._mujoco, self._model, self._data = import_mujoco(), model, data
        names = {model.geom(k).name.removeprefix(prefix): k for k in range(model.ngeom)}
        kept = {
            name: number
            for name, number in names.items()
            if (name == PALM or name.rpartition("_")[2] in LINKS)
            and model.geom_type[number] == self._mujoco.mjtGeom.mjGEOM_BOX
        }
        if PALM not in kept or len(kept) < 2:
            raise InputError(f"the model has no phalanges and palm with prefix {prefix!r}")
        self._names = {number: name for name, number in kept.items()}
        self._faces = {name: _face(name, model.geom_size[k]) for name, k in kept.items()}
        self.glove = Glove({name: array for name, (_, array) in self._faces.items()})
        self._site = model.site(f"{prefix}palm").id
        self._rng = np.random.default_rng((seed, 3))
        model_of = sensor or SENSORS["good"]
        count = len(self.glove.array.positions)
        soft = model_of.readout(count, seed)
        # A glove is stiffer than a pad: the same curves over a wider range.
        stiffness = MAX_LOAD_PA / PAD_MAX_LOAD_PA
        self.readout = replace(soft, half_pressures=stiffness * soft.half_pressures)
        """Electronics of all tactels. Calibrate them by `run_bench` up to `MAX_LOAD_PA`."""
        self._memory = SensorMemory(model_of, self.readout, seed)
        self._info = SensorInfo("simulated glove", self.glove.array, RATE)
        self._time = -np.inf
        self.true_pressures: NDArray[np.float64] = np.zeros(count)
        """Pressure on each tactel at the last reading, (N,), Pa, before the electronics."""

    @property
    def info(self) -> SensorInfo:
        """Description of the glove."""
        return self._info

    @property
    def poses(self) -> dict[str, RigidTransform]:
        """Current T_hand_patch of each patch; the hand's frame is the site ``palm``."""
        T_world_hand = self._pose(
            self._data.site_xpos[self._site], self._data.site_xmat[self._site]
        )
        return {name: T_world_hand.inv() * self._patch_pose(k) for k, name in self._names.items()}

    def read(self, timeout: float = 1.0) -> TactileFrame | None:
        """Return an image of the present contacts; None if physics has not advanced by a period."""
        time = float(self._data.time)
        if time < self._time + 0.999 / RATE:
            return None
        self._time = time
        self._press()
        return TactileFrame(time, self._memory.read(time, self.true_pressures, self._rng))

    def close(self) -> None:
        """Do nothing: there is no device."""

    def _press(self) -> None:
        """Spread the normal force of each contact over the tactels of its patch."""
        data, wrench = self._data, np.zeros(6)
        self.true_pressures[:] = 0.0
        for k in range(data.ncon):
            contact = data.contact[k]
            for side, geom in enumerate(contact.geom.tolist()):
                name = self._names.get(geom)
                if name is None:
                    continue
                self._mujoco.mj_contactForce(self._model, data, k, wrench)
                # The normal points from the first geom to the second: inwards on the second.
                push = wrench[0] * contact.frame[:3] * (1.0 if side else -1.0)
                pose = self._patch_pose(geom)
                force = -float(pose.rotation.inv().apply(push)[2])
                if force > 0.0:
                    self._spread(name, pose.inv().apply(contact.pos), force)

    def _spread(self, name: str, place: NDArray[np.float64], force: float) -> None:
        array = self.glove.patches[name]
        gaps = array.positions[:, :2] - place[:2]
        # A force beside the array counts at its border: the nearest tactel has weight 1.
        squares = (gaps**2).sum(axis=1)
        weights = np.exp(-(squares - squares.min()) / (2 * SPREAD_M**2))
        self.true_pressures[self.glove.slices[name]] += (
            force * weights / weights.sum() / array.areas
        )

    def _patch_pose(self, geom: int) -> RigidTransform:
        """Return T_world_patch of the patch on a geom."""
        T_geom_patch, _ = self._faces[self._names[geom]]
        return self._pose(self._data.geom_xpos[geom], self._data.geom_xmat[geom]) * T_geom_patch

    def _pose(self, place: NDArray[np.float64], rotation: NDArray[np.float64]) -> RigidTransform:
        turn = Rotation.from_matrix(rotation.reshape(3, 3))
        return RigidTransform.from_components(place, turn)


def _face(name: str, half: NDArray[np.float64]) -> tuple[RigidTransform, TactileArray]:
    """Return T_geom_patch and the array of the inner face of a box with half sides (3,), m."""
    if name == PALM:
        outward, along = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    else:
        outward = np.array([-1.0 if name.startswith(THUMB) else 1.0, 0.0, 0.0])
        along = np.array([0.0, 0.0, 1.0])
    axes = np.column_stack([np.cross(along, outward), along, outward])
    width, length = (2 * float(abs(axis) @ half) for axis in axes.T[:2])
    columns, rows = (max(int(np.ceil(side / PITCH_M)), 1) for side in (width, length))
    x, y = (
        (np.arange(count) + 0.5) * side / count - 0.5 * side
        for count, side in ((columns, width), (rows, length))
    )
    across, down = np.meshgrid(x, y)
    positions = np.column_stack([across.ravel(), down.ravel(), np.zeros(across.size)])
    area = width * length / across.size
    array = TactileArray.of_poses(
        positions, np.tile([0.0, 0.0, 1.0], (across.size, 1)), area, 1.5 * PITCH_M
    )
    turn = Rotation.from_matrix(axes)
    return RigidTransform.from_components(float(abs(outward) @ half) * outward, turn), array
