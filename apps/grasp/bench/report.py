"""`report.html` of an evaluation: one page with everything in it, to be sent or kept."""

from __future__ import annotations

import base64
from html import escape
from typing import TYPE_CHECKING, Any

from eyehand.apps.wording import counted

from ...output_files import write_text
from .summary import PLACED, outcome_counts, prototype_rows, worst_scenes
from .summary_table import COLUMNS, NO_VALUE, rate_text, table_cells

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from .summary import Record

MOST_WORST = 20
"""Scenes listed at most."""
GOOD, FAIR = "#009E73", "#E69F00"
"""Colours of picks that went well and of those that were not tried."""
BAD = ("#D55E00", "#CC79A7", "#0072B2", "#56B4E9", "#7F3C8D", "#A6761D", "#666666", "#22262B")
"""Of the others, the most frequent first."""
UNTRIED = "refused"
"""Outcome of what the hand was right to leave alone, or too careful about."""
OUTCOME_WORDS = {
    "placed": "in the tray",
    "refused": "no prototype is suitable",
    "unreachable": "no way to any grasp",
    "stuck": "the arm did not get there",
    "no_contact": "fingers met nothing",
    "empty_close": "closed on nothing",
    "slipped": "dropped while lifting",
    "lost": "dropped later",
    "moved_away": "not where it was seen",
    "place_failed": "could not be put down",
    "misplaced": "let go, and not in the tray",
    "fault": "robot or program stopped",
    "unseen": "on the table, not seen",
    "doubt": "a look left a doubt",
}
"""Outcomes in words."""
STYLE = """
:root{color-scheme:light}
*{box-sizing:border-box}
body{margin:0;background:#f4f5f7;color:#22262b;font:15px/1.5 system-ui,"Segoe UI",Roboto,sans-serif}
main{max-width:1080px;margin:0 auto;padding:36px 24px 60px}
h1{font-size:27px;line-height:1.25;margin:0 0 6px}
h2{font-size:18px;margin:0 0 4px}
p.about{color:#5b6470;margin:0 0 14px}
section{background:#fff;border:1px solid #e4e7eb;border-radius:10px;padding:22px 24px;margin:20px 0;
overflow-x:auto}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th{font-weight:600;color:#5b6470;font-size:13px;border-bottom:1.5px solid #c9ced6}
th,td{padding:7px 10px;text-align:right;white-space:nowrap}
th:first-child,td:first-child{text-align:left;padding-left:0}
td{border-bottom:1px solid #eef0f3}
tr:last-child td{border-bottom:0}
td.left,th.left{text-align:left;white-space:normal}
td b{font-weight:650}
td i{font-style:normal;color:#5b6470;font-size:13px}
code{font:12.5px ui-monospace,Menlo,Consolas,monospace;background:#f0f2f5;border-radius:5px;
padding:3px 6px;display:inline-block;user-select:all;white-space:normal}
img{max-width:100%;display:block;margin:0 auto}
svg{display:block;width:100%;height:22px;border-radius:4px}
.key{display:flex;flex-wrap:wrap;gap:6px 18px;margin:14px 0 0;padding:0;list-style:none;
font-size:13.5px;color:#414954}
.key span{display:inline-block;width:12px;height:12px;border-radius:3px;margin-right:6px;
vertical-align:-1px}
footer{color:#5b6470;font-size:13px}
"""


def write_report(
    path: Path,
    rows: Sequence[Mapping[str, Any]],
    records: Sequence[Record],
    picture: bytes,
    told: Sequence[str],
) -> None:
    """Write the page.

    Parameters
    ----------
    path
        File to write.
    rows
        Of :func:`summary_rows`.
    records
        What they sum up.
    picture
        PNG of the rates.
    told
        Lines for its foot: options, seed, machine.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    """
    image = base64.b64encode(picture).decode("ascii")
    scenes = sum(row["scenes"] for row in rows)
    picks = sum(row["picks"] for row in rows)
    parts = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width,initial-scale=1'>",
        f"<title>eyehand evaluate grasp</title><style>{STYLE}</style></head><body><main>",
        "<h1>Grasping unknown objects in simulation</h1>",
        f"<p class='about'>{counted(scenes, 'scene')}, {counted(picks, 'pick')}. "
        f"{_headline(rows)}</p>",
        _section(
            "Rates", "", f"<img alt='rates with intervals' src='data:image/png;base64,{image}'>"
        ),
        _section(
            "Figures",
            "Picks: grasps begun (with what was never tried: refused, unreachable, not seen, a "
            "look in doubt, a scene that broke). Success: successful ones of all these, with the "
            "95 % Wilson interval; cleared: "
            "objects in the tray. A scene ends when it is clear or after two failures in a row. "
            "Touched: contacts with table or neighbours before a grasp that were not meant; "
            "pushed: neighbours touched / grasps that may push them aside, the last resort.",
            _figures(rows),
        ),
        _section("How picks ended", "", _outcomes(records)),
        _section(
            "By prototype",
            "All conditions together; with known poses apart.",
            _prototypes(records),
        ),
        _section(
            "Worst scenes",
            "Each command shows its scene again with a film, or runs it where conditions are not "
            "those of the demo.",
            _worst(records),
        ),
        "<footer>" + "<br>".join(escape(line) for line in told) + "</footer>",
        "</main></body></html>\n",
    ]
    write_text(path, "\n".join(parts))


def _headline(rows: Sequence[Mapping[str, Any]]) -> str:
    told = [
        f"{escape(row['name'])}: {row['success_pct']:g} % of picks, "
        f"{row['cleared_pct']:g} % cleared"
        for row in rows
        if not row["known"] and row["success_pct"] is not None and row["cleared_pct"] is not None
    ]
    return "; ".join(told) + "." if told else ""


def _section(title: str, about: str, body: str) -> str:
    said = f"<p class='about'>{escape(about)}</p>" if about else ""
    return f"<section><h2>{escape(title)}</h2>{said}{body}</section>"


def _table(head: Sequence[str], lines: Sequence[Sequence[str]], left: Sequence[int] = ()) -> str:
    """Lay out cells of HTML; columns `left` begin at the left."""
    side = [" class='left'" if column in left else "" for column in range(len(head))]
    top = "".join(f"<th{s}>{escape(name)}</th>" for s, name in zip(side, head, strict=True))
    body = "".join(
        "<tr>"
        + "".join(f"<td{s}>{cell}</td>" for s, cell in zip(side, line, strict=True))
        + "</tr>"
        for line in lines
    )
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _figures(rows: Sequence[Mapping[str, Any]]) -> str:
    lines = [[escape(row["name"]), *map(_bold, table_cells(row))] for row in rows]
    return _table(["condition", *COLUMNS], lines)


def _bold(cell: str) -> str:
    """A rate in bold with its interval in grey; other cells as they are."""
    rate, bracket, interval = cell.partition(" (")
    return f"<b>{escape(rate)}</b> <i>({escape(interval)}</i>" if bracket else escape(cell)


def _outcomes(records: Sequence[Record]) -> str:
    counts = outcome_counts(records)
    together = sum(counts.values(), start=type(next(iter(counts.values())))())
    others = [name for name, _ in together.most_common() if name not in (PLACED, UNTRIED)]
    colours = {PLACED: GOOD, UNTRIED: FAIR}
    colours |= {name: BAD[min(place, len(BAD) - 1)] for place, name in enumerate(others)}
    shown = [name for name in colours if together[name]]
    lines = [
        [escape(row), _bar([(own[name], colours[name], name) for name in shown])]
        + [str(own[name]) if own[name] else NO_VALUE for name in shown]
        for row, own in counts.items()
    ]
    key = "".join(
        f"<li><span style='background:{colours[name]}'></span>{escape(name)}: "
        f"{escape(OUTCOME_WORDS.get(name, name))}</li>"
        for name in shown
    )
    table = _table(["condition", "", *(name.replace("_", " ") for name in shown)], lines)
    return f"{table}<ul class='key'>{key}</ul>"


def _bar(parts: Sequence[tuple[int, str, str]]) -> str:
    total = sum(count for count, _, _ in parts) or 1
    pieces, begin = [], 0.0
    for count, colour, name in parts:
        wide = 100 * count / total
        if count:
            pieces.append(
                f"<rect x='{begin:.3f}' y='0' width='{wide:.3f}' height='10' fill='{colour}'>"
                f"<title>{escape(name)}: {count}</title></rect>"
            )
        begin += wide
    bars = "".join(pieces)
    return (
        "<div style='min-width:180px'><svg viewBox='0 0 100 10' preserveAspectRatio='none' "
        f"role='img'>{bars}</svg></div>"
    )


def _prototypes(records: Sequence[Record]) -> str:
    rows = prototype_rows(records)
    if not rows:
        return "<p class='about'>No pick chose one.</p>"
    lines = [[escape(row["name"]), str(row["picks"]), _bold(rate_text(row))] for row in rows]
    return _table(["prototype", "picks", "success"], lines)


def _worst(records: Sequence[Record]) -> str:
    worst = worst_scenes(records, MOST_WORST)
    if not worst:
        return "<p class='about'>Every scene was cleared without a failed pick.</p>"
    lines = [
        [
            escape(scene["name"]),
            str(scene["seed"]),
            f"{scene['placed']}/{scene['objects']}",
            str(scene["failed"]),
            f"{escape(scene['why'])}<br><code>{escape(scene['command'])}</code>",
        ]
        for scene in worst
    ]
    return _table(["condition", "seed", "placed", "failed", "first failure"], lines, left=(0, 4))
