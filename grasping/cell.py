"""The robot cell: a robot, its perception, and the tray that objects are put into."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import LinkVolumes, RobotModel
from eyehand.errors import InputError
from eyehand.perception import PosedVolumes, volume_extents

from .hand_frame_check import check_hand_frame
from .hands import AnyCommand, HandModel, ParallelHand
from .hands.finger_control import FingerControl
from .hands.jaw_control import JawControl
from .hands.touch_monitor import TouchMonitor
from .pick_options import PickOptions
from .report import Phase, PhaseRecord
from .robot_checks import check_robot, check_start, check_tray
from .robot_watch import RobotWatch
from .tray_plan import content_obstacles

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from eyehand.control import Obstacle, RobotState
    from eyehand.perception import DepthFrame, Scene

    from .hands.hand_control import HandControl
    from .joint_travel import HeldJoint
    from .plan import GraspPlan
    from .robot import Robot, RobotReading
    from .tray import Tray
    from .tray_plan import TrayItem


@dataclass(frozen=True)
class CycleInfo:
    """State of the cell after one control cycle, as passed to `Cell.on_cycle`."""

    phase: Phase
    """Phase under way."""
    reading: RobotReading
    """State of the robot."""
    scene: Scene | None
    """Last perceived scene."""
    plan: GraspPlan | None
    """Grasp under way."""
    force: NDArray[np.float64]
    """Force on each finger, then on the palm, (F + 1,), N. The thumb is the last finger."""


@dataclass
class Cell:
    """A robot at work. Every motion goes through :meth:`step`, which records forces and faults.

    Parameters
    ----------
    robot
        The robot.
    perceive
        Function from a depth frame to a scene in the world frame.
    tray
        The tray that objects are put into.
    options
        Options of the pick.
    on_cycle
        Callback after every control cycle.

    Raises
    ------
    InputError
        If the robot lacks a member, one has a wrong type, the description cannot be loaded or has
        no keyframe ``home``, the hand frame is not the gripper's tool frame, the tray is out of
        reach, or the first reading does not fit the description.
    """

    robot: Robot
    perceive: Callable[[DepthFrame], Scene]
    tray: Tray
    options: PickOptions = field(default_factory=PickOptions)
    on_cycle: Callable[[CycleInfo], None] | None = None

    def __post_init__(self) -> None:
        check_robot(self.robot)
        self.hand: HandControl = hand_control(self.robot.hand)
        """Commands and senses of the hand."""
        self.reading: RobotReading = self.robot.read()
        """State of the robot after the last cycle."""
        self.tray_content: list[TrayItem] = []
        """What was put into the tray."""
        self.scene: Scene | None = None
        """Last perceived scene."""
        self.frame: DepthFrame | None = None
        """Its depth image, without the readings of the robot."""
        self.image_checksum: int | None = None
        """Checksum of the last captured depth image."""
        self.plan: GraspPlan | None = None
        """Grasp under way."""
        self.phase: Phase = "observe"
        """Phase under way."""
        self.records: list[PhaseRecord] = []
        """Phases that ended since the last :meth:`begin`."""
        self.times: list[float] = []
        """Robot times of the forces recorded since the last :meth:`begin`, s."""
        self.forces: list[NDArray[np.float64]] = []
        """Recorded forces, each (F + 1,), N."""
        self.touch_fault = ""
        """What is wrong with the hand's sense of touch; empty if nothing."""
        self._touch: TouchMonitor | None = TouchMonitor()
        self._models: dict[tuple[float, ...], RobotModel] = {}
        check_start(self.reading, self.robot, self._model_with_open_hand())
        check_tray(self.tray, self._model_with_open_hand())
        if isinstance(self.robot.hand, ParallelHand):
            closed = self.model(self.hand.posture(self.robot.hand.min_opening))
            check_hand_frame(
                self.robot.hand_frame, self.robot.hand, self._model_with_open_hand(), closed
            )
        self._watch = RobotWatch(self.reading, self.acceleration)

    def model(self, posture: NDArray[np.float64]) -> RobotModel:
        """Return the model of arm and hand in a posture of the hand (`HandControl.posture`)."""
        key = tuple(np.round(posture, 4).tolist())
        if key not in self._models:
            robot = self.robot
            described = robot.description(np.array(key))
            try:
                model = RobotModel.load(described, robot.hand_frame, joints=robot.joints)
            except InputError as error:
                raise InputError(f"robot.description(): {error}") from None
            self._models[key] = model
        return self._models[key]

    def arm_state(self) -> RobotState:
        """Return pose and Jacobian of the palm."""
        return self._model_with_open_hand().at(self.reading.q)

    def palm_pose(self) -> RigidTransform:
        """Return the pose of the palm, T_world_palm."""
        state = self.arm_state()
        rotation = Rotation.from_matrix(state.rotation)
        return RigidTransform.from_components(state.position, rotation)

    def robot_volumes(self) -> PosedVolumes:
        """Return where the robot is in the world, with an open hand."""
        links, extents = self._links
        return PosedVolumes(extents, links.poses(self.reading.q))

    @cached_property
    def _links(self) -> tuple[LinkVolumes, NDArray[np.float64]]:
        links = LinkVolumes(self._model_with_open_hand())
        return links, volume_extents(links.points)

    @property
    def home(self) -> NDArray[np.float64]:
        """The arm's rest posture, (n,), rad."""
        return self._model_with_open_hand().home

    @property
    def acceleration(self) -> NDArray[np.float64]:
        """Maximum accelerations of the joints, (n,), rad/s²."""
        return self._model_with_open_hand().acceleration

    @property
    def tray_height(self) -> float:
        """Height of the tray's walls, or of the objects in it if they are higher, m.

        It is measured from the tray's floor.
        """
        return max([self.tray.wall_height, *(item.top for item in self.tray_content)])

    @property
    def tray_obstacles(self) -> tuple[Obstacle, ...]:
        """The tray's floor and walls, and the objects that stand in it."""
        return (*self.tray.obstacles(), *content_obstacles(self.tray, self.tray_content))

    @property
    def halted(self) -> str:
        """Reason for which every motion ends now; empty without one."""
        return self.reading.fault or self.touch_fault

    @property
    def held(self) -> HeldJoint | None:
        """The joint that something holds back, such as an object under the hand, if any."""
        return self._watch.held

    @property
    def returning(self) -> HeldJoint | None:
        """A joint that was held back and must move against its side; None once it does."""
        return self._watch.returning

    def expected_q(self) -> NDArray[np.float64]:
        """Return where the last commands lead the joints after the arm's delay, (n,), rad."""
        return self._watch.expected_q()

    def begin_motion(self, *, free: bool = True, returning: HeldJoint | None = None) -> None:
        """Compare the joints with their commands from the present state on.

        In free space a joint that is held back may move the hand less far off its path. A joint
        that was held back and is now ``returning`` is a fault if it does not move.
        """
        levers = np.linalg.norm(self.arm_state().jacobian[:3], axis=0)
        self._watch.begin_motion(levers if free else None, returning)

    @contextmanager
    def stopped_at_error(self) -> Iterator[None]:
        """Brake the arm before an error or Ctrl-C leaves the block."""
        try:
            yield
        except BaseException:
            self._watch.stop(self.robot)
            raise

    def begin(self) -> None:
        """Start new records, and check the tactile sensor of the hand from now on."""
        self.records, self.times, self.forces = [], [], []
        self.touch_fault, self._touch = "", TouchMonitor()

    def ignore_touch(self) -> None:
        """Stop checking the tactile sensor until the next :meth:`begin`."""
        self.touch_fault, self._touch = "", None

    def enter(self, phase: Phase) -> float:
        """Enter a phase, and return the robot time, s."""
        self.phase = phase
        return self.reading.time

    def leave(self, start: float, outcome: str) -> None:
        """Record the end of the phase that began at the robot time ``start``, s."""
        self.records.append(PhaseRecord(self.phase, start, self.reading.time, outcome))

    def step(
        self, velocity: NDArray[np.float64], command: AnyCommand | None = None
    ) -> RobotReading:
        """Move for one control period at joint velocities (n,), rad/s."""
        self.reading = reading = self._watch.step(self.robot, velocity, command)
        if self._touch is not None and not self.touch_fault:
            self.touch_fault = self._touch.check(reading.hand, self.robot.period)
        force = self.hand.forces(reading.hand)
        self.times.append(reading.time)
        self.forces.append(force)
        if self.on_cycle is not None:
            self.on_cycle(CycleInfo(self.phase, reading, self.scene, self.plan, force))
        return reading

    def wait(
        self,
        seconds: float,
        command: Callable[[RobotReading], AnyCommand | None] | AnyCommand | None = None,
    ) -> RobotReading:
        """Keep the arm still for a time, or until every motion must end.

        Parameters
        ----------
        seconds
            Robot time, s.
        command
            Command of the hand, or a function that computes it in every cycle.
        """
        still = np.zeros(len(self.robot.joints))
        end = self.reading.time + seconds
        while self.reading.time < end and not self.halted:
            self.step(still, command(self.reading) if callable(command) else command)
        return self.reading

    def _model_with_open_hand(self) -> RobotModel:
        return self.model(self.hand.posture(self.hand.max_opening))


def hand_control(hand: HandModel | ParallelHand) -> HandControl:
    """Return the commands and senses of a hand."""
    return JawControl(hand) if isinstance(hand, ParallelHand) else FingerControl(hand)
