"""The table of the clutter-removal protocol, with rows that others published or measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table

from ...console import wide_table
from .summary_table import NO_VALUE, rate_text, value_text

COLUMNS = (
    *("rounds", "grasps", "success", "declutter", "light success", "light declutter"),
    *("perceive", "plan"),
)
CAPTION = (
    "success: successful share of the grasps; declutter: removed share of the objects; both with "
    "95 % Wilson intervals. light: without objects that weigh more than 40 % of the friction of "
    "both pads. perceive, plan: median processor time on one thread. Rows of other methods were "
    "measured by others in the original protocol (PyBullet, other meshes and seeds): they are no "
    "comparison on equal scenes"
)
RATES = ("success", "declutter", "light_success", "light_declutter")
OUTSIDE = "outside evaluation in the original PyBullet protocol, one side view, 40 rounds"


def _published(
    name: str, family: str, noise: str, success: float, declutter: float, *, known: bool = False
) -> dict[str, Any]:
    return {
        "name": f"{name}: {family}, {'dex noise' if noise == 'dex' else 'no noise'}"
        + (", table known" if known else ""),
        "family": family,
        "noise": noise,
        "known_table": known,
        "success_pct": success,
        "declutter_pct": declutter,
        "measured_by": OUTSIDE,
    }


PUBLISHED: tuple[dict[str, Any], ...] = (
    _published("VGN", "packed", "dex", 69.9, 75.8),
    _published("VGN", "pile", "dex", 65.0, 48.1),
    _published("VGN", "packed", "none", 77.2, 79.5),
    _published("VGN", "pile", "none", 68.4, 44.8),
    _published("GIGA", "packed", "dex", 78.0, 83.3),
    _published("GIGA", "pile", "dex", 70.3, 54.0),
    _published("GIGA", "packed", "none", 87.5, 84.8),
    _published("GIGA", "pile", "none", 73.2, 51.7),
    _published("GIGA", "packed", "dex", 92.2, 92.2, known=True),
    _published("GIGA", "pile", "dex", 78.0, 52.0, known=True),
)
"""Results of the published weights of VGN and GIGA, run by others."""


def protocol_table(rows: Sequence[Mapping[str, Any]], title: str) -> Table:
    """Return the table of the measured rows, and of others' rows of the same families."""
    table = wide_table(title, ("row", *COLUMNS), left=("row",), caption=CAPTION)
    for row in rows:
        table.add_row(*_cells(row))
    table.add_section()
    shown = {(row["family"], row["noise"]) for row in rows}
    for row in PUBLISHED:
        if (row["family"], row["noise"]) in shown:
            rates = [f"{row['success_pct']:.1f} %", f"{row['declutter_pct']:.1f} %"]
            table.add_row(row["name"], NO_VALUE, NO_VALUE, *rates, *[NO_VALUE] * 4)
    return table


def calibration_table(bins: Sequence[Mapping[str, Any]]) -> Table:
    """Return the table of predicted and observed success, over the attempts of all rows."""
    headings = ("bin", "grasps", "predicted", "observed", "error")
    table = wide_table("predicted success against the observed one, all rows", headings)
    for one in bins:
        error = one["observed_pct"] - one["predicted_pct"]
        table.add_row(
            f"{one['low_pct']:.0f}-{one['high_pct']:.0f} %",
            f"{one['attempts']}",
            f"{one['predicted_pct']:.1f} %",
            f"{one['observed_pct']:.1f} %",
            f"{error:+.1f}",
        )
    return table


def failure_line(row: Mapping[str, Any]) -> str:
    """Return the failures of a row by their causes, for the report."""
    causes = [row["causes_text"]]
    if row["nothing_offered"]:
        causes.append(f"{row['nothing_offered']} rounds ended without an offer")
    if row["heavy_objects"]:
        names = [f"{count} x {name}" for name, count in row["heavy_objects"].items()]
        causes.append(f"too heavy to hold: {', '.join(names)}")
    return f"{row['name']}: failures: {'; '.join(causes)}"


def _cells(row: Mapping[str, Any]) -> list[str]:
    return [
        row["name"],
        f"{row['rounds']}",
        f"{row['attempts']}",
        *[rate_text(row, f"{name}_") for name in RATES],
        value_text(row["perceive_ms"], 0, "ms"),
        value_text(row["plan_ms"], 0, "ms"),
    ]
