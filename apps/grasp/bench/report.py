"""`report.html` of an evaluation: one page with the chart, all tables and the worst scenes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from eyehand.apps.console import counted

from ...bench.chart_style import BLUE, GREEN, INK, ORANGE, PURPLE, SKY, VERMILION
from ...bench.report_page import data_url, html_page, html_table
from ...output_files import write_text
from .summary import PLACED, Record, outcome_counts, prototype_rows, worst_scenes
from .summary_table import CAPTION, COLUMNS, NO_VALUE, rate_text, table_cells
from .unattempted import REFUSED

MAX_WORST = 20
"""Maximum number of listed scenes."""
FAILURE_COLOURS = (VERMILION, PURPLE, BLUE, SKY, "#7F3C8D", "#A6761D", "#666666", INK)
"""Colours of the failures, the most frequent first. Success is green, a refusal is orange."""
OUTCOME_MEANINGS = {
    "placed": "in the tray",
    "refused": "no prototype is suitable",
    "too_wide": "wider than the gripper opens, in all directions",
    "unreachable": "the arm reaches no grasp",
    "stuck": "the arm did not reach its goal in time",
    "no_contact": "the fingers touched nothing",
    "empty_close": "the hand closed without an object",
    "hand_stalled": "the hand did not follow its command",
    "touch_lost": "the hand's sense of touch failed",
    "slipped": "slipped out during the lift",
    "lost": "slipped out after the lift",
    "moved_away": "no longer where it was perceived",
    "place_failed": "could not be put into the tray",
    "wrong_object": "another object was picked",
    "misplaced": "reported as placed, but not in the tray",
    "fault": "robot or program stopped",
    "unseen": "on the table, but not perceived",
    "doubt": "the scene stayed ambiguous",
}
"""Meaning of each outcome."""


def write_report(
    path: Path,
    rows: Sequence[Mapping[str, Any]],
    records: Sequence[Record],
    chart: bytes,
    footer: Sequence[str],
) -> None:
    """Write the page.

    Parameters
    ----------
    path
        File to write.
    rows
        Rows of :func:`summary_rows`.
    records
        The records that the rows summarise.
    chart
        PNG of the rates.
    footer
        Lines of the footer: options, seed, machine.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    """
    scenes, picks = (sum(row[key] for row in rows) for key in ("scenes", "picks"))
    image = f'<img class="chart" alt="rates with intervals" src="{data_url(chart, "image/png")}">'
    figures = [[escape(row["name"]), *map(_rate_cell, table_cells(row))] for row in rows]
    parts = [
        "<h1>Grasping unknown objects in simulation</h1>",
        f'<p class="about">{counted(scenes, "scene")}, {counted(picks, "pick")}. '
        f"{_headline(rows)}</p>",
        _section("Rates", image),
        _section(
            "Figures",
            html_table(["condition", *COLUMNS], figures, range(1, 1 + len(COLUMNS))),
            f"{CAPTION}. A scene ends when it is clear or after two failures in a row.",
        ),
        _section("Outcomes of the picks", _outcomes(records)),
        _section(
            "By prototype", _prototypes(records), "Over all conditions; known poses separately."
        ),
        _section(
            "Worst scenes",
            _worst(records),
            "Each command repeats its scene with a film, or in an evaluation if the conditions "
            "differ from those of the demo.",
        ),
        f"<footer>{'<br>'.join(map(escape, footer))}</footer>",
    ]
    write_text(path, html_page("eyehand evaluate grasp", parts))


def _headline(rows: Sequence[Mapping[str, Any]]) -> str:
    rates = [
        f"{escape(row['name'])}: {row['success_pct']:g} % of picks, "
        f"{row['cleared_pct']:g} % cleared"
        for row in rows
        if not row["known"] and row["success_pct"] is not None and row["cleared_pct"] is not None
    ]
    return "; ".join(rates) + "." if rates else ""


def _section(title: str, body: str, note: str = "") -> str:
    about = f'<p class="about">{escape(note)}</p>' if note else ""
    label = escape(title, quote=True)
    return (
        f'<section class="card wide" tabindex="0" aria-label="{label}"><h2>{escape(title)}</h2>'
        f"{about}{body}</section>"
    )


def _rate_cell(text: str) -> str:
    """Return the cell of a rate, bold with its interval in grey, or of another text."""
    rate, bracket, interval = text.partition(" (")
    return f"<b>{escape(rate)}</b> <i>({escape(interval)}</i>" if bracket else escape(text)


def _outcomes(records: Sequence[Record]) -> str:
    counts = outcome_counts(records)
    total = sum(counts.values(), start=Counter())
    failures = [name for name, _ in total.most_common() if name not in (PLACED, REFUSED)]
    colours = {PLACED: GREEN, REFUSED: ORANGE}
    colours |= {
        name: FAILURE_COLOURS[min(index, len(FAILURE_COLOURS) - 1)]
        for index, name in enumerate(failures)
    }
    shown = [name for name in colours if total[name]]
    rows = [
        [escape(condition), _bar([(own[name], colours[name], name) for name in shown])]
        + [str(own[name] or NO_VALUE) for name in shown]
        for condition, own in counts.items()
    ]
    key = "".join(
        f'<li><span class="swatch" style="background:{colours[name]}"></span>{escape(name)}: '
        f"{escape(OUTCOME_MEANINGS.get(name, name))}</li>"
        for name in shown
    )
    head = ["condition", "", *(name.replace("_", " ") for name in shown)]
    return f'{html_table(head, rows, range(2, len(head)))}<ul class="swatches">{key}</ul>'


def _bar(parts: Sequence[tuple[int, str, str]]) -> str:
    """Return a stacked bar of counts, each with its colour and name."""
    total = sum(count for count, _, _ in parts) or 1
    pieces, start = [], 0.0
    for count, colour, name in parts:
        width = 100 * count / total
        if count:
            pieces.append(
                f'<rect x="{start:.3f}" y="0" width="{width:.3f}" height="10" fill="{colour}">'
                f"<title>{escape(name)}: {count}</title></rect>"
            )
        start += width
    return (
        '<svg class="bar" viewBox="0 0 100 10" preserveAspectRatio="none" role="img" '
        'aria-label="shares of the outcomes">'
        f"{''.join(pieces)}</svg>"
    )


def _prototypes(records: Sequence[Record]) -> str:
    rows = [
        [escape(row["name"]), str(row["picks"]), _rate_cell(rate_text(row))]
        for row in prototype_rows(records)
    ]
    if not rows:
        return '<p class="about">No pick selected a prototype.</p>'
    return html_table(["prototype", "picks", "success"], rows, numbers=(1, 2))


def _worst(records: Sequence[Record]) -> str:
    rows = [
        [
            escape(scene["name"]),
            str(scene["seed"]),
            f"{scene['placed']}/{scene['objects']}",
            str(scene["failed"]),
            f"{escape(scene['why'])}<br><code>{escape(scene['command'])}</code>",
        ]
        for scene in worst_scenes(records, MAX_WORST)
    ]
    if not rows:
        return '<p class="about">Every scene was cleared without a failed pick.</p>'
    head = ["condition", "seed", "placed", "failed", "first failure"]
    return html_table(head, rows, numbers=(1, 2, 3))
