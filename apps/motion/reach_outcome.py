"""One reach run to its end and judged by a model of its own, the same for every method."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from eyehand.data_synth.scenes import ArmClearance
from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.scenes import ReachingScene

REACHED_M = 1e-3
"""The goal is reached when the tool is this near: what a hand's fingers make up for."""
STANDSTILL_S = 2.0
"""An arm that has hardly moved for so long will not go on by itself."""
STANDSTILL_RAD = 1e-4
"""Hardly: no joint has left a range of this width."""


@dataclass(frozen=True)
class ReachOptions:
    """How a reach is run."""

    dt: float = 0.005
    """Length of a cycle, s: between two commands the joints keep their speed."""
    longest: float = 60.0
    """Simulated time after which a reach is given up, s."""

    def __post_init__(self) -> None:
        if not 0 < self.dt <= self.longest < np.inf:
            raise InputError(
                f"dt must be > 0 s and at most longest, got dt {self.dt}, longest {self.longest}"
            )


@dataclass(frozen=True)
class ReachOutcome:
    """What came of a reach.

    `success` means that the tool came within 1 mm of the goal, within the time, and that in no
    cycle from the start to the end any shape of the arm touched a box or another shape of the arm.
    """

    success: bool
    """Goal reached to 1 mm, and no contact."""
    contacts: int
    """Cycles after which a distance was below 0."""
    min_clearance: float
    """Least distance over all cycles, start included, m; at most 1."""
    seconds: float
    """Simulated time until the end, s."""
    final_error: float
    """Distance of the tool from the goal at the end, m."""
    cycle_times_us: NDArray[np.float64]
    """What each cycle of the method took (cycles,), µs; the judge's work is not in it."""
    status: str
    """`reached`; `stuck` when the arm stood still; `late` when the time was up; or the word with
    which the method itself gave up."""


class ReachMethod(Protocol):
    """A method under judgement."""

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        """Take the joint angles (7,), rad; return joint speeds (7,), rad/s, and a status.

        The status is empty as long as the method goes on; else the run ends with that word.
        """
        ...


def run_reach(
    scene: ReachingScene, method: ReachMethod, options: ReachOptions | None = None
) -> ReachOutcome:
    """Run a method from a scene's start until it has reached the goal, given up or run out of time.

    The arm does exactly as told: its angles grow by the commanded speed times the cycle's length.
    Clearance and error are taken from the angles alone, by a model that no method has a hand in.

    Parameters
    ----------
    scene
        Where to start, what to reach, what to avoid.
    method
        Gives the joint speeds of each cycle.
    options
        ControlStep and time.

    Returns
    -------
    ReachOutcome
        The judgement.

    Raises
    ------
    InputError
        If the method returns other than 7 finite speeds.
    """
    options = options or ReachOptions()
    judge = ArmClearance(scene.obstacles)
    q = scene.start.copy()
    least, contacts = judge.at(q), 0
    times: list[float] = []
    trail = deque([q], maxlen=round(STANDSTILL_S / options.dt) + 1)
    status = ""
    while not status:
        began = time.perf_counter_ns()
        speed, status = method(q)
        times.append((time.perf_counter_ns() - began) * 1e-3)
        q = q + options.dt * _checked(speed)
        trail.append(q)
        clearance = judge.at(q)
        least = min(least, clearance)
        contacts += clearance < 0
        if np.linalg.norm(judge.tool(q) - scene.goal) < REACHED_M:
            status = "reached"
        status = status or _ended(trail, len(times), options)
    error = float(np.linalg.norm(judge.tool(q) - scene.goal))
    return ReachOutcome(
        success=status == "reached" and contacts == 0,
        contacts=contacts,
        min_clearance=least,
        seconds=len(times) * options.dt,
        final_error=error,
        cycle_times_us=np.array(times),
        status=status,
    )


def _ended(trail: deque[NDArray[np.float64]], cycles: int, options: ReachOptions) -> str:
    if cycles * options.dt >= options.longest:
        return "late"
    if len(trail) == trail.maxlen and np.abs(trail[-1] - trail[0]).max() < STANDSTILL_RAD:
        path = np.array(trail)
        if np.ptp(path, axis=0).max() < STANDSTILL_RAD:
            return "stuck"
    return ""


def _checked(speed: NDArray[np.float64]) -> NDArray[np.float64]:
    speed = np.asarray(speed, dtype=np.float64)
    if speed.shape != (7,) or not np.isfinite(speed).all():
        raise InputError(f"a method must return 7 finite joint speeds, got {speed}")
    return speed
