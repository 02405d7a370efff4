"""A robot without physics: joints follow at once, and the hand feels what the test says."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.cell import GraspRobot, tendon_hand_model
from eyehand.grasping.robot import HandCommand, HandReading, RobotReading
from eyehand.perception import CameraIntrinsics, DepthFrame

PERIOD = 0.004
ROBOT = GraspRobot()
assert ROBOT.hand is not None
HAND = tendon_hand_model(ROBOT.hand)
FELT = 3.0
"""N on each pad that touches."""


@dataclass
class FakeRobot:
    """Follows every command perfectly."""

    holds: float | None = 0.04
    """Width at which the closing hand meets an object on both sides, m; None is nothing there."""
    drops_at: float = np.inf
    """Time after which the object is gone, s."""
    bumps: int = 0
    """How often the thumb meets something while the hand comes down with open fingers."""
    bump_height: float = 0.15
    """Height of the palm below which it does, m."""
    breaks_at: float = np.inf
    """Time at which the robot has a fault, s."""
    T_world_base: RigidTransform = field(
        default_factory=lambda: RigidTransform.from_translation([-0.5, 0.0, 0.12])
    )
    time: float = 0.0

    def __post_init__(self):
        self.hand, self.period, self.frame, self.joints = HAND, PERIOD, ROBOT.frame, ROBOT.joints
        self.q = np.array(ROBOT.home)
        self.speed = np.zeros(len(self.joints))
        self.excursions = HAND.excursions[-1].copy()
        self.pulling = False
        self.palm_height = lambda q: np.inf
        self.bumped = False
        self.commands: list[HandCommand] = []

    def description(self, excursions):
        """Describe the arm and the hand that come with eyehand."""
        return ROBOT.description(ROBOT.home, excursions, self.T_world_base)

    def capture(self):
        """Give an image that nobody reads."""
        camera = CameraIntrinsics(100.0, 100.0, 15.5, 11.5, 32, 24)
        depth = np.ones((24, 32), np.float32)
        return DepthFrame(depth, camera, RigidTransform.from_translation([0.0, 0.5, 0.9]))

    def read(self):
        """Give the state now."""
        reading = HandReading(
            excursions=self.excursions.copy(),
            tensions=np.zeros(len(HAND.drives)),
            angles=np.zeros(len(HAND.joints)),
            forces=np.zeros(len(HAND.pads)),
            tips=(),
        )
        fault = "the arm has lost its power" if self.time >= self.breaks_at else ""
        return RobotReading(
            self.time, self.q.copy(), self.speed, replace(reading, forces=self.felt(reading)), fault
        )

    def felt(self, reading):
        """Give the force on every pad."""
        touch = np.zeros(len(HAND.pads))
        thumb = np.array([pad.startswith("thumb") for pad in HAND.pads])
        low = self.palm_height(self.q) < self.bump_height
        if low and self.bumps > 0:
            touch[thumb] = FELT
            self.bumped = True
        elif self.bumped and not low:
            self.bumps, self.bumped = self.bumps - 1, False
        if self.holds is None or self.time >= self.drops_at:
            return touch
        if self.opening() <= self.holds:
            tips = np.array([pad.endswith("distal") for pad in HAND.pads])
            touch[tips] = FELT
        return touch

    def opening(self):
        """Give the free width that the middle finger's tendon leaves, m."""
        drive = HAND.drives.index("middle")
        pulled = HAND.excursions[::-1, drive]
        return float(np.interp(self.excursions[drive], pulled, HAND.openings[::-1]))

    def step(self, velocity, command=None):
        """Follow at once."""
        assert np.isfinite(velocity).all()
        self.speed = np.asarray(velocity)
        self.q = self.q + PERIOD * self.speed
        self.time += PERIOD
        if command is not None:
            self.commands.append(command)
            for drive, mode in enumerate(command.modes):
                if mode == "place":
                    self.excursions[drive] = command.values[drive]
                elif mode == "pull" and command.values[drive] == 0.0:
                    self.excursions[drive] = HAND.excursions[-1][drive]
        return self.read()
