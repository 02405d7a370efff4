"""Grip force from the load on the object, its friction, and slip alarms."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import Protocol

from eyehand.errors import InputError


@dataclass(frozen=True)
class GripReading:
    """The measurements of one pad in a cycle."""

    normal: float
    """Normal force, N."""
    tangential: float
    """Amount of the tangential force on this pad, N."""
    slipping: bool
    """Whether the slip detector raises an alarm."""


class GripLaw(Protocol):
    """A law that computes the grip force to command."""

    def update(self, reading: GripReading, dt: float) -> float:
        """Return the grip force to command, N.

        Parameters
        ----------
        reading
            What the pad measures now.
        dt
            Time since the last cycle, s.
        """
        ...


@dataclass(frozen=True)
class LoadGripOptions:
    """Reserve and speed of a grip that follows the load.

    Raises
    ------
    InputError
        If a value is negative or not finite.
    """

    reserve: float = 0.2
    """Force above the least one, N. A force, not a factor, as noise and knocks do not grow with the
    load."""
    lag: float = 0.02
    """Time constant of the actuator, s; its inverse is fed forward."""
    relax_time: float = 0.6
    """Time in which the grip falls to 1/e of its distance to the least force, s."""
    raised: float = 0.25
    """Share by which a slip alarm raises the force."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0 <= value < float("inf"):
                raise InputError(f"{name} must be finite and >= 0, got {value}")


_FILTER_TIME = 0.008
"""Time constant of the filter of the load, s."""
ALARM_PAUSE_S = 0.04
"""Time after an alarm in which no further one counts, s: two time constants of the actuator."""
_MAX_LEAD = 2.0
"""Most force that is commanded to overcome the actuator's lag, as a multiple of the goal."""


class LoadGrip:
    """A grip that follows the load: least force for the friction, and a reserve.

    The least force is the tangential force over the friction. It rises at once, with the inverse of
    the actuator's lag, and relaxes slowly. A slip alarm raises the force, and lowers the friction
    to the ratio of that moment.

    Parameters
    ----------
    friction
        Estimated ratio of tangential to normal force at which the object slides, > 0.
    grip
        Grip force at the start, N.
    options
        Reserve and speed.
    pause
        Time at the start in which alarms do not count, s. After a pull the object still slides
        until the grip has risen.
    """

    def __init__(
        self,
        friction: float,
        grip: float,
        options: LoadGripOptions | None = None,
        pause: float = 0.0,
    ) -> None:
        if not 0 < friction < float("inf"):
            raise InputError(f"friction must be finite and > 0, got {friction}")
        self._options = options or LoadGripOptions()
        self.friction = friction
        self._goal = grip
        self._load: float | None = None
        self._rate = 0.0
        self._pause = pause

    def update(self, reading: GripReading, dt: float) -> float:
        """Return the grip force to command, N (see :class:`GripLaw`)."""
        o = self._options
        share = 1.0 - exp(-dt / _FILTER_TIME)
        if self._load is None:
            self._load = reading.tangential
        step = share * (reading.tangential - self._load)
        self._load += step
        self._rate += share * (step / dt - self._rate)
        # The filtered load lags by the filter's time; its rate makes up for that.
        load = max(self._load + self._rate * _FILTER_TIME, self._load)
        self._pause -= dt
        if reading.slipping and self._pause <= 0.0 and reading.normal > 0.0:
            self._pause = ALARM_PAUSE_S
            ratio = self._load / reading.normal
            self.friction = min(max(ratio, self.friction / (1 + o.raised)), self.friction)
            self._goal *= 1 + o.raised
        least = load / self.friction + o.reserve
        if least >= self._goal:
            self._goal = least
        else:
            self._goal += (least - self._goal) * (1.0 - exp(-dt / o.relax_time))
        lead = max(o.lag * self._rate / self.friction, 0.0)
        return self._goal + min(lead, _MAX_LEAD * self._goal)


class SlipGrip:
    """The chapter's law: each slip alarm raises the force by a share, and it decays in between.

    Parameters
    ----------
    grip
        Grip force at the start, N.
    raised
        Share by which an alarm raises the force.
    decay_time
        Time in which the force falls to 1/e, s.
    """

    def __init__(self, grip: float, raised: float = 0.25, decay_time: float = 2.0) -> None:
        self._grip, self._raised, self._decay = grip, raised, decay_time
        self._pause = 0.0

    def update(self, reading: GripReading, dt: float) -> float:
        """Return the grip force to command, N (see :class:`GripLaw`)."""
        self._grip *= exp(-dt / self._decay)
        self._pause -= dt
        if reading.slipping and self._pause <= 0.0:
            self._pause = ALARM_PAUSE_S
            self._grip *= 1 + self._raised
        return self._grip
