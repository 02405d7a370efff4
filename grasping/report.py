"""Reports of a pick and of clearing a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.tactile import ContactFeatures

    from .plan import GraspPlan

Phase = Literal[
    "observe",
    "select",
    "pre-grasp",
    "approach",
    "contact",
    "close",
    "grip",
    "lift",
    "check",
    "place",
]
"""Phases of a pick, in execution order."""

PickOutcome = Literal[
    "placed",
    "refused",
    "unreachable",
    "stuck",
    "no_contact",
    "empty_close",
    "hand_stalled",
    "touch_lost",
    "slipped",
    "lost",
    "moved_away",
    "place_failed",
    "wrong_object",
    "fault",
]
"""Outcome of a pick.

- placed: the object is in the tray.
- refused: no grasp prototype suits the object.
- unreachable: the arm reaches no grasp of the object.
- stuck: the arm did not reach its goal in time.
- no_contact: the fingers touched nothing at the expected place.
- empty_close: the hand closed without an object.
- hand_stalled: the hand did not follow its command.
- touch_lost: the hand's sense of touch stopped, repeats old readings, or lost tactels.
- slipped: the object slipped out during the lift.
- lost: the object slipped out after the lift.
- moved_away: the object is no longer where it was perceived.
- place_failed: the object could not be put into the tray.
- wrong_object: the object is still at its place, and another one is gone.
- fault: the robot stopped itself.
"""


CLEAR = "clear"
"""Stop reason when no object is left."""
NOTHING_GRASPABLE = "no remaining object can be grasped"
"""Stop reason when no grasp of the remaining objects is reachable."""
NOT_TRIED = "not tried"
"""Reason of an object that remains because clearing ended early."""
UNREACHABLE = "the arm cannot reach"
"""Begin of the reason of an object whose grasps are all out of reach."""


@dataclass(frozen=True)
class PhaseRecord:
    """One executed phase of a pick."""

    phase: Phase
    """Name of the phase."""
    start: float
    """Robot time at the start, s."""
    end: float
    """Robot time at the end, s."""
    outcome: str
    """``done``, or the reason of the failure."""


@dataclass(frozen=True)
class PickReport:
    """One attempt to pick one object. True in a condition when the object was placed."""

    label: int
    """Label of the object in the scene that the pick was planned in."""
    kind: str
    """Kind of the fitted solid."""
    plan: GraspPlan
    """The executed grasp, or the refusal."""
    outcome: PickOutcome
    """Outcome of the pick."""
    reason: str
    """Reason of a failure, in words; empty after success."""
    phases: tuple[PhaseRecord, ...]
    """Executed phases, in order."""
    perceive_ms: float
    """Computing time from depth image to scene, ms."""
    plan_ms: float
    """Computing time to select the grasp and check its reachability, ms."""
    times: NDArray[np.float64]
    """Robot times of the recorded forces, (T,), s."""
    forces: NDArray[np.float64]
    """Force on each finger, then on the palm, (T, F + 1), N. The thumb is the last finger."""
    contact_pads: int
    """Number of pads in contact while the object was held, palm included."""
    finger_curl: float
    """Mean curl of the fingers while the object was held, rad."""
    tips: tuple[ContactFeatures, ...] = ()
    """Contact on each fingertip while the object was held, the thumb last."""

    def __bool__(self) -> bool:
        return self.outcome == "placed"

    def __str__(self) -> str:
        """Return a line: "box, precision from the top: placed, 5.1 s" of robot time."""
        why = f" ({self.reason})" if self.reason else ""
        return f"{self.kind}, {self.plan.name}: {self.outcome}{why}, {self.seconds:.1f} s"

    @property
    def seconds(self) -> float:
        """Robot time from the first phase to the end, s."""
        return self.phases[-1].end - self.phases[0].start if self.phases else 0.0


@dataclass(frozen=True)
class ClearReport:
    """All picks on one table, and what remains on it."""

    picks: tuple[PickReport, ...]
    """Every attempt, in order."""
    observations: int
    """Number of scene observations."""
    remaining: tuple[str, ...]
    """Objects that were left on the table, each with the reason."""
    stop_reason: str
    """Reason why clearing ended; ``clear`` when no object is left."""
    compute_ms: float = 0.0
    """Computing time of all observations and selections, ms."""

    @property
    def cleared(self) -> bool:
        """Whether no object is left on the table."""
        return self.stop_reason == CLEAR

    @property
    def ended_early(self) -> bool:
        """Whether clearing ended before the remaining objects were tried."""
        return any(line.endswith(NOT_TRIED) for line in self.remaining)

    @staticmethod
    def is_unreachable(reason: str) -> bool:
        """Return whether the reason of a remaining object is the reach of the arm."""
        return reason.startswith(UNREACHABLE)

    @property
    def placed(self) -> int:
        """Number of objects put into the tray."""
        return sum(map(bool, self.picks))
