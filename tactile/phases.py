"""Phases of a touch: move to the work area, wait for contact, run the task, back off."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .contact_search import ContactSearch
from .error_watchdog import ErrorWatchdog
from .oscillation_detector import OscillationDetector
from .phase_options import PhaseOptions
from .phase_step import PhaseStep

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .features import ContactFeatures
    from .phase_step import Outcome, Phase, SensorFault
    from .servo import TactileServo

MAX_POSITION_ERROR, MAX_ANGLE_ERROR = 0.002, 0.02
"""Pose error at which the work area counts as reached, m and rad."""
MAX_MOVE_SECONDS = 30.0
"""Time limit of the motion to the work area, s."""
MAX_APPROACH = 0.05
"""Maximum descent towards the object, m."""
TOUCH_CYCLES = 3
"""Successive cycles above the contact pressure that make a contact."""
LOST_SECONDS = 0.06
"""Time without contact that counts as lost, s. During a shorter interruption the pad rests."""
OVERLOAD_CYCLES = 2
"""Successive cycles above a safety limit that are an overload."""
BACK_OFF_SPEED = 0.05
"""Speed away from the object, m/s."""
BACK_OFF_CLEARANCE = 0.01
"""Distance that the pad moves on after contact has ended, m."""
MAX_BACK_OFF = 0.05
"""Maximum motion away from the object, m. If the object follows the pad further, the pad stops in
contact."""
MAX_LOSSES = 6
"""Maximum number of lost contacts in one touch. One more ends it, even if every contact was found
again."""
UNSTEADY_JUMPS = 4
"""Number of jumps of the centre of pressure within `UNSTEADY_SECONDS` at which the task ends. Jumps
come from two contacts that alternate, or from noise."""
UNSTEADY_SECONDS = 1.0
"""Time within which jumps count together, and within which a jump explains an oscillation, s."""
BORDER = 0.006
"""Distance to the pad's border below which the imprint is cut off, m."""
BORDER_SECONDS = 2.0
"""Time that the centre of pressure may stay at the border, s."""
MAX_PUSH = 0.03
"""Maximum motion towards the object while the pressure stays far below its goal, m. Beyond it, the
object yields or the pad does not feel it."""
NEAR_GOAL = 0.5
"""Share of the goal pressure from which on the pressure counts as near the goal."""
LOW_GOAL_SHARE = 0.5
"""Share of the goal pressure that counts as contact, if it is below `PhaseOptions.touch_pressure`.
A low goal must start the task too."""


class TouchPhases:
    """State machine of a touch.

    It supervises the servo during the task. In the other phases it moves the pad, except in `move`:
    there the caller moves the arm.

    Parameters
    ----------
    servo
        The servo, with the goal and the selection matrix of the task.
    options
        Speeds, time limits and safety limits.

    Raises
    ------
    InputError
        If the approach is too fast for the servo's delay (`PhaseOptions.check_delay`).
    """

    def __init__(self, servo: TactileServo, options: PhaseOptions | None = None) -> None:
        self.servo = servo
        self.options = options or PhaseOptions()
        self.options.check_delay(servo.options.latency / servo.options.rate + servo.options.arm_lag)
        self._oscillation = OscillationDetector()
        self._watchdog = ErrorWatchdog()
        self.phase: Phase = "move"
        self.outcome: Outcome | None = None
        self._clock = self._task_time = 0.0
        self._phase_time = self._travel = self._clear_travel = 0.0
        self._touch_cycles = self._overload_cycles = 0
        self._lost_for = self._pushed = self._border_time = self._peak = 0.0
        self._losses = 0
        self._jumps: deque[float] = deque(maxlen=UNSTEADY_JUMPS)
        self._last_jump = -math.inf
        self._centre: tuple[float, float] | None = None
        self._near_goal = False
        self._search: ContactSearch | None = None
        self._normal = np.array([0.0, 0.0, 1.0])

    def finish(self) -> None:
        """End the touch with the outcome `done`, unless it has an outcome already.

        The pad backs off. In phase `move` it ends without motion.
        """
        if self.outcome is None:
            self._end("done")

    def step(
        self,
        features: ContactFeatures,
        dt: float,
        pose_error: tuple[float, float] | None = None,
        external: NDArray[np.float64] | None = None,
        measured: NDArray[np.float64] | None = None,
        fault: SensorFault | None = None,
    ) -> PhaseStep:
        """Compute phase and twist of this cycle.

        Parameters
        ----------
        features
            The current contact features.
        dt
            Time since the last cycle, s, > 0.
        pose_error
            Distance (m) and angle (rad) to the work area; None if the arm is there already.
        external
            External twist of the task, (6,), in the sensor's frame; used during the task only.
        measured
            Twist of the sensor since the last cycle, (6,), as for :meth:`TactileServo.step`.
        fault
            Fault of the sensor, as `sensors.SensorMonitor` reports it. The pad then backs off.

        Returns
        -------
        PhaseStep
            Once the phase is `ended`, the twist stays zero.

        Raises
        ------
        InputError
            If `dt` is not positive or the external twist is not finite.
        """
        finite = math.isfinite(
            features.force + features.pressure + features.area + features.orientation
            + features.confidence + features.centre[0] + features.centre[1]
        )  # fmt: skip
        fault = fault or (None if finite else "sensor_fault")
        in_task = self.phase == "task"
        # During the task, the servo checks both inputs.
        if fault or not in_task:
            _check_inputs(dt, external)
        self._phase_time += dt
        self._clock += dt
        if fault:
            if self.outcome is None:
                self._end(fault)
            return self._step_without_sensor(dt)
        touching = bool(features)
        if touching:
            self._normal = features.normal
        twist = self.servo.step(features, dt, external if in_task else None, measured).twist
        if self.outcome is None:
            self._check_overload(features)
        if self.outcome is None:
            self._change_phase(features, pose_error)
        if self.phase == "task":
            self._check_task(features, twist, dt)
        if self.phase == "task":
            self._check_pressure(features, external, dt)
        if self.phase != "task":
            twist = self._own_twist(touching, dt)
            self.servo.set_sent_twist(twist)
        elif not touching:
            twist = np.zeros(6)
            self.servo.set_sent_twist(twist)
        return PhaseStep(self.phase, twist, self.outcome, not touching)

    def _change_phase(
        self, features: ContactFeatures, pose_error: tuple[float, float] | None
    ) -> None:
        """Start the task at contact, or leave `move`, `hold` or `search` at its goal or limit."""
        o = self.options
        threshold = min(o.touch_pressure, LOW_GOAL_SHARE * self.servo.goal_pressure)
        felt = bool(features) and features.pressure >= threshold
        self._touch_cycles = self._touch_cycles + 1 if felt else 0
        if self.phase in ("move", "hold", "search") and self._touch_cycles >= TOUCH_CYCLES:
            self._start_task()
        elif self.phase == "move":
            if pose_error is None or (
                pose_error[0] <= MAX_POSITION_ERROR and pose_error[1] <= MAX_ANGLE_ERROR
            ):
                self._enter("hold")
            elif self._phase_time > MAX_MOVE_SECONDS:
                self._end("unreachable")
        elif self.phase == "hold":
            if self._phase_time > o.hold_seconds or self._travel > MAX_APPROACH:
                self._end("no_contact")
        elif (
            self.phase == "search"
            and self._search is not None
            and (self._search.over or self._phase_time > o.search_seconds)
        ):
            self._end("contact_lost")

    def _start_task(self) -> None:
        self._enter("task")
        self._oscillation.reset()
        self._watchdog.reset()
        self._lost_for = self._pushed = self._border_time = 0.0
        self._centre, self._near_goal, self._last_jump = None, False, -math.inf
        self._peak = 0.0

    # Checks ----------------------------------------------------------------------------------

    def _check_overload(self, features: ContactFeatures) -> None:
        """Check the safety limits, in any phase."""
        o = self.options
        over = (
            features.pressure > o.pressure_limit
            or features.force > o.force_limit
            or features.saturated > o.saturated_share * max(features.tactels, 1)
        )
        self._overload_cycles = self._overload_cycles + 1 if over else 0
        if self._overload_cycles >= OVERLOAD_CYCLES:
            self._end("overload")

    def _check_task(self, features: ContactFeatures, twist: NDArray[np.float64], dt: float) -> None:
        """Check the time of the task and the contact."""
        self._task_time += dt
        if self._task_time > self.options.task_seconds:
            self._end("done")
        elif not features:
            # Motion cannot reduce a pressure near the goal to zero within a cycle. Only noise can,
            # so the loss counts as a jump.
            if self._near_goal:
                self._last_jump = self._clock
            self._near_goal = False
            self._lost_for += dt
            if self._lost_for > LOST_SECONDS:
                self._lose_contact()
        else:
            self._lost_for = 0.0
            self._check_contact(features, twist, dt)

    def _check_contact(
        self, features: ContactFeatures, twist: NDArray[np.float64], dt: float
    ) -> None:
        """Check the place of the contact and the resistance of the object."""
        x, y = float(features.centre[0]), float(features.centre[1])
        if (
            self._centre
            and math.hypot(x - self._centre[0], y - self._centre[1]) > self.options.jump
        ):
            self._jumps.append(self._clock)
            # The centre of pressure also jumps when the pad bounces, but at a low pressure. Such
            # jumps are no other cause of an oscillation.
            self._last_jump = self._clock if self._near_goal else self._last_jump
        self._centre = (x, y)
        pressure = self.servo.measured_pressure(features)
        self._near_goal = pressure >= NEAR_GOAL * self.servo.goal_pressure
        self._pushed = 0.0 if self._near_goal else max(0.0, self._pushed + twist[2] * dt)
        half_x, half_y = self.options.pad_half_size
        outside = abs(x) > half_x - BORDER or abs(y) > half_y - BORDER
        self._border_time = self._border_time + dt if outside else 0.0
        if len(self._jumps) == UNSTEADY_JUMPS and self._clock - self._jumps[0] < UNSTEADY_SECONDS:
            self._end("unsteady_contact")
        elif self._pushed > MAX_PUSH:
            self._end("no_resistance")
        elif self._border_time > BORDER_SECONDS:
            self._end("at_border")

    def _check_pressure(
        self, features: ContactFeatures, external: NDArray[np.float64] | None, dt: float
    ) -> None:
        """Check that the pressure settles at its goal."""
        goal = self.servo.goal_pressure
        # Use the averaged pressure, because single readings scatter with noise.
        pressure = self.servo.filtered[0] / goal
        self._peak = max(self._peak, pressure)
        if self._oscillation.update(self.servo.measured_pressure(features) / goal, dt):
            self._end(self._oscillation_outcome())
        elif not self.servo.selection.press or (external is not None and external.any()):
            # There is no error to watch. An external twist moves the pressure off its goal.
            self._watchdog.reset()
        else:
            outcome = self._watchdog.update(pressure - 1.0, dt)
            if outcome is not None:
                self._end(self._oscillation_outcome() if outcome == "oscillation" else outcome)
            elif self._watchdog.settled and self._peak > self.options.peak_limit >= pressure:
                self._end("overshoot")

    def _oscillation_outcome(self) -> Outcome:
        """Return the cause of an oscillation: alternating contacts, noise, or the loop."""
        recent = self._clock - self._last_jump < UNSTEADY_SECONDS
        return "unsteady_contact" if recent else "oscillation"

    def _lose_contact(self) -> None:
        self._losses += 1
        o = self.options
        if self._losses > MAX_LOSSES or o.searches == 0:
            self._end("contact_lost")
            return
        self._search = ContactSearch(self._centre or (0.0, 0.0), o.searches, o.approach_speed)
        self._enter("search")

    # Motion outside the task -----------------------------------------------------------------

    def _own_twist(self, touching: bool, dt: float) -> NDArray[np.float64]:
        """Compute the twist (6,) of the phases `hold`, `search` and `back_off`; end `back_off`."""
        twist = np.zeros(6)
        if self.phase == "hold":
            twist[2] = self.options.approach_speed
        elif self.phase == "search" and self._search is not None:
            twist[:3] = self._search.step(touching, dt)
        elif self.phase == "back_off":
            self._clear_travel = 0.0 if touching else self._clear_travel + BACK_OFF_SPEED * dt
            if self._clear_travel > BACK_OFF_CLEARANCE or self._travel > MAX_BACK_OFF:
                self._enter("ended")
            else:
                twist[:3] = -BACK_OFF_SPEED * self._normal
        self._travel += float(np.linalg.norm(twist[:3])) * dt
        return twist

    def _step_without_sensor(self, dt: float) -> PhaseStep:
        """Back off by `MAX_BACK_OFF`, because the pad cannot report a contact."""
        twist = self._own_twist(True, dt) if self.phase == "back_off" else np.zeros(6)
        return PhaseStep(self.phase, twist, self.outcome, False)

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        self._phase_time = self._travel = self._clear_travel = 0.0

    def _end(self, outcome: Outcome) -> None:
        self.outcome = outcome
        # In `move`, the pad has no lasting contact and need not back off.
        self._enter("ended" if self.phase == "move" and outcome != "overload" else "back_off")


def _check_inputs(dt: float, external: NDArray[np.float64] | None) -> None:
    if not dt > 0.0 or not (external is None or np.isfinite(external).all()):
        raise InputError(
            f"a cycle needs dt > 0 s and a finite external twist, got {dt}, {external}"
        )
