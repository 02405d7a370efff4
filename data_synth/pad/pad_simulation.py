"""Simulation of pads in time: driven arms, moving objects, and images at a fixed rate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

from ..arms import HOME_KEY
from ..mujoco_import import import_mujoco
from .pad_scene import PadScene
from .sensor_model import SensorModel
from .tactile_pad import IMAGE_RATE, TactilePad
from .tactile_readout import TactileReadout

CONTROL_RATE = 250.0
"""Control cycles per second of the chapter's arm."""

_MAX_PHASE = 0.3
"""Maximum phase by which a free body may oscillate in one step, rad. Semi-implicit steps are stable
up to 2; at this value the frequency is exact to 1 %."""
_MAX_SUBSTEPS = 16
"""Steps in one step of the model. Beyond this, light bodies that are pressed flat lose accuracy."""
_SAME_TIME = 1e-9
"""Times closer than this are equal, s."""


@dataclass(frozen=True)
class PadSample:
    """The image and the true state of one pad at one time."""

    time: float
    """Time since the start, s."""
    raw: NDArray[np.uint16]
    """(N,), the image as the electronics return it."""
    force: float
    """True normal force on the pad, N."""
    centre: NDArray[np.float64]
    """True centre of pressure in the pad's frame, (3,), m; NaN if nothing touches."""
    joints: NDArray[np.float64]
    """Angles of all driven joints, (n,), rad."""


class PadSimulation:
    """Pads, arms and objects in time.

    The arms follow their joint velocities exactly, at a constant velocity over each call of
    :meth:`advance`, like a stiff arm with its own controller. Forces move only free objects.
    Physics takes steps of the model's length, and shorter ones while a light object lies on foam.
    Without free objects no physics is computed.

    Parameters
    ----------
    model, data
        ``mujoco.MjModel`` and ``mujoco.MjData``.
    pads
        One or more.
    joints
        Names of the driven joints (hinges or slides), in the order of the velocities.
    image_rate
        Images per second; 250 are enough for control at that rate, slip needs all 1900.
    seed
        Source of the readout's noise, >= 0.

    Raises
    ------
    InputError
        If a rate or the seed is out of range, or a joint is unknown.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        pads: Sequence[TactilePad],
        joints: Sequence[str] = (),
        image_rate: float = IMAGE_RATE,
        seed: int = 0,
    ) -> None:
        if not 0 < image_rate < np.inf or seed < 0:
            raise InputError(f"need image_rate > 0 and seed >= 0, got {image_rate}, {seed}")
        self._mujoco = import_mujoco()
        self.model, self.data = model, data
        self.pads = tuple(pads)
        numbers = {model.joint(j).name: j for j in range(model.njnt)}
        unknown = [name for name in joints if name not in numbers]
        if unknown:
            raise InputError(f"the model has no joints {unknown}; it has {sorted(numbers)}")
        driven = [numbers[name] for name in joints]
        self._qpos = model.jnt_qposadr[driven] if driven else np.zeros(0, np.int64)
        self._dofs = model.jnt_dofadr[driven] if driven else np.zeros(0, np.int64)
        self._physics = model.nv > len(driven)
        self.image_rate = image_rate
        """Images per second."""
        self._period = 1.0 / image_rate
        self._rng = np.random.default_rng(seed)
        self._start = 0.0
        self._images = 0
        self._start_time()

    @classmethod
    def of_scene(
        cls,
        scene: PadScene,
        joints: NDArray[np.float64] | None = None,
        image_rate: float = IMAGE_RATE,
        seed: int = 0,
        readouts: Sequence[TactileReadout] | None = None,
        sensor: SensorModel | None = None,
    ) -> PadSimulation:
        """Start a scene at time 0.

        Parameters
        ----------
        scene
            The scene.
        joints
            Angles of all arms' joints, (n,), rad; the home posture if not given.
        image_rate, seed
            See the class.
        readouts
            Electronics of each pad; the default ones if not given.
        sensor
            Sensor model of all pads; "good" if not given.
        """
        mujoco = import_mujoco()
        data = mujoco.MjData(scene.model)
        data.qpos[:] = _home(scene)
        names = [name for arm in scene.joints for name in arm]
        if joints is not None:
            for name, angle in zip(names, joints, strict=True):
                data.joint(name).qpos[0] = angle
        # Pads hold views of the data's arrays, which are filled here.
        mujoco.mj_kinematics(scene.model, data)
        pads = [
            TactilePad(
                scene.model, data, site, scene.pad, scene.softness, readout, sensor, seed + k
            )
            for k, (site, readout) in enumerate(
                zip(scene.sites, readouts or [None] * len(scene.sites), strict=True)
            )
        ]
        return cls(scene.model, data, pads, names, image_rate, seed)

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return float(self.data.time) - self._start

    @property
    def joints(self) -> NDArray[np.float64]:
        """Angles of the driven joints, (n,), rad."""
        return self.data.qpos[self._qpos]

    def pad_pose(self, pad: int = 0) -> RigidTransform:
        """Return the current pose T_world_pad of a pad."""
        place, rotation = self.pads[pad].pose
        return RigidTransform.from_components(place, Rotation.from_matrix(rotation))

    def advance(
        self,
        velocity: NDArray[np.float64] | None = None,
        duration: float = 1.0 / CONTROL_RATE,
        on_step: Callable[[float], None] | None = None,
    ) -> list[tuple[PadSample, ...]]:
        """Advance time.

        Parameters
        ----------
        velocity
            Velocities of the driven joints, (n,), rad/s; zero if not given.
        duration
            Time to advance, s.
        on_step
            Called with the time, s, at each step, to place mocap bodies.

        Returns
        -------
        list of tuples
            The images taken in that time, in order, one sample per pad in each. With 1900 images
            and 250 calls per second there are 7 or 8.

        Raises
        ------
        InputError
            If there is not one finite velocity per joint, or the duration is not positive.
        """
        speed = np.zeros(len(self._qpos)) if velocity is None else np.asarray(velocity, float)
        if speed.shape != self._qpos.shape or not np.isfinite(speed).all():
            raise InputError(f"need {len(self._qpos)} finite joint velocities, got {speed}")
        if not 0 < duration < np.inf:
            raise InputError(f"duration must be > 0 s, got {duration}")
        begin, end = self.time, self.time + duration
        origin = self.joints
        images: list[tuple[PadSample, ...]] = []
        while self.time < end - _SAME_TIME:
            due = (self._images + 1) * self._period
            goal = min(due, end)
            self._step_to(goal, begin, origin, speed, on_step)
            if due <= end + _SAME_TIME:
                self._images += 1
                images.append(self._sample())
        return images

    def _step_to(
        self,
        goal: float,
        begin: float,
        origin: NDArray[np.float64],
        speed: NDArray[np.float64],
        on_step: Callable[[float], None] | None,
    ) -> None:
        """Step to the time `goal`, s."""
        data, model, mujoco = self.data, self.model, self._mujoco
        while True:
            left = goal - self.time
            if left <= _SAME_TIME:
                return
            steps = self._steps(left)
            step = left / steps
            if self._physics:
                model.opt.timestep = step
                mujoco.mj_step2(model, data)
                model.opt.timestep = self._step
            else:
                data.time += step
            if steps == 1:
                data.time = self._start + goal
            data.qpos[self._qpos] = origin + (self.time - begin) * speed
            data.qvel[self._dofs] = speed
            if on_step:
                on_step(self.time)
            self._update()

    def _steps(self, left: float) -> int:
        """Return the number of equal steps for the remaining time."""
        if not self._physics:
            return 1
        frequency = max(pad.max_frequency() for pad in self.pads)
        max_step = self._step
        if frequency > 0:
            max_step = min(max(_MAX_PHASE / frequency, max_step / _MAX_SUBSTEPS), max_step)
        return max(int(np.ceil(left / max_step - _SAME_TIME)), 1)

    def _update(self) -> None:
        if self._physics:
            self._mujoco.mj_step1(self.model, self.data)
        else:
            self._mujoco.mj_kinematics(self.model, self.data)
        for pad in self.pads:
            pad.contact()

    def _start_time(self) -> None:
        self._step = float(self.model.opt.timestep)
        self._start = float(self.data.time)
        self._mujoco.mj_forward(self.model, self.data)
        self._update()

    def _sample(self) -> tuple[PadSample, ...]:
        return tuple(
            PadSample(self.time, pad.read(self._rng), pad.force, pad.centre, self.joints)
            for pad in self.pads
        )


def _home(scene: PadScene) -> NDArray[np.float64]:
    """Return the model's joint positions with every arm at its home posture."""
    model = scene.model
    qpos = model.qpos0.copy()
    keys = {model.key(k).name: model.key_qpos[k] for k in range(model.nkey)}
    for joints in scene.joints:
        key = keys[joints[0].removesuffix("joint1") + HOME_KEY]
        for name in joints:
            address = model.joint(name).qposadr[0]
            qpos[address] = key[address]
    return qpos
