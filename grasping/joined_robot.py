"""Join the drivers of an arm, a hand and a camera to the robot that a pick needs."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import DeviceError, InputError
from eyehand.perception import DepthFrame

from .hands import AnyCommand, AnyReading, HandModel, ParallelHand
from .robot import Arm, ArmReading, Camera, Hand, RobotReading
from .robot_checks import ARM, CAMERA, HAND, check_members, check_type
from .robot_watch import one_line

_log = logging.getLogger("eyehand")

MAX_CAPTURES = 3
"""Number of attempts to capture a depth image. Cameras drop single frames."""


class JoinedRobot:
    """A robot made of three drivers. It implements `eyehand.grasping.Robot`.

    Errors of a driver become a `DeviceError` that names the driver.

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
        If a driver lacks a member, its first reading has a wrong type, or `describe` is no
        function.
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
        if not callable(describe):
            raise InputError(
                f"JoinedRobot: describe must be a function of the hand's posture, got {describe!r}"
            )
        self._arm, self._hand, self._camera = arm, hand, camera
        self._describe, self._hand_frame = describe, hand_frame
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
            except Exception as error:
                # A driver raises what its library raises, often a RuntimeError.
                _log.debug("the camera failed", exc_info=True)
                reason = one_line(error)
        raise DeviceError(f"the camera gave no image in {MAX_CAPTURES} attempts: {reason}")

    def read(self) -> RobotReading:
        """Return the current state without moving."""
        arm = self._state
        return RobotReading(arm.time, arm.q, arm.velocity, self._hand_state, arm.fault, arm.wrench)

    def step(
        self, velocity: NDArray[np.float64], command: AnyCommand | None = None
    ) -> RobotReading:
        """Move for one period and return the state at its end.

        Raises
        ------
        InputError
            If the velocities have a wrong shape or are not finite.
        DeviceError
            If the driver of the arm or of the hand fails.
        """
        velocity = np.asarray(velocity, dtype=np.float64)
        if velocity.shape != (len(self.joints),) or not np.isfinite(velocity).all():
            raise InputError(
                f"velocity must be {len(self.joints)} finite rad/s, got {velocity.tolist()}"
            )
        part = "hand"
        try:
            if command is not None:
                self._hand.move(command)
            part = "arm"
            state = self._arm.step(velocity)
            check_type(state, ArmReading, "what step() returns")
            self._state = state
            part = "hand"
            self._hand_state = self._hand.read()
        except Exception as error:
            raise DeviceError(f"{part}: {one_line(error)}") from error
        return self.read()
