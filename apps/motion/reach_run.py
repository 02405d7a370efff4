"""Run one method in one reaching scene, and record the result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.data_synth.scenes import make_reaching_scene, straight_path_is_blocked

from .baseline_mink import TUNED, run_mink
from .baseline_ompl import OmplMethod
from .reach_methods import BASELINE_PLANNED, BASELINE_TUNED, BASELINES, controller_method
from .reach_outcome import ReachOptions, run_reach

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import JointPath

    from .reach_outcome import ReachOutcome


@dataclass(frozen=True)
class ReachRecord:
    """The result of one method in one scene."""

    method: str
    seed: int
    """Seed of the scene."""
    path_blocked: bool
    """Whether a box blocks the straight path of the tool."""
    outcome: ReachOutcome
    """The result of the reach."""
    reason: str
    """Why the method stopped, as reported by the method; empty if it reports nothing."""
    paths: tuple[JointPath, ...] = ()
    """Results of the planner's searches."""

    @property
    def cycle_times_us(self) -> NDArray[np.float64]:
        """Time of each cycle without searches (cycles,), µs."""
        times = self.outcome.cycle_times_us
        if not self.paths:
            return times
        # The slowest cycles are those that include a search.
        searching = np.argsort(times)[-len(self.paths) :]
        return np.delete(times, searching)

    def row(self) -> dict[str, Any]:
        """Return the row of scenes.csv."""
        outcome = self.outcome
        return {
            "method": self.method,
            "seed": self.seed,
            "way_blocked": int(self.path_blocked),
            "success": int(outcome.success),
            "status": outcome.status,
            "contact_cycles": int(outcome.contacts),
            "min_clearance_mm": round(1e3 * outcome.min_clearance, 3),
            "seconds": round(outcome.seconds, 4),
            "peak_acceleration_pct": round(100 * outcome.peak_acceleration, 2),
            "peak_jerk_pct": round(100 * outcome.peak_jerk, 2),
            "final_error_mm": round(1e3 * outcome.final_error, 3),
            "reason": self.reason,
            "searches": len(self.paths),
            "found": sum(bool(path) for path in self.paths),
            "plan_ms": " ".join(f"{1e3 * path.seconds:.1f}" for path in self.paths),
            "rollouts": sum(path.rollouts for path in self.paths),
        }


def run_scene(method: str, seed: int, boxes: int, reach: ReachOptions | None = None) -> ReachRecord:
    """Make the scene of a seed and run a method in it.

    Equal arguments give an equal motion, except of OMPL, whose searches end by a time limit.
    """
    reach = reach or ReachOptions()
    scene = make_reaching_scene(seed, boxes=boxes, place=reach.place, arm=reach.arm)
    blocked = straight_path_is_blocked(scene)
    if method == BASELINE_PLANNED:
        planned = OmplMethod(scene, reach.goal, reach.dt)
        outcome = run_reach(scene, planned, reach)
        return ReachRecord(method, seed, blocked, outcome, planned.reason, planned.paths)
    if method in BASELINES:
        options = TUNED if method == BASELINE_TUNED else None
        return ReachRecord(method, seed, blocked, run_mink(scene, options, reach), "")
    controller = controller_method(method, scene, reach.goal)
    outcome = run_reach(scene, controller, reach)
    return ReachRecord(method, seed, blocked, outcome, controller.reason, controller.paths)
