"""Simulated arms with tactile pads in a control loop: image, features, twist, joint speeds."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import exp
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import ControlOptions, Proximity, RobotModel, safe_motion, solve_stack
from eyehand.control.tasks import TaskRows
from eyehand.data_synth.pad import (
    CONTROL_RATE,
    PAD_SITE,
    SENSORS,
    Arm,
    PadOptions,
    PadSample,
    PadScene,
    PadSimulation,
    SensorModel,
    TactileReadout,
    padded_arm,
    run_bench,
)
from eyehand.errors import InputError
from eyehand.tactile import (
    Calibration,
    ContactFeatures,
    FeatureOptions,
    FeatureReader,
    FoamMemory,
    calibrate,
    world_twist,
)

CYCLE = 1.0 / CONTROL_RATE
"""Control period, s."""

SensorName = Literal["ideal", "good", "real", "harsh"]
"""Name of a sensor model of `SENSORS`."""

WRIST_NOISE = 0.1
"""Standard deviation of the force that the wrist measures in a cycle, N."""

_BASE_BODY = "base"


@dataclass(frozen=True)
class RigOptions:
    """Delays between the servo and the motion of the pad, the image rate, and the sensor.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    lag: float = 0.015
    """Time constant with which joints follow a commanded velocity, s: an assumption about the arm's
    own controller. 0 is an arm without inertia."""
    latency: int = 1
    """Number of cycles from an image to the command computed from it."""
    image_rate: float = CONTROL_RATE
    """Images per second. Control reads the mean of the images of a cycle, so that more images mean
    less noise. The 1900 of the real pad take four times as long to simulate."""
    sensor: SensorName = "good"
    """Sensor model of the pads, and of the joints' backlash."""
    memory: FoamMemory | None = None
    """Memory of the foam, which is removed from the place of a contact."""
    gains: NDArray[np.float64] | None = None
    """Relative gains of the tactels since the bench, (N,), which all pads' calibrations divide by.
    Default: as on the bench."""

    def __post_init__(self) -> None:
        if not (0 <= self.lag < np.inf and self.latency >= 0):
            raise InputError(f"lag and latency must be >= 0, got {self.lag} s, {self.latency}")


class PadArm:
    """One arm of an :class:`ArmRig`: the features, the pose and the motion of its pad."""

    def __init__(self, robot: RobotModel, reader: FeatureReader, q: NDArray[np.float64]) -> None:
        self.robot = robot
        self.reader = reader
        self.features: ContactFeatures
        """Features of the last image."""
        self.active_limits: tuple[str, ...] = ()
        """Names of the limits that were active in the last cycle."""
        self.side_force = np.zeros(2)
        """Tangential force on the pad, (2,), N, that the wrist measures with noise."""
        self.set_state(q, np.zeros(robot.n))

    @property
    def pose(self) -> RigidTransform:
        """T_world_pad from the arm's joints."""
        # Forward kinematics returns a valid rotation, and a check would take longer.
        rotation = Rotation.from_matrix(self._state.rotation, assume_valid=True)
        return RigidTransform.from_components(self._state.position, rotation)

    @property
    def tactel_area(self) -> float:
        """Area of a tactel, m²."""
        return self.reader.image.array.area

    @property
    def twist(self) -> NDArray[np.float64]:
        """Twist [v, ω] of the pad in the last cycle, (6,), m/s and rad/s, in the pad's frame."""
        twist = (self._state.jacobian @ self._speed).reshape(2, 3) @ self._state.rotation
        return twist.ravel()

    def joint_speed(self, twist: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return joint velocities (n,), rad/s, for a twist of the pad (6,) in the pad's frame.

        The twist becomes one task with six rows. Eq. 14 maps it to the world's axes. The safety
        level keeps joint ranges and speeds.
        """
        state = self._state
        if not (np.any(twist) or self._speed.any()):
            # An arm that is at rest and shall stay at rest needs no solver.
            self.active_limits = ()
            return np.zeros(self.robot.n)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = state.rotation, state.position
        rate = world_twist(pose, twist)
        task = TaskRows("touch", np.zeros(6), rate, state.jacobian)
        nominal = solve_stack([task], speed=state.speed).velocity
        safe = safe_motion(
            nominal, state.jacobian, state, _NOTHING_NEAR, _CONTROL, self.robot.joint_names
        )
        self.active_limits = safe.blocking
        return safe.velocity

    def set_state(self, q: NDArray[np.float64], speed: NDArray[np.float64]) -> None:
        """Set the joint angles (n,), rad, and the joint speeds of the last cycle (n,), rad/s."""
        self._state = self.robot.at(q)
        self._speed = speed


class ArmRig:
    """A simulated cell whose arms execute twists of their pads, 250 times per second.

    Each pad has its own electronics. As a real pad, it is calibrated on the simulated bench with
    the full characteristic. The joints follow with the delays of the options.

    Parameters
    ----------
    scene
        Arms, pads and objects.
    arms
        The arms that the scene was built with.
    seed
        Seed of electronics, bench and noise, >= 0.
    options
        Delays and image rate.
    features
        Options of the contact features.
    joints
        Start angles of the joints of all arms, (n,), rad. Default: home.
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
        sensor: SensorModel = SENSORS[o.sensor]
        readouts = [sensor.readout(count, seed + k) for k in range(len(arms))]
        self.simulation = PadSimulation.of_scene(
            scene, joints, o.image_rate, seed, readouts, sensor
        )
        self._wrist_rng = np.random.default_rng((seed, 2))
        self._backlash = sensor.backlash
        self._motors = self.simulation.joints
        self.hands: tuple[PadArm, ...] = tuple(
            PadArm(
                _robot(arm, scene.pad),
                FeatureReader(
                    _calibration(readout, seed, o.gains), pad.array, features, o.memory, CYCLE
                ),
                q,
            )
            for arm, readout, pad, q in zip(
                arms, readouts, self.simulation.pads, self._by_arm(len(arms)), strict=True
            )
        )
        rest = np.zeros(len(self.simulation.joints))
        self._delayed: deque[NDArray[np.float64]] = deque([rest] * o.latency)
        self._gain = 1.0 if o.lag == 0.0 else 1.0 - exp(-CYCLE / o.lag)
        self._speed = rest
        self.step(*[np.zeros(6)] * len(arms))

    @property
    def hand(self) -> PadArm:
        """The first arm."""
        return self.hands[0]

    @property
    def time(self) -> float:
        """Simulated time since the start, s."""
        return self.simulation.time

    def step(
        self,
        *twists: NDArray[np.float64],
        move: Callable[[float], None] | None = None,
    ) -> list[tuple[PadSample, ...]]:
        """Run one control cycle.

        Parameters
        ----------
        *twists
            For each arm the commanded twist of its pad, (6,), m/s and rad/s, in the pad's frame.
        move
            Called with the time, s, before each step of the simulation, to place mocap bodies.

        Returns
        -------
        list of tuples
            The images of this cycle with their ground truth, one tuple entry per arm. The features
            of the hands are those of the mean image.
        """
        pairs = zip(self.hands, twists, strict=True)
        self._delayed.append(np.concatenate([hand.joint_speed(twist) for hand, twist in pairs]))
        self._speed = self._speed + self._gain * (self._delayed.popleft() - self._speed)
        samples = self.simulation.advance(self._drive_joints(), CYCLE, move)
        speeds = np.split(self._speed, len(self.hands))
        if self._backlash == 0.0:
            self._motors = self.simulation.joints
        joints = np.split(self._motors, len(self.hands))
        for number, hand in enumerate(self.hands):
            hand.set_state(joints[number], speeds[number])
            push = -self.simulation.pads[number].wrench[:2]
            hand.side_force = push + WRIST_NOISE * self._wrist_rng.standard_normal(2)
            if samples:
                images = np.array([sample[number].raw for sample in samples])
                hand.features = hand.reader.read(np.rint(images.mean(axis=0)).astype(np.uint16))
        return samples

    def _drive_joints(self) -> NDArray[np.float64]:
        """Move the motors for one cycle, and return the joints' speeds (n,), rad/s.

        The motors' angles are what the arm measures. A joint stays where it is until the motor has
        crossed the free play.
        """
        if self._backlash == 0.0:
            return self._speed
        self._motors = self._motors + CYCLE * self._speed
        joints, play = self.simulation.joints, 0.5 * self._backlash
        return (np.clip(joints, self._motors - play, self._motors + play) - joints) / CYCLE

    def _by_arm(self, arms: int) -> list[NDArray[np.float64]]:
        return np.split(self.simulation.joints, arms)


def home_pose() -> RigidTransform:
    """Return T_world_pad of the default arm at home, where the pad faces down."""
    robot = _robot(Arm(), PadOptions())
    state = robot.at(robot.home)
    return RigidTransform.from_components(state.position, Rotation.from_matrix(state.rotation))


def _calibration(
    readout: TactileReadout, seed: int, gains: NDArray[np.float64] | None
) -> Calibration:
    calibration = calibrate(run_bench(readout, seed=seed))
    return calibration if gains is None else calibration.with_gains(gains)


def _robot(arm: Arm, pad: PadOptions) -> RobotModel:
    spec = padded_arm(pad)
    base = spec.body(_BASE_BODY)
    base.pos = arm.T_world_base.translation
    base.quat = arm.T_world_base.rotation.as_quat(scalar_first=True)
    return RobotModel.load(spec, PAD_SITE)


_CONTROL = ControlOptions(dt=CYCLE)
_NO_POINTS = np.zeros((0, 3))
_NOTHING_NEAR = Proximity(
    (), np.zeros(0), _NO_POINTS, _NO_POINTS, _NO_POINTS, np.zeros((0, 7)), np.zeros(0)
)
"""No pair of the safety level: the pad must touch, so that only joint limits are kept."""
