"""Arms with tactile pads in one loop: image, features, twist of the pad, joints, image again."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import exp
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import ControlOptions, Proximity, RobotModel, safe_motion, solve_stack
from eyehand.control.tasks import TaskRows
from eyehand.data_synth.pad import (
    CONTROL_RATE,
    PAD_SITE,
    Arm,
    PadScene,
    PadSimulation,
    TactileReadout,
    pad_scene,
    padded_arm,
    run_bench,
)
from eyehand.errors import InputError
from eyehand.tactile import FeatureReader, calibrate, world_twist

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from eyehand.data_synth.pad import PadOptions, PadSample
    from eyehand.tactile import ContactFeatures, FeatureOptions

CYCLE = 1.0 / CONTROL_RATE
"""Of control, s."""

_BASE_BODY = "base"


@dataclass(frozen=True)
class RigOptions:
    """What stands between the servo and the pad's motion.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    lag: float = 0.015
    """Time constant with which joints follow a velocity, s: what the arm's own controller is taken
    to need; 0 is an arm without inertia."""
    latency: int = 1
    """Whole cycles from an image to the moment when what was made of it is sent."""
    image_rate: float = CONTROL_RATE
    """Images a second: control reads the mean of each cycle's, so more are calmer. The real pad's
    1900 take four times as long to simulate."""

    def __post_init__(self) -> None:
        if not (0 <= self.lag < np.inf and self.latency >= 0):
            raise InputError(f"need lag >= 0 s and latency >= 0, got {self.lag}, {self.latency}")


class Hand:
    """One arm of a rig: what its pad feels, where it is, and how it moves.

    Rigs make their own.
    """

    def __init__(self, robot: RobotModel, reader: FeatureReader, q: NDArray[np.float64]) -> None:
        self.robot = robot
        self.reader = reader
        self.features: ContactFeatures
        """What the last image says."""
        self.held_back: tuple[str, ...] = ()
        """What the safety level last held the arm back for, by name."""
        self.moved(q, np.zeros(robot.n))

    @property
    def pose(self) -> RigidTransform:
        """T_world_pad by the arm's own joints."""
        # Forward kinematics gives rotations: testing each again takes longer than to find it.
        rotation = Rotation.from_matrix(self._state.rotation, assume_valid=True)
        return RigidTransform.from_components(self._state.position, rotation)

    @property
    def twist(self) -> NDArray[np.float64]:
        """Twist [v; ω] that the pad moved with in the last cycle, (6,), in its own frame."""
        turned = (self._state.jacobian @ self._speed).reshape(2, 3) @ self._state.rotation
        return turned.ravel()

    def joint_speed(self, twist: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give joint velocities (n,), rad/s, for a twist of the pad (6,) in its own frame.

        The twist becomes one task of six rows (eq. 14 maps it to the world's axes), and the safety
        level keeps joint ranges and speeds.
        """
        state = self._state
        if not (np.any(twist) or self._speed.any()):
            # An arm at rest that is to stay so needs no solving.
            self.held_back = ()
            return np.zeros(self.robot.n)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = state.rotation, state.position
        rate = world_twist(pose, twist)
        task = TaskRows("touch", np.zeros(6), rate, state.jacobian)
        nominal = solve_stack([task], speed=state.speed).velocity
        safe = safe_motion(
            nominal, state.jacobian, state, _NOTHING_NEAR, _CONTROL, self.robot.joint_names
        )
        self.held_back = safe.blocking
        return safe.velocity

    def moved(self, q: NDArray[np.float64], speed: NDArray[np.float64]) -> None:
        """Tell where the joints are now, (n,), and how fast they went, (n,)."""
        self._state = self.robot.at(q)
        self._speed = speed


class ArmRig:
    """A cell whose arms are moved by twists of their pads, 250 times a second.

    Each pad has electronics of its own and is calibrated on the simulated bench by the full curve,
    as a real one would be. Joints follow late, as the options say.

    Parameters
    ----------
    scene
        Arms, pads and objects.
    arms
        The same as the scene was built with.
    seed
        Of electronics, bench and noise, >= 0.
    options
        Lag and waiting.
    features
        How contacts are described.
    joints
        Where the joints of all arms start, (n,), rad; at home when not given.
    """

    def __init__(
        self,
        scene: PadScene,
        arms: Sequence[Arm] = (Arm(),),
        *,
        seed: int = 0,
        options: RigOptions | None = None,
        features: FeatureOptions | None = None,
        joints: NDArray[np.float64] | None = None,
    ) -> None:
        o = options or RigOptions()
        count = scene.pad.rows * scene.pad.columns
        readouts = [TactileReadout.draw(count, seed=seed + k) for k in range(len(arms))]
        self.simulation = PadSimulation.of_scene(scene, joints, o.image_rate, seed, readouts)
        self.hands: tuple[Hand, ...] = tuple(
            Hand(
                _robot(arm, scene.pad),
                FeatureReader(calibrate(run_bench(readout, seed=seed)), pad.array, features),
                q,
            )
            for arm, readout, pad, q in zip(
                arms, readouts, self.simulation.pads, self._by_arm(len(arms)), strict=True
            )
        )
        rest = np.zeros(len(self.simulation.joints))
        self._waiting: deque[NDArray[np.float64]] = deque([rest] * o.latency)
        self._follow = 1.0 if o.lag == 0.0 else 1.0 - exp(-CYCLE / o.lag)
        self._speed = rest
        self.step(*[np.zeros(6)] * len(arms))

    @property
    def hand(self) -> Hand:
        """The only arm, or the first."""
        return self.hands[0]

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self.simulation.time

    def step(
        self,
        *twists: NDArray[np.float64],
        move: Callable[[float], None] | None = None,
    ) -> list[tuple[PadSample, ...]]:
        """Go through one cycle.

        Parameters
        ----------
        *twists
            For each arm the wished twist of its pad, (6,), m/s and rad/s, in the pad's frame.
        move
            Called with the time, s, before each step of the simulation, to place mocap bodies.

        Returns
        -------
        list of tuples
            The images taken meanwhile, with the truth of that moment; the features that the hands
            have now are of their mean.
        """
        pairs = zip(self.hands, twists, strict=True)
        self._waiting.append(np.concatenate([hand.joint_speed(twist) for hand, twist in pairs]))
        self._speed = self._speed + self._follow * (self._waiting.popleft() - self._speed)
        moments = self.simulation.advance(self._speed, CYCLE, move)
        speeds = np.split(self._speed, len(self.hands))
        joints = self._by_arm(len(self.hands))
        for number, hand in enumerate(self.hands):
            hand.moved(joints[number], speeds[number])
            if moments:
                images = np.array([moment[number].raw for moment in moments])
                hand.features = hand.reader.read(np.rint(images.mean(axis=0)).astype(np.uint16))
        return moments

    def _by_arm(self, arms: int) -> list[NDArray[np.float64]]:
        return np.split(self.simulation.joints, arms)


def home_pose(arm: Arm | None = None, pad: PadOptions | None = None) -> RigidTransform:
    """Give T_world_pad of an arm at home, to lay objects before it; the pad looks down there."""
    robot = _robot(arm or Arm(), pad or pad_scene().pad)
    state = robot.at(robot.home)
    return RigidTransform.from_components(state.position, Rotation.from_matrix(state.rotation))


def _robot(arm: Arm, pad: PadOptions) -> RobotModel:
    spec = padded_arm(pad)
    base = spec.body(_BASE_BODY)
    base.pos = arm.T_world_base.translation
    base.quat = arm.T_world_base.rotation.as_quat(scalar_first=True)
    return RobotModel.load(spec, PAD_SITE)


_CONTROL = ControlOptions(dt=CYCLE)
_NOTHING_NEAR = Proximity(
    (),
    np.zeros(0),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros((0, 7)),
    np.zeros(0),
)
"""The pad is to touch, so that distances are not kept; joint ranges and speeds are."""
