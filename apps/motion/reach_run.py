"""One reaching scene run by one method: the judgement, and what the method has to say about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.data_synth.scenes import make_reaching_scene, straight_path_is_blocked

from .baseline_mink import run_mink
from .reach_methods import BASELINE, own_method
from .reach_outcome import run_reach

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import JointPath
    from eyehand.data_synth.scenes import ReachingScene

    from .reach_outcome import ReachOptions, ReachOutcome


@dataclass(frozen=True)
class ReachRecord:
    """What came of one scene with one method."""

    method: str
    seed: int
    """Of the scene."""
    way_blocked: bool
    """Whether a box stands in the tool's straight way."""
    outcome: ReachOutcome
    """The judgement."""
    reason: str
    """Why the method did not go on, in its own words; empty when it did, or says nothing."""
    paths: tuple[JointPath, ...] = ()
    """What its searches for a way gave."""

    @property
    def cycle_times_us(self) -> NDArray[np.float64]:
        """What each cycle took, searches left out (cycles,), µs."""
        times = self.outcome.cycle_times_us
        if not self.paths:
            return times
        # A search sits in the cycle that asked for it, and dwarfs all others.
        searching = np.argsort(times)[-len(self.paths) :]
        return np.delete(times, searching)

    def row(self) -> dict[str, Any]:
        """The record as a row of a table."""
        outcome = self.outcome
        return {
            "method": self.method,
            "seed": self.seed,
            "way_blocked": int(self.way_blocked),
            "success": int(outcome.success),
            "status": outcome.status,
            "contact_cycles": int(outcome.contacts),
            "min_clearance_mm": round(1e3 * outcome.min_clearance, 3),
            "seconds": round(outcome.seconds, 4),
            "final_error_mm": round(1e3 * outcome.final_error, 3),
            "reason": self.reason,
            "searches": len(self.paths),
            "found": sum(bool(path) for path in self.paths),
            "plan_ms": " ".join(f"{1e3 * path.seconds:.1f}" for path in self.paths),
            "rollouts": sum(path.rollouts for path in self.paths),
        }


def run_scene(method: str, seed: int, boxes: int, reach: ReachOptions | None = None) -> ReachRecord:
    """Draw the scene of a seed and run a method in it; given the same, the same motion.

    Searches for a way have a limit in time: a slow machine may miss one that a fast one finds.
    """
    scene = make_reaching_scene(seed, boxes=boxes)
    return run_method(method, scene, reach)


def run_method(method: str, scene: ReachingScene, reach: ReachOptions | None = None) -> ReachRecord:
    """Run a method in a scene."""
    blocked = straight_path_is_blocked(scene)
    if method == BASELINE:
        return ReachRecord(method, scene.seed, blocked, run_mink(scene, None, reach), "")
    own = own_method(method, scene)
    outcome = run_reach(scene, own, reach)
    return ReachRecord(method, scene.seed, blocked, outcome, own.reason, own.paths)
