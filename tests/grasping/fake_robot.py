"""A fake robot without physics. Joints follow at once, and the test sets the contact forces."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.cell import GraspRobot
from eyehand.data_synth.cell.tendon_hand_model import tendon_hand_model
from eyehand.grasping.hands import HandCommand, HandReading
from eyehand.grasping.robot import RobotReading
from eyehand.perception import CameraIntrinsics, DepthFrame

PERIOD = 0.004
ROBOT = GraspRobot()
assert ROBOT.hand is not None
HAND = tendon_hand_model(ROBOT.hand)
CONTACT_FORCE_N = 3.0
"""Force on each pad in contact."""


@dataclass
class FakeRobot:
    """A robot that follows every command without error."""

    object_width: float | None = 0.04
    """Width of the object between the fingers, m; None for no object."""
    lost_at: float = np.inf
    """Time after which the object is lost, s."""
    thumb_contacts: int = 0
    """Number of thumb contacts while the open hand moves down."""
    thumb_contact_height: float = 0.15
    """Height of the palm below which the thumb has contact, m."""
    fault_at: float = np.inf
    """Time at which the robot has a fault, s."""
    T_world_base: RigidTransform = field(
        default_factory=lambda: RigidTransform.from_translation([-0.5, 0.0, 0.12])
    )
    time: float = 0.0

    def __post_init__(self):
        self.hand, self.period, self.hand_frame, self.joints = (
            HAND,
            PERIOD,
            ROBOT.frame,
            ROBOT.joints,
        )
        self.q = np.array(ROBOT.home)
        self.speed = np.zeros(len(self.joints))
        self.excursions = HAND.excursions[-1].copy()
        self.pulling = False
        self.palm_height = lambda q: np.inf
        self.in_thumb_contact = False
        self.commands: list[HandCommand] = []

    def description(self, posture):
        """Describe the included arm and hand."""
        return ROBOT.description(ROBOT.home, posture, self.T_world_base)

    def capture(self):
        """Return an image that no test reads."""
        camera = CameraIntrinsics(100.0, 100.0, 15.5, 11.5, 32, 24)
        depth = np.ones((24, 32), np.float32)
        return DepthFrame(depth, camera, RigidTransform.from_translation([0.0, 0.5, 0.9]))

    def read(self):
        """Return the current state."""
        reading = HandReading(
            excursions=self.excursions.copy(),
            tensions=np.zeros(len(HAND.drives)),
            angles=np.zeros(len(HAND.joints)),
            forces=np.zeros(len(HAND.pads)),
            tips=(),
        )
        fault = "the arm has lost its power" if self.time >= self.fault_at else ""
        return RobotReading(
            self.time,
            self.q.copy(),
            self.speed,
            replace(reading, forces=self.pad_forces(reading)),
            fault,
        )

    def pad_forces(self, reading):
        """Return the force on every pad, (P,), N."""
        touch = np.zeros(len(HAND.pads))
        thumb = np.array([pad.startswith("thumb") for pad in HAND.pads])
        low = self.palm_height(self.q) < self.thumb_contact_height
        if low and self.thumb_contacts > 0:
            touch[thumb] = CONTACT_FORCE_N
            self.in_thumb_contact = True
        elif self.in_thumb_contact and not low:
            self.thumb_contacts, self.in_thumb_contact = self.thumb_contacts - 1, False
        if self.object_width is None or self.time >= self.lost_at:
            return touch
        if self.opening() <= self.object_width:
            tips = np.array([pad.endswith("distal") for pad in HAND.pads])
            touch[tips] = CONTACT_FORCE_N
        return touch

    def opening(self):
        """Return the opening at the excursion of the middle finger's tendon, m."""
        drive = HAND.drives.index("middle")
        excursions = HAND.excursions[::-1, drive]
        return float(np.interp(self.excursions[drive], excursions, HAND.openings[::-1]))

    def step(self, velocity, command=None):
        """Move by one period without lag."""
        assert np.isfinite(velocity).all()
        self.speed = np.asarray(velocity)
        self.q = self.q + PERIOD * self.speed
        self.time += PERIOD
        if command is not None:
            self.commands.append(command)
            for drive, mode in enumerate(command.modes):
                if mode == "position":
                    self.excursions[drive] = command.values[drive]
                elif mode == "pull" and command.values[drive] == 0.0:
                    self.excursions[drive] = HAND.excursions[-1][drive]
        return self.read()
