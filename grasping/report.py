"""What happened in picking: phase by phase, object by object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.tactile import ContactFeatures

    from .plan import GraspPlan

Phase = Literal[
    "look", "choose", "pre-grasp", "approach", "contact", "close", "grip", "lift", "check", "place"
]
"""Phases of a pick, in their order."""

PickOutcome = Literal[
    "placed",
    "refused",
    "unreachable",
    "stuck",
    "no_contact",
    "empty_close",
    "slipped",
    "lost",
    "moved_away",
    "place_failed",
    "fault",
]
"""placed: in the tray; refused: no prototype suits; unreachable: no way to any grasp was found;
stuck: the arm did not get there in time; no_contact: fingers met nothing where it was;
empty_close: fingers closed on nothing; slipped: dropped while lifting; lost: dropped later;
moved_away: not where it was seen; place_failed: could not be put down in the tray; fault: the robot
stopped by itself."""


@dataclass(frozen=True)
class PhaseRecord:
    """One phase of one pick."""

    phase: Phase
    """Which."""
    start: float
    """Robot time at its start, s."""
    end: float
    """Robot time at its end, s."""
    outcome: str
    """How it ended: ``done``, or what went wrong, in a few words."""


@dataclass(frozen=True)
class PickReport:
    """One try to pick one object."""

    label: int
    """Label of the object in the scene it was seen in."""
    kind: str
    """Solid it was taken for."""
    plan: GraspPlan
    """Grasp tried, or the refusal."""
    outcome: PickOutcome
    """How it ended."""
    reason: str
    """Why, for people."""
    phases: tuple[PhaseRecord, ...]
    """What was done, in order."""
    perceive_ms: float
    """Time from depth image to solids, for the scene."""
    plan_ms: float
    """Time to choose the grasp and check its way."""
    times: NDArray[np.float64]
    """Robot times at which forces were read, (T,), s."""
    forces: NDArray[np.float64]
    """Force on each finger, the thumb last, then the palm, (T, F + 1), N."""
    wrapped: tuple[int, float]
    """Pads in contact, palm included, when held, and the mean curl of the fingers, rad."""
    tips: tuple[ContactFeatures, ...] = ()
    """What each fingertip felt when held, the thumb last."""

    def __bool__(self) -> bool:
        return self.outcome == "placed"

    @property
    def seconds(self) -> float:
        """Robot time from choice to end, s."""
        return self.phases[-1].end - self.phases[0].start if self.phases else 0.0


@dataclass(frozen=True)
class ClearReport:
    """A table cleared, or what is left on it and why."""

    picks: tuple[PickReport, ...]
    """Every try, in order."""
    looks: int
    """Depth images taken."""
    left: tuple[str, ...]
    """What was left alone, and why."""
    stopped: str
    """Why it ended: ``clear``, or what else."""

    @property
    def placed(self) -> int:
        """Objects put into the tray."""
        return sum(map(bool, self.picks))
