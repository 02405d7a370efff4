"""The table that `eyehand evaluate grasp` prints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table

from ...console import wide_table

NO_VALUE = "-"
"""Text of a missing value."""
NOTES = {"faults": "broke", "missing": "missing"}
"""Counts shown beside the number of scenes if they are not 0."""
CAPTION = (
    "picks: grasps begun (in brackets: with refused, unreachable, undetected objects and broken "
    "scenes); success: successful share of these; cleared: share of the objects in the tray; both "
    "with 95 % Wilson intervals. perceive, plan: medians per pick; "
    "picks/h: successful picks per hour with computing, failures and ways home; touched: contacts "
    "with table or neighbours by mistake before a grasp; pushed: neighbours touched / grasps that "
    "may push them aside, the last resort; moved: 90th percentile of the object's motion from "
    "its first contact to the hold; kept: share of the lifted objects that the hand did not "
    "lose; squeeze: median force on them over the least one by friction"
)


def grasp_table(rows: Sequence[Mapping[str, Any]], title: str) -> Table:
    """Return the table of the rows of :func:`summary_rows`."""
    headings = ("condition", *COLUMNS)
    caption = ". ".join([CAPTION, *filter(None, map(too_wide_note, rows))])
    table = wide_table(title, headings, left=("condition",), caption=caption)
    family = rows[0]["family"] if rows else ""
    for row in rows:
        if row["family"] != family:
            table.add_section()
            family = row["family"]
        table.add_row(row["name"], *table_cells(row))
    return table


def too_wide_note(row: Mapping[str, Any]) -> str:
    """Return the rates of a row without the objects that the gripper cannot hold, if any."""
    names = ", ".join(f"{count} x {name}" for name, count in row["too_wide"].items())
    if not names:
        return ""
    success, cleared = rate_text(row, "holdable_"), rate_text(row, "holdable_cleared_")
    return (
        f"{row['name']}: too wide for the gripper: {names}; without these success {success}, "
        f"cleared {cleared}"
    )


def table_cells(row: Mapping[str, Any]) -> list[str]:
    """Return the cells of a row, one per entry of COLUMNS."""
    notes = [f"{row[what]} {word}" for what, word in NOTES.items() if row[what]]
    all_picks = f" ({row['picks']})" if row["picks"] > row["attempts"] else ""
    return [
        f"{row['scenes']} ({', '.join(notes)})" if notes else f"{row['scenes']}",
        f"{row['attempts']}{all_picks}",
        rate_text(row),
        rate_text(row, "cleared_"),
        value_text(row["perceive_ms"], 0, "ms"),
        value_text(row["plan_ms"], 0, "ms"),
        NO_VALUE if row["picks_per_hour"] is None else f"{row['picks_per_hour']:.0f}",
        f"{row['touched_before']}",
        f"{row['touched_pushing']}/{row['pushing_picks']}" if row["pushing_picks"] else NO_VALUE,
        value_text(row["displacement_p90_mm"], 1, "mm"),
        NO_VALUE if row["kept_pct"] is None else f"{row['kept_pct']:.1f} % of {row['lifted']}",
        NO_VALUE if row["squeeze"] is None else f"{row['squeeze']:.1f}",
    ]


COLUMNS = (
    "scenes",
    "picks",
    "success",
    "cleared",
    "perceive",
    "plan",
    "picks/h",
    "touched",
    "pushed",
    "moved",
    "kept",
    "squeeze",
)
"""Columns after the name of the condition."""


def rate_text(row: Mapping[str, Any], prefix: str = "") -> str:
    """Return a rate with its interval: ``91.7 % (84-96)``."""
    share = row[f"{prefix}pct" if prefix else "success_pct"]
    if share is None:
        return NO_VALUE
    low, high = row[f"{prefix}ci_low_pct"], row[f"{prefix}ci_high_pct"]
    return f"{share:.1f} % ({low:.0f}-{high:.0f})"


def value_text(value: float | None, digits: int, unit: str) -> str:
    """Return a value with its unit; NO_VALUE for None."""
    return NO_VALUE if value is None else f"{value:.{digits}f} {unit}"
