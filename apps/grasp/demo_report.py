"""The report of the demo: one HTML file with every capture, grasp and contact force."""

from __future__ import annotations

import base64
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ..output_files import write_text
from ..wording import counted, plural
from .capture_cards import capture_card, final_capture_card, object_cell, outcome_pill
from .demo_report_style import STYLE
from .demo_table import task_words
from .score_terms import SIZE_NOTE, score_legend

if TYPE_CHECKING:
    from pathlib import Path

    from .demo_record import Capture, DemoRecord

EMBEDDED_BYTES = 12_000_000
"""A larger video stays a file beside the page: browsers are slow with such long addresses."""


def write_report(path: Path, record: DemoRecord) -> None:
    """Write the page at once or not at all.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    """
    write_text(path, report_html(record))


def report_html(record: DemoRecord) -> str:
    """Make the page's text, its pictures and its video inside it."""
    cards = []
    for number, capture in enumerate(record.captures, start=1):
        card = capture_card if capture.pick is not None else final_capture_card
        cards.append(card(number, capture, record))
    return "\n".join(
        [
            '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            # An icon of its own: browsers ask the network for one otherwise.
            '<link rel="icon" href="data:,">',
            f"<title>eyehand demo: {escape(record.source)}</title>",
            f"<style>{STYLE}</style></head><body><main>",
            _header(record),
            _tiles(record),
            _video(record),
            _summary(record),
            *cards,
            "</main></body></html>\n",
        ]
    )


def _header(record: DemoRecord) -> str:
    placed, total = record.result.placed, record.result.total
    title = (
        "Table cleared" if placed == total else f"{placed} of {counted(total, 'object')} put away"
    )
    return (
        f"<h1>{title}</h1>"
        f'<p class="faint">{escape(record.source)}. Unknown objects, one noisy depth view at a '
        "time: perceived, grasped and put into a tray by a simulated robot.</p>"
    )


def _tiles(record: DemoRecord) -> str:
    picks, result = record.report.picks, record.result
    tiles = [
        (f"{result.placed} of {result.total}", f"{plural(result.total, 'object')} in the tray")
    ]
    if picks:
        good = sum(row.success for row in result.picks)
        tiles += [
            (f"{good} of {len(picks)}", f"{plural(len(picks), 'pick')} that went well"),
            (f"{np.median([pick.perceive_ms for pick in picks]):.0f} ms", "to perceive a view"),
            (f"{np.median([pick.plan_ms for pick in picks]):.0f} ms", "to choose and plan"),
            (f"{np.mean([pick.seconds for pick in picks]):.1f} s", "simulated time per pick"),
        ]
    tiles.append((f"{result.cpu_seconds:.1f} s", "processor time, robot and simulation"))
    if record.film_cpu_seconds is not None:
        tiles.append((f"{record.film_cpu_seconds:.0f} s", "processor time, film"))
    made = "".join(f'<div class="tile"><b>{a}</b><span>{b}</span></div>' for a, b in tiles)
    return f'<div class="tiles">{made}</div>'


def _video(record: DemoRecord) -> str:
    film = record.film
    if film is None or not film.is_file():
        return ""
    source = escape(film.name, quote=True)
    if film.stat().st_size <= EMBEDDED_BYTES:
        source = f"data:video/mp4;base64,{base64.b64encode(film.read_bytes()).decode()}"
    return (
        '<div class="card"><video controls muted loop playsinline preload="metadata" '
        f'src="{source}"></video></div>'
    )


def _summary(record: DemoRecord) -> str:
    rows = [
        _row(number, capture)
        for number, capture in enumerate(record.captures, start=1)
        if capture.pick is not None
    ]
    if not rows:
        return ""
    return (
        '<div class="card wide"><table><thead><tr><th>pick</th><th>object</th><th>grasp</th>'
        '<th>task rows</th><th class="n">perceive ms</th><th class="n">plan ms</th>'
        '<th class="n">simulated s</th><th>outcome</th></tr></thead><tbody>'
        f"{''.join(rows)}</tbody></table>{_legend(record)}</div>"
    )


def _legend(record: DemoRecord) -> str:
    """Explain sizes and scores, once for all cards."""
    terms = {term for pick in record.report.picks for term in pick.plan.score.terms}
    return f'<p class="legend">{SIZE_NOTE}</p><p class="legend">{score_legend(terms)}</p>'


def _row(number: int, capture: Capture) -> str:
    pick = capture.pick
    assert pick is not None
    tasks = task_words(pick.plan)
    why = f'<br><span class="faint">{escape(pick.reason)}</span>' if pick.reason else ""
    return (
        f'<tr><td><a href="#capture{number}">{number}</a></td><td>{object_cell(capture)}</td>'
        f"<td>{escape(pick.plan.name)}</td>"
        f'<td><b>{pick.plan.rows}</b> <span class="faint">{escape(tasks)}</span></td>'
        f'<td class="n">{pick.perceive_ms:.0f}</td><td class="n">{pick.plan_ms:.0f}</td>'
        f'<td class="n">{pick.seconds:.1f}</td><td>{outcome_pill(capture)}{why}</td></tr>'
    )
