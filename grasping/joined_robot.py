"""Join the drivers of an arm, a hand and a camera to the robot that a pick needs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import DeviceError, InputError
from eyehand.perception import DepthFrame

from .hands import AnyCommand, AnyReading, HandModel, ParallelHand
from .robot import Arm, ArmReading, Camera, Hand, RobotReading
from .robot_checks import ARM, CAMERA, HAND, check_members, check_type

STALE_SECONDS = 0.3
"""Time without a new state of the arm after which it counts as stopped, s. It is ten times the
delay of a slow network."""
STOPPED_SECONDS = 0.6
"""Time for which the arm must stand still against its command to count as stopped, s."""
MIN_COMMAND = 0.05
"""Norm of the commanded velocities above which a standing arm does not follow, rad/s."""
FOLLOW_SHARE = 0.05
"""Share of the commanded path below which the arm does not follow."""
MAX_CAPTURES = 3
"""Number of attempts to capture a depth image. Cameras drop single frames."""
DRIVER_ERRORS = (DeviceError, OSError, EOFError)
"""Exceptions by which a driver reports that it lost its device. TimeoutError is an OSError."""


class JoinedRobot:
    """A robot made of three drivers. It implements `eyehand.grasping.Robot`.

    Errors of a driver, an arm whose state does not change any more, and an arm that does not follow
    its commands become `RobotReading.fault`. The arm is then commanded to stand still.

    Parameters
    ----------
    arm, hand, camera
        The drivers.
    describe
        Function of the hand's posture, as `Robot.description`.
    hand_frame
        Name of the hand's frame in that description.

    Raises
    ------
    InputError
        If a driver lacks a member, or its first reading has a wrong type.
    """

    def __init__(
        self,
        arm: Arm,
        hand: Hand,
        camera: Camera,
        describe: Callable[[NDArray[np.float64]], Any],
        hand_frame: str,
    ) -> None:
        check_members(arm, ARM, "Arm")
        check_members(hand, HAND, "Hand")
        check_members(camera, CAMERA, "Camera")
        self._arm, self._hand, self._camera = arm, hand, camera
        self._describe, self._hand_frame = describe, hand_frame
        self._fault = ""
        self._still_since: float | None = None
        self._stale = 0.0
        self._wanted = np.zeros(len(arm.joints))
        self._start_q = np.zeros(len(arm.joints))
        self._state = arm.read()
        check_type(self._state, ArmReading, "arm.read()")
        self._hand_state: AnyReading = hand.read()

    @property
    def hand(self) -> HandModel | ParallelHand:
        """Model of the hand."""
        return self._hand.model

    @property
    def period(self) -> float:
        """Control period, s."""
        return self._arm.period

    @property
    def hand_frame(self) -> str:
        """Name of the hand's frame in the description."""
        return self._hand_frame

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the arm's joints."""
        return self._arm.joints

    def description(self, posture: NDArray[np.float64]) -> Any:
        """Describe arm and hand for control, in a posture of the hand."""
        return self._describe(posture)

    def capture(self) -> DepthFrame:
        """Capture a depth image; try again after a dropped frame.

        Raises
        ------
        DeviceError
            If the camera gives no image in `MAX_CAPTURES` attempts.
        """
        reason = ""
        for _ in range(MAX_CAPTURES):
            try:
                return self._camera.capture()
            except DRIVER_ERRORS as error:
                reason = one_line(error)
        raise DeviceError(f"the camera gave no image in {MAX_CAPTURES} attempts: {reason}")

    def read(self) -> RobotReading:
        """Return the current state without moving."""
        arm = self._state
        return RobotReading(
            arm.time, arm.q, arm.velocity, self._hand_state, self._fault, arm.wrench
        )

    def step(
        self, velocity: NDArray[np.float64], command: AnyCommand | None = None
    ) -> RobotReading:
        """Move for one period and return the state at its end.

        Raises
        ------
        InputError
            If the velocities have a wrong shape or are not finite.
        """
        velocity = np.asarray(velocity, dtype=np.float64)
        if velocity.shape != (len(self.joints),) or not np.isfinite(velocity).all():
            raise InputError(
                f"velocity must be {len(self.joints)} finite rad/s, got {velocity.tolist()}"
            )
        part = "hand"
        try:
            if command is not None and not self._fault:
                self._hand.move(command)
            part = "arm"
            state = self._arm.step(np.zeros_like(velocity) if self._fault else velocity)
            part = "hand"
            self._hand_state = self._hand.read()
        except DRIVER_ERRORS as error:
            self._fault = self._fault or f"the {part}'s driver failed: {one_line(error)}"
            return self.read()
        self._fault = self._fault or state.fault or self._check(state, velocity)
        self._state = state
        return self.read()

    def _check(self, state: ArmReading, velocity: NDArray[np.float64]) -> str:
        """Return the fault of an arm that sends no new state or does not follow; else nothing."""
        period = self.period
        self._stale = self._stale + period if state.time <= self._state.time else 0.0
        if self._stale > STALE_SECONDS:
            return f"the arm has sent no new state for {self._stale:.1f} s"
        if np.linalg.norm(velocity) < MIN_COMMAND:
            self._still_since = None
            return ""
        if self._still_since is None:
            self._still_since, self._start_q = state.time, state.q.copy()
            self._wanted = np.zeros(len(velocity))
        self._wanted = self._wanted + period * np.abs(velocity)
        if state.time - self._still_since < STOPPED_SECONDS:
            return ""
        path = float(np.linalg.norm(self._wanted))
        moved = float(np.linalg.norm(state.q - self._start_q))
        self._still_since = None
        if moved < FOLLOW_SHARE * path:
            return f"the arm does not follow: it moved {moved:.3f} rad of {path:.2f} commanded"
        return ""


def one_line(error: BaseException) -> str:
    """Return the message of an exception, or its type, in one line."""
    return " ".join(str(error).split()) or type(error).__name__
