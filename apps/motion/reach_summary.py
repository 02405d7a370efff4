"""Summarise the reaching scenes of a method in one row."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench.shares import wilson_interval

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from .reach_run import ReachRecord


def summary_row(
    method: str, records: Sequence[ReachRecord], cycles_us: NDArray[np.float64]
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

    Returns
    -------
    dict
        Success with its 95 % interval; `contacts`: number of scenes with a contact; `stuck_pct`:
        share of scenes in which the arm stopped or the method gave up; `late_pct`: share of scenes
        in which the time was up; smallest clearance; peak acceleration and jerk of all scenes as
        shares of the limits; time to the goal, where a failure counts as the longest time of all
        scenes; cycle times; and with a planner the number of
        searches, how many found a path, and their times.
    """
    outcomes = [record.outcome for record in records]
    wins = sum(outcome.success for outcome in outcomes)
    low, high = wilson_interval(wins, len(outcomes))
    late = sum(outcome.status == "late" for outcome in outcomes)
    stuck = sum(outcome.status not in ("reached", "late") for outcome in outcomes)
    # A scene that is not reached counts as taking for ever, up to the longest time of the run.
    longest = max(outcome.seconds for outcome in outcomes)
    seconds = [outcome.seconds if outcome.success else longest for outcome in outcomes]
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
