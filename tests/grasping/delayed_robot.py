"""A simulated Panda in another process, behind a connection with delay, jitter and faults."""

from __future__ import annotations

import sys
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Client
from typing import TypeVar

import numpy as np

from eyehand.apps.grasp.scenes import grasp_scene
from eyehand.data_synth import DepthNoise
from eyehand.data_synth.cell import GraspRobot, GraspWorld, SimRobot, make_robot
from eyehand.grasping import JawCommand
from eyehand.grasping.hands.jaw_control import jaw_reading

T = TypeVar("T")

KEY = b"robot"
SCENE = ("single", 8, 1)
"""Family, seed and number of objects."""
GRIPPED = 0.01
"""Distance by which a slow gripper commands its jaws into the object, m."""


@dataclass(frozen=True)
class Faults:
    """What goes wrong, and from which robot time on, s."""

    delay: tuple[float, float] = (0.005, 0.030)
    """Minimum and maximum delay of every message, s."""
    gripper_stalls: float = np.inf
    """The gripper keeps its last command."""
    gripper_late: float = 0.0
    """Further delay of the gripper's commands, s."""
    gripper_speed: float = np.inf
    """Speed of the width, m/s."""
    arm_stops: float = np.inf
    arm_silent: float = np.inf
    frames_dropped: int = 0
    """Number of frames that the camera drops first."""
    effort: bool = True
    """Whether the gripper senses its effort."""


class DelayedRobot:
    """Answers requests in the robot's own time. Every message takes its delay."""

    def __init__(self, robot: GraspRobot, faults: Faults) -> None:
        self.sim = SimRobot(
            GraspWorld.build(grasp_scene(*SCENE).objects, robot=robot, friction=1.0),
            noise=DepthNoise.realistic(),
        )
        self.faults, self.rng = faults, np.random.default_rng(0)
        self.dropped = 0
        self.commands: list[tuple[float, np.ndarray]] = []
        self.jaws: list[tuple[float, JawCommand]] = []
        self.history = [self.sim.read()]
        self.last = 0.0
        self.commanded = jaw_reading(self.history[-1].hand).width
        for _ in range(75):
            self.history.append(self.sim.step(np.zeros(7)))

    def answer(self, name: str, *arguments):
        """Return the answer to a request."""
        return getattr(self, name)(*arguments)

    def state(self):
        """Return time, joint angles, velocities and fault."""
        seen = self.seen()
        return seen.time, seen.q, seen.velocity, seen.fault

    def width(self):
        """Return the width and, if sensed, the effort."""
        hand = jaw_reading(self.seen().hand)
        return (hand.width, hand.effort) if self.faults.effort else (hand.width,)

    def move(self, width, force):
        """Take a command of the gripper."""
        arrival = self.arrival() + self.faults.gripper_late
        self.jaws.append((arrival, JawCommand(width, force)))

    def step(self, velocity):
        """Take velocities, and return the state one period later."""
        self.commands.append((self.arrival(), velocity))
        now = self.sim.data.time
        commanded = newest(self.commands, now)
        if commanded is None or now >= self.faults.arm_stops:
            commanded = np.zeros(7)
        command = newest(self.jaws, min(now, self.faults.gripper_stalls))
        if command is not None and np.isfinite(self.faults.gripper_speed):
            step = self.faults.gripper_speed * self.sim.period
            low = jaw_reading(self.history[-1].hand).width - GRIPPED
            self.commanded += np.clip(max(command.width, low) - self.commanded, -step, step)
            command = JawCommand(self.commanded, command.force)
        self.history.append(self.sim.step(commanded, command))
        return self.state()

    def capture(self):
        """Return a depth image; None for a dropped one."""
        if self.dropped < self.faults.frames_dropped:
            self.dropped += 1
            return None
        return self.sim.capture()

    def arrival(self) -> float:
        """Return when a message sent now arrives. Messages keep their order."""
        self.last = max(self.last, float(self.sim.data.time) + self.rng.uniform(*self.faults.delay))
        return self.last

    def seen(self):
        """Return the newest state whose message has arrived."""
        until = self.sim.data.time - self.rng.uniform(*self.faults.delay)
        until = min(until, self.faults.arm_silent)
        return next((one for one in reversed(self.history) if one.time <= until), self.history[0])


def newest(messages: list[tuple[float, T]], until: float) -> T | None:
    """Return the last message that has arrived until a time, s; they are in order of time."""
    return next((message for time, message in reversed(messages) if time <= until), None)


def serve(port: int) -> None:
    """Connect to a port of this computer again and again, each time as a new robot.

    A client sends the faults first. The robot answers its requests until the connection closes. The
    process ends when nobody listens any more.
    """
    robot = make_robot("panda")
    while True:
        try:
            connection = Client(("localhost", port), authkey=KEY)
        except (OSError, EOFError):
            return
        with connection, suppress(EOFError, ConnectionError):
            delayed = DelayedRobot(robot, Faults(**connection.recv()))
            connection.send("ready")
            while True:
                connection.send(delayed.answer(*connection.recv()))


if __name__ == "__main__":
    serve(int(sys.argv[1]))
