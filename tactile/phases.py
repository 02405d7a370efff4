"""From the work area to contact, to the task, and off again: every way ends with a name."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from .contact_search import ContactSearch
from .error_watchdog import ErrorWatchdog
from .oscillation_detector import OscillationDetector
from .phase_options import PhaseOptions

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .features import ContactFeatures
    from .servo import TactileServo

Phase = Literal["move", "hold", "task", "search", "back_off", "ended"]
"""move: the caller drives to the work area; hold: wait or descend until the pressure threshold;
task: the servo acts; search: lift, shift, descend; back_off: away from the object; ended: rest."""

Outcome = Literal[
    "done", "unreachable", "no_contact", "contact_lost", "overload", "oscillation",
    "steady_miss", "unsteady_contact", "at_border", "no_resistance", "sensor_fault",
]  # fmt: skip
"""done: time is up or the caller finished; unreachable: the work area was not reached in time;
no_contact: nothing touched within time and way; contact_lost: lost too often or not found again;
overload: pressure or force above the limit, or too many tactels at theirs; oscillation: the
pressure swings, by the loop or by the object, and does not calm; steady_miss: it stays off the
goal; unsteady_contact: the centre of pressure jumps between places, or the pressure swings as the
contact comes and goes faster than the pad can move; at_border: the contact stays at the pad's
border; no_resistance: pressing on does not raise the pressure; sensor_fault: too few trusted
tactels, or features that are not finite."""

UNSTEADY_SECONDS = 1.0
"""Time in which jumps count together, s, and for which one explains a swing."""


@dataclass(frozen=True, slots=True)
class PhaseStep:
    """What to do in this cycle."""

    phase: Phase
    """Where the machine is; in ``move`` the caller drives the arm, else the twist does."""
    twist: NDArray[np.float64]
    """Sensor twist [v; ω], (6,), m/s and rad/s, in the sensor's frame."""
    outcome: Outcome | None
    """Set as soon as the end is decided: first the pad backs off, then the phase is ``ended``."""
    clear: bool
    """Whether nothing touches."""


class TouchPhases:
    """Lead a servo to its contact, guard it there, and lead it off.

    Parameters
    ----------
    servo
        With goal and switches of the task.
    options
        Speeds, bounds and patience.
    """

    def __init__(self, servo: TactileServo, options: PhaseOptions | None = None) -> None:
        self.servo = servo
        self.options = options or PhaseOptions()
        o = self.options
        self._swings = OscillationDetector(o.swing, o.swings, o.swing_seconds)
        self._misses = ErrorWatchdog(o.miss, o.calm, o.miss_seconds, o.miss_spans)
        self._start()

    def _start(self) -> None:
        self.phase: Phase = "move"
        self.outcome: Outcome | None = None
        self._time = 0.0
        self._travel = 0.0
        self._clear_travel = 0.0
        self._touches = 0
        self._overloads = 0
        self._lost_for = 0.0
        self._losses = 0
        self._pushed = 0.0
        self._border_time = 0.0
        self._clock = 0.0
        self._task_time = 0.0
        self._jumps: deque[float] = deque(maxlen=max(1, self.options.jumps))
        self._centre: tuple[float, float] | None = None
        self._near = False
        self._jumped = -math.inf
        self._search: ContactSearch | None = None

    def finish(self) -> None:
        """End the task: the pad backs off and the outcome is ``done``."""
        if self.outcome is None:
            self._end("done")

    def step(
        self,
        features: ContactFeatures,
        dt: float,
        pose_error: tuple[float, float] | None = None,
        external: NDArray[np.float64] | None = None,
        measured: NDArray[np.float64] | None = None,
        trusted: float = 1.0,
    ) -> PhaseStep:
        """Give phase and twist of this cycle.

        Parameters
        ----------
        features
            What the pad feels.
        dt
            Time since the last cycle, s, > 0.
        pose_error
            Distance (m) and angle (rad) to the work area; None where there is no way to go.
        external
            Outer motion of the task, (6,), in the sensor's frame; used in the task only.
        measured
            Twist that the sensor moved with, (6,), as for :meth:`TactileServo.step`.
        trusted
            Share of tactels that are neither dead nor saturated.

        Returns
        -------
        PhaseStep
            Once ``phase`` is ``ended``, the twist stays zero.

        Raises
        ------
        InputError
            If ``dt`` is not positive or the outer motion is not finite.
        """
        self._time += dt
        self._clock += dt
        finite = math.isfinite(
            features.force + features.pressure + features.area + features.orientation
            + features.confidence + features.centre[0] + features.centre[1]
        )  # fmt: skip
        if not finite or trusted < self.options.least_trusted:
            if self.outcome is None:
                self._end("sensor_fault")
            return self._blind(dt)
        touching = bool(features)
        wish = self.servo.step(features, dt, external if self.phase == "task" else None, measured)
        if self.outcome is None:
            self._guard(features)
        if self.outcome is None:
            self._advance(features, dt, pose_error)
        twist = wish.twist
        if self.phase == "task":
            self._watch_the_task(features, twist, dt)
            self._watch_the_goal(features, external, dt)
        if self.phase != "task":
            twist = self._own_twist(touching, dt)
            self.servo.set_sent_twist(twist)
        elif not touching:
            twist = np.zeros(6)
            self.servo.set_sent_twist(twist)
        return PhaseStep(self.phase, twist, self.outcome, not touching)

    # The way there ---------------------------------------------------------------------------

    def _advance(self, features, dt, pose_error) -> None:
        """Change from phase to phase; the task's own ends are told in `_watch_the_task`."""
        o = self.options
        threshold = min(o.touch_pressure, 0.5 * _goal_pressure(self.servo))
        there = bool(features) and features.pressure >= threshold
        self._touches = self._touches + 1 if there else 0
        touched = self._touches >= o.touch_cycles
        if self.phase in ("move", "hold", "search") and touched:
            self._enter("task")
            self._swings.reset()
            self._misses.reset()
            self._lost_for = self._pushed = self._border_time = 0.0
            self._centre, self._near, self._jumped = None, False, -math.inf
        elif self.phase == "move":
            reached = pose_error is None or (
                pose_error[0] <= o.pose_tolerance and pose_error[1] <= o.angle_tolerance
            )
            if reached:
                self._enter("hold")
            elif self._time > o.move_seconds:
                self._end("unreachable")
        elif self.phase == "hold":
            if self._time > o.hold_seconds or self._travel > o.approach_travel:
                self._end("no_contact")
        elif (
            self.phase == "search"
            and self._search is not None
            and (self._search.over or self._time > o.search_seconds)
        ):
            self._end("contact_lost")

    # In the task -----------------------------------------------------------------------------

    def _guard(self, features) -> None:
        """What must end everything, in any phase."""
        o = self.options
        over = (
            features.pressure > o.pressure_limit
            or features.force > o.force_limit
            or features.saturated > o.saturated_share * max(features.tactels, 1)
        )
        self._overloads = self._overloads + 1 if over else 0
        if self._overloads >= o.overload_cycles:
            self._end("overload")

    def _watch_the_task(self, features, twist, dt) -> None:
        o = self.options
        self._task_time += dt
        if self._task_time > o.task_seconds:
            self._end("done")
        elif not features:
            # From near the goal to nothing within a cycle: noise took the contact, not the pad.
            if self._near:
                self._jumped = self._clock
            self._near = False
            self._lost_for += dt
            if self._lost_for > o.lost_seconds:
                self._lose()
        else:
            self._lost_for = 0.0
            self._watch_the_contact(features, twist, dt)

    def _watch_the_goal(self, features, external, dt) -> None:
        """What the pressure makes of its goal, as shares of it."""
        if self.phase != "task":
            return
        goal = _goal_pressure(self.servo)
        if self._swings.update(_felt_pressure(self.servo, features) / goal, dt):
            self._end(self._swinging())
        elif not self.servo.selection.press or (external is not None and external.any()):
            # Over a surface that rises and falls the pressure is off as long as the outer motion
            # goes on.
            self._misses.reset()
        else:
            # The servo's own average: single readings swing with noise, not with the pad.
            outcome = self._misses.update(self.servo.filtered[0] / goal - 1.0, dt)
            if outcome is not None:
                self._end(self._swinging() if outcome == "oscillation" else outcome)

    def _swinging(self) -> Outcome:
        """Why the pressure swings: two contacts that swap, and noise, swing it without the loop."""
        if self._clock - self._jumped < UNSTEADY_SECONDS:
            return "unsteady_contact"
        return "oscillation"

    def _watch_the_contact(self, features, twist, dt) -> None:
        o = self.options
        x, y = float(features.centre[0]), float(features.centre[1])
        if self._centre and math.hypot(x - self._centre[0], y - self._centre[1]) > o.jump:
            self._jumps.append(self._clock)
            # A pad that bounces jumps too, but where it presses little.
            self._jumped = self._clock if self._near else self._jumped
        self._centre = (x, y)
        felt = _felt_pressure(self.servo, features)
        self._near = felt >= o.near_goal * _goal_pressure(self.servo)
        self._pushed = 0.0 if self._near else max(0.0, self._pushed + twist[2] * dt)
        half_x, half_y = o.pad_half_size
        outside = abs(x) > half_x - o.border or abs(y) > half_y - o.border
        self._border_time = self._border_time + dt if outside else 0.0
        if len(self._jumps) == o.jumps and self._clock - self._jumps[0] < UNSTEADY_SECONDS:
            self._end("unsteady_contact")
        elif self._pushed > o.push_travel:
            self._end("no_resistance")
        elif self._border_time > o.border_seconds:
            self._end("at_border")

    def _lose(self) -> None:
        self._losses += 1
        if self._losses > self.options.losses or self.options.searches == 0:
            self._end("contact_lost")
            return
        self._search = ContactSearch(self._centre or (0.0, 0.0), self.options)
        self._enter("search")

    # Own motion ------------------------------------------------------------------------------

    def _own_twist(self, touching, dt):
        o = self.options
        twist = np.zeros(6)
        if self.phase == "hold":
            twist[2] = o.approach_speed
        elif self.phase == "search" and self._search is not None:
            twist[:3] = self._search.step(touching, dt)
        elif self.phase == "back_off":
            self._clear_travel = 0.0 if touching else self._clear_travel + o.back_off_speed * dt
            if self._clear_travel > o.back_off_distance or self._travel > o.back_off_travel:
                self._enter("ended")
            else:
                twist[2] = -o.back_off_speed
        self._travel += abs(twist[2]) * dt
        return twist

    def _blind(self, dt) -> PhaseStep:
        """Without a pad to trust, back off the whole way, for nobody knows what touches."""
        twist = self._own_twist(True, dt) if self.phase == "back_off" else np.zeros(6)
        return PhaseStep(self.phase, twist, self.outcome, False)

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        self._time = self._travel = self._clear_travel = 0.0

    def _end(self, outcome: Outcome) -> None:
        self.outcome = outcome
        # On the way to the work area nothing was touched: there is nothing to back off from.
        self._enter("ended" if self.phase == "move" and outcome != "overload" else "back_off")


def _felt_pressure(servo: TactileServo, features: ContactFeatures) -> float:
    """What is to come to :func:`_goal_pressure`, Pa."""
    if servo.goal.force is None:
        return features.pressure
    return features.force / servo.options.reference_area


def _goal_pressure(servo: TactileServo) -> float:
    """Pressure that the goal asks for, Pa; a force's over the reference area."""
    goal = servo.goal
    return goal.pressure if goal.force is None else goal.force / servo.options.reference_area
