"""Run one method in one reaching scene, and record the result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.control import JointPath
from eyehand.data_synth.scenes import make_reaching_scene, straight_path_is_blocked

from ..bench.shares import wilson_interval
from .baseline_mink import TUNED, run_mink
from .baseline_ompl import OmplMethod
from .reach_methods import BASELINE_PLANNED, BASELINE_TUNED, BASELINES, controller_method
from .reach_outcome import ReachOptions, ReachOutcome, run_reach


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


def summary_row(
    method: str,
    records: Sequence[ReachRecord],
    cycles_us: NDArray[np.float64],
    time_limit: float,
) -> dict[str, Any]:
    """Summarise the scenes of a method.

    Parameters
    ----------
    method
        Name of the method.
    records
        Its scenes.
    cycles_us
        Times of its cycles, µs, measured while nothing else ran.
    time_limit
        Time after which a scene is given up, s. A failure counts as taking this long.

    Returns
    -------
    dict
        Success with its 95 % interval; `contacts`: number of scenes with a contact; `stuck_pct`:
        share of scenes in which the arm stopped or the method gave up; `late_pct`: share of scenes
        in which the time was up; smallest clearance; peak acceleration and jerk of all scenes as
        shares of the limits; time to the goal; cycle times; and with a planner the number of
        searches, how many found a path, and their times.
    """
    outcomes = [record.outcome for record in records]
    wins = sum(outcome.success for outcome in outcomes)
    low, high = wilson_interval(wins, len(outcomes))
    late = sum(outcome.status == "late" for outcome in outcomes)
    stuck = sum(outcome.status not in ("reached", "late") for outcome in outcomes)
    seconds = [outcome.seconds if outcome.success else time_limit for outcome in outcomes]
    row: dict[str, Any] = {
        "name": method,
        "success_pct": _pct(wins, len(outcomes)),
        "success_low_pct": round(100.0 * low, 1),
        "success_high_pct": round(100.0 * high, 1),
        "contacts": sum(outcome.contacts > 0 for outcome in outcomes),
        "stuck_pct": _pct(stuck, len(outcomes)),
        "late_pct": _pct(late, len(outcomes)),
        "min_clearance_mm": round(1e3 * min(o.min_clearance for o in outcomes), 2),
        "peak_acceleration_pct": _share(outcome.peak_acceleration for outcome in outcomes),
        "peak_jerk_pct": _share(outcome.peak_jerk for outcome in outcomes),
        "time_p50_s": round(float(np.percentile(seconds, 50)), 2),
        "time_p90_s": round(float(np.percentile(seconds, 90)), 2),
        "cycle_p50_us": _percentile(cycles_us, 50),
        "cycle_p99_us": _percentile(cycles_us, 99),
        "cycle_p999_us": _percentile(cycles_us, 99.9),
    }
    paths = [path for record in records for path in record.paths]
    if paths:
        times = [1e3 * path.seconds for path in paths]
        row["searches"] = len(paths)
        row["ways_found"] = sum(bool(path) for path in paths)
        row["plan_p50_ms"] = round(float(np.percentile(times, 50)), 1)
        row["plan_p90_ms"] = round(float(np.percentile(times, 90)), 1)
    return row


def _percentile(cycles_us: NDArray[np.float64], share: float) -> float:
    """Return a percentile, µs; 0 if a method gave up in the cycle of its searches."""
    return round(float(np.percentile(cycles_us, share)), 1) if len(cycles_us) else 0.0


def _share(peaks: Iterable[float]) -> float:
    return round(100.0 * max(peaks), 1)


def _pct(count: int, total: int) -> float:
    return round(100.0 * count / total, 1)
