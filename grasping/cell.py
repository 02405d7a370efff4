"""A robot, what it sees by, and where it puts things: all that a pick works with."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import RobotModel

from .pick_options import PickOptions
from .report import PhaseRecord

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame, Scene

    from .plan import GraspPlan
    from .report import Phase
    from .robot import HandCommand, Robot, RobotReading
    from .tray import Tray


@dataclass(frozen=True)
class Moment:
    """What an onlooker is told after every control period."""

    phase: Phase
    """What the robot is at."""
    reading: RobotReading
    """Its state."""
    scene: Scene | None
    """What was seen last."""
    plan: GraspPlan | None
    """Grasp under way."""
    force: NDArray[np.float64]
    """Force on each finger, the thumb last, then the palm, (F + 1,), N."""


@dataclass
class Cell:
    """A robot at work; every motion goes through :meth:`step`, which watches and records.

    Parameters
    ----------
    robot
        The robot.
    see
        From a depth frame to a scene in the world's frame.
    tray
        Where things are put.
    options
        Of the pick.
    watch
        Told of every control period.
    """

    robot: Robot
    see: Callable[[DepthFrame], Scene]
    tray: Tray
    options: PickOptions = field(default_factory=PickOptions)
    watch: Callable[[Moment], None] | None = None

    def __post_init__(self) -> None:
        self.reading: RobotReading = self.robot.read()
        """State at the end of the last period."""
        self.tops: list[float] = []
        """Height over the tray's floor up to which the objects of each layer stand, m."""
        self.scene: Scene | None = None
        """What was seen last."""
        self.plan: GraspPlan | None = None
        """Grasp under way."""
        self.phase: Phase = "look"
        """Phase under way."""
        self.records: list[PhaseRecord] = []
        """Phases that ended since the last :meth:`begin`."""
        self.times: list[float] = []
        """Times of the forces recorded since then, s."""
        self.forces: list[NDArray[np.float64]] = []
        """Those forces, each (F + 1,), N."""
        self._models: dict[tuple[float, ...], RobotModel] = {}
        self._owner = _pad_owners(self.robot.hand.pads, self.robot.hand.fingers)

    def model(self, excursions: NDArray[np.float64]) -> RobotModel:
        """Arm and hand for control, with the tendons pulled in so far, (D,), m."""
        key = tuple(np.round(excursions, 4).tolist())
        if key not in self._models:
            robot = self.robot
            described = robot.description(np.array(key))
            self._models[key] = RobotModel.load(described, robot.frame, joints=robot.joints)
        return self._models[key]

    def palm(self) -> RigidTransform:
        """Where the palm is, T_world_palm."""
        state = self._opened().at(self.reading.q)
        rotation = Rotation.from_matrix(state.rotation)
        return RigidTransform.from_components(state.position, rotation)

    @property
    def home(self) -> NDArray[np.float64]:
        """The arm's rest posture, (n,), rad."""
        return self._opened().home

    @property
    def tray_height(self) -> float:
        """Height over the tray's floor up to which walls or objects in it stand, m."""
        return max([self.tray.wall_height, *self.tops])

    def begin(self) -> None:
        """Start a new record."""
        self.records, self.times, self.forces = [], [], []

    def enter(self, phase: Phase) -> float:
        """Enter a phase, and give the robot's time."""
        self.phase = phase
        return self.reading.time

    def leave(self, start: float, outcome: str) -> None:
        """Note how the phase that began at ``start`` ended."""
        self.records.append(PhaseRecord(self.phase, start, self.reading.time, outcome))

    def step(
        self, velocity: NDArray[np.float64], command: HandCommand | None = None
    ) -> RobotReading:
        """Move for one period."""
        self.reading = reading = self.robot.step(velocity, command)
        force = np.zeros(len(self.robot.hand.fingers) + 1)
        np.add.at(force, self._owner, reading.hand.forces)
        self.times.append(reading.time)
        self.forces.append(force)
        if self.watch is not None:
            self.watch(Moment(self.phase, reading, self.scene, self.plan, force))
        return reading

    def rest(self, seconds: float, command: HandCommand | None = None) -> RobotReading:
        """Stand still for some time, or until the robot has a fault."""
        still = np.zeros(len(self.robot.joints))
        end = self.reading.time + seconds
        while self.reading.time < end and not self.reading.fault:
            self.step(still, command)
        return self.reading

    def _opened(self) -> RobotModel:
        hand = self.robot.hand
        return self.model(hand.pulled(hand.widest))


def _pad_owners(pads: tuple[str, ...], fingers: tuple[str, ...]) -> NDArray[np.intp]:
    """For each pad the number of its finger; one past the last for the palm."""
    return np.array(
        [
            next((k for k, finger in enumerate(fingers) if pad.startswith(finger)), len(fingers))
            for pad in pads
        ],
        dtype=np.intp,
    )
