"""Tables of `eyehand evaluate motion`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..bench import result_table
from .cycle_comparison import PAIRS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rich.table import Table


def reach_table(rows: Sequence[Mapping[str, Any]], title: str, time_limit: float) -> Table:
    """Return the table of success, contacts and times of each method."""
    return result_table(
        rows,
        [
            ("method", "{name}"),
            ("success", "{success_pct:.1f}"),
            ("95 %", "{success_low_pct:.0f}-{success_high_pct:.0f}"),
            ("contacts", "{contacts}"),
            ("stuck", "{stuck_pct:.1f}"),
            ("late", "{late_pct:.1f}"),
            ("clear mm", "{min_clearance_mm:.2f}"),
            ("time s", "{time_p50_s:.1f}"),
            ("90 %", "{time_p90_s:.1f}"),
            ("acc. %", "{peak_acceleration_pct:.0f}"),
            ("jerk %", "{peak_jerk_pct:.0f}"),
            ("cycle µs", "{cycle_p50_us:.0f}"),
            ("p99", "{cycle_p99_us:.0f}"),
            ("p99.9", "{cycle_p999_us:.0f}"),
            ("plan ms", "{plan_p50_ms:.0f}"),
            ("p90", "{plan_p90_ms:.0f}"),
        ],
        title=title,
        caption="success: goal reached to 1 mm without contact, %, with its 95 % interval; "
        "contacts: number of scenes with a contact; stuck: stopped or gave up, %; "
        f"late: not there after {time_limit:g} s, %; clear: smallest distance in all cycles; "
        "time: to the goal, median and 90th percentile, a failure counts as the time limit; acc., "
        "jerk: peaks in all cycles, start and stop included, % of the limits; cycle: time of a "
        "control cycle, median, 99th and 99.9th percentile; plan: time of a search for a "
        "path, median and 90th percentile",
    )


def cycle_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Return the table of single control cycles."""
    own = rows[0]["cycle_p50_us"]
    return result_table(
        [{**row, "ratio": row["cycle_p50_us"] / own} for row in rows],
        [
            ("method", "{name}"),
            ("cycle µs", "{cycle_p50_us:.0f}"),
            ("p99", "{cycle_p99_us:.0f}"),
            ("ratio", "{ratio:.2f}"),
        ],
        title=f"one cycle with {PAIRS} distance pairs",
        caption="the same postures and limits, timed in turns; ratio: to this package",
    )


def loop_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Return the table of calls in real time."""
    return result_table(
        rows,
        [
            ("method", "{name}"),
            ("calls", "{calls}"),
            ("searches", "{searches}"),
            ("step µs", "{step_p50_us:.0f}"),
            ("p99.9", "{step_p999_us:.0f}"),
            ("max", "{step_max_us:.0f}"),
            ("processor p99.9", "{processor_p999_us:.0f}"),
            ("max", "{processor_max_us:.0f}"),
        ],
        title="planned motions in real time at 1 kHz",
        caption="time of a call, searches in the background; processor: without waiting for other "
        "programs and threads",
    )


def moving_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Return the table of moving obstacles."""
    return result_table(
        rows,
        [
            ("solids", "{name}"),
            ("trials", "{trials}"),
            ("kept %", "{kept_pct:.1f}"),
            ("touched", "{touched}"),
            ("unnamed", "{unnamed}"),
            ("clear mm", "{min_clearance_mm:.2f}"),
            ("acc. %", "{peak_acceleration_pct:.0f}"),
        ],
        title="moving obstacles near the tool; the controller does not receive their velocity",
        caption="kept: at least 5 mm in every cycle; unnamed: trials below 5 mm without a "
        "status that says so; acc.: peak in % of the limit",
    )
