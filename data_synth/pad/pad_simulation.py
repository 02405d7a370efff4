"""Time goes on for pads: arms are driven, objects move, and images come at their rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

from ..arms import HOME_KEY
from ..mujoco_import import import_mujoco
from .tactile_pad import IMAGE_RATE, TactilePad

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from .pad_scene import PadScene
    from .tactile_readout import TactileReadout

CONTROL_RATE = 250.0
"""Control cycles a second of the chapter's arm."""
LONGEST_PHASE = 0.3
"""A free body's own motion may turn by this much in a step, rad: semi-implicit steps are stable
up to 2, and true to 1 % of the frequency here."""
MOST_SUBSTEPS = 16
"""Steps in one of the model's: past this, light bodies that are pressed flat lose exactness."""


@dataclass(frozen=True)
class PadSample:
    """What was so when an image was taken, of one pad."""

    time: float
    """s since the start."""
    raw: NDArray[np.uint16]
    """(N,), the image as the electronics give it."""
    force: float
    """True normal force on the pad, N."""
    centre: NDArray[np.float64]
    """True centre of pressure in the pad's frame, (3,), m; NaN when nothing touches."""
    joints: NDArray[np.float64]
    """Angles of all driven joints, (n,), rad."""


class PadSimulation:
    """Pads, arms and objects in time.

    The arms go exactly where they are driven, at a constant velocity over each call of
    :meth:`advance`, as a stiff arm's own controller sees to; forces move free objects only.
    Physics takes steps of the model's length, and shorter ones while a light object lies on foam.
    Without free objects no physics is stepped at all.

    Parameters
    ----------
    model, data
        ``mujoco.MjModel`` and ``mujoco.MjData``.
    pads
        One or more.
    joints
        Names of the driven joints (hinges or slides), in the order that velocities have.
    image_rate
        Images a second; control that reads 250 a second needs no more, slip needs all 1900.
    seed
        Source of the read-out's noise, >= 0.

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
        self._period = 1.0 / image_rate
        self._rng = np.random.default_rng(seed)
        self._start = 0.0
        self._images = 0
        self._settle()

    @classmethod
    def of_scene(
        cls,
        scene: PadScene,
        joints: NDArray[np.float64] | None = None,
        image_rate: float = IMAGE_RATE,
        seed: int = 0,
        readouts: Sequence[TactileReadout] | None = None,
    ) -> PadSimulation:
        """Start a cell.

        Parameters
        ----------
        scene
            The cell.
        joints
            Angles of all arms' joints, (n,), rad; the arms' home when not given.
        image_rate, seed
            See the class.
        readouts
            Electronics of each pad; the default ones when not given.

        Returns
        -------
        PadSimulation
            At time 0.
        """
        mujoco = import_mujoco()
        data = mujoco.MjData(scene.model)
        data.qpos[:] = _home(scene)
        names = [name for arm in scene.joints for name in arm]
        if joints is not None:
            for name, angle in zip(names, joints, strict=True):
                data.joint(name).qpos[0] = angle
        # Pads hold views of the data, which are filled here and stay the same arrays.
        mujoco.mj_kinematics(scene.model, data)
        pads = [
            TactilePad(scene.model, data, site, scene.pad, scene.softness, readout)
            for site, readout in zip(
                scene.sites, readouts or [None] * len(scene.sites), strict=True
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
        """Give T_world_pad: where a pad is now."""
        place, rotation = self.pads[pad].pose
        return RigidTransform.from_components(place, Rotation.from_matrix(rotation))

    def advance(
        self,
        velocity: NDArray[np.float64] | None = None,
        duration: float = 1.0 / CONTROL_RATE,
        move: Callable[[float], None] | None = None,
    ) -> list[tuple[PadSample, ...]]:
        """Let time go on.

        Parameters
        ----------
        velocity
            Of the driven joints, (n,), rad/s; they stand still when not given.
        duration
            s.
        move
            Called with the time, s, before each step, to place mocap bodies.

        Returns
        -------
        list of tuples
            The images taken meanwhile, in order, each with one moment per pad. At 1900 images
            and 250 calls a second there are 7 or 8.

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
        seen: list[tuple[PadSample, ...]] = []
        while self.time < end - _SAME_TIME:
            due = (self._images + 1) * self._period
            goal = min(due, end)
            self._pass(goal, begin, origin, speed, move)
            if due <= end + _SAME_TIME:
                self._images += 1
                seen.append(self._look())
        return seen

    def _pass(
        self,
        goal: float,
        begin: float,
        origin: NDArray[np.float64],
        speed: NDArray[np.float64],
        move: Callable[[float], None] | None,
    ) -> None:
        """Step to a time."""
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
            if move:
                move(self.time)
            self._update()

    def _steps(self, left: float) -> int:
        """Equal steps that the time left is to be split in."""
        if not self._physics:
            return 1
        quickest = max(pad.quickest() for pad in self.pads)
        longest = self._step
        if quickest > 0:
            longest = min(max(LONGEST_PHASE / quickest, longest / MOST_SUBSTEPS), longest)
        return max(int(np.ceil(left / longest - _SAME_TIME)), 1)

    def _update(self) -> None:
        if self._physics:
            self._mujoco.mj_step1(self.model, self.data)
        else:
            self._mujoco.mj_kinematics(self.model, self.data)
        for pad in self.pads:
            pad.contact()

    def _settle(self) -> None:
        self._step = float(self.model.opt.timestep)
        self._start = float(self.data.time)
        self._mujoco.mj_forward(self.model, self.data)
        self._update()

    def _look(self) -> tuple[PadSample, ...]:
        return tuple(
            PadSample(self.time, pad.read(self._rng), pad.force, pad.centre, self.joints)
            for pad in self.pads
        )


_SAME_TIME = 1e-9


def _home(scene: PadScene) -> NDArray[np.float64]:
    """Every arm's home; the rest as the model has it."""
    model = scene.model
    qpos = model.qpos0.copy()
    keys = {model.key(k).name: model.key_qpos[k] for k in range(model.nkey)}
    for joints in scene.joints:
        key = keys[joints[0].removesuffix("joint1") + HOME_KEY]
        for name in joints:
            address = model.joint(name).qposadr[0]
            qpos[address] = key[address]
    return qpos
