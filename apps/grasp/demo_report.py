"""The report of the demo: one HTML file with every capture, grasp and contact force."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np

from ..bench.report_page import data_url, html_page, html_table
from ..console import counted, plural
from ..output_files import write_text
from .capture_cards import capture_card, final_capture_card, object_cell, outcome_pill
from .demo_record import Capture, DemoRecord
from .demo_table import task_words
from .score_terms import SIZE_NOTE, score_legend

EMBEDDED_BYTES = 12_000_000
"""Maximum size of an embedded video, bytes. A larger one stays a file beside the page, because
browsers are slow with long data URLs."""


def write_report(path: Path, record: DemoRecord) -> None:
    """Write the page atomically.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    """
    write_text(path, report_html(record))


def report_html(record: DemoRecord) -> str:
    """Return the page, with its pictures and its video embedded."""
    cards = []
    for number, capture in enumerate(record.captures, start=1):
        card = capture_card if capture.pick is not None else final_capture_card
        cards.append(card(number, capture, record))
    parts = [_header(record), _tiles(record), _video(record), _summary(record), *cards]
    return html_page(f"eyehand demo: {record.source}", parts)


def _header(record: DemoRecord) -> str:
    placed, total = record.result.placed, record.result.total
    title = (
        "Table cleared" if placed == total else f"{placed} of {counted(total, 'object')} put away"
    )
    # A failed pick can still end in the tray. The headline must not hide what the rows say.
    failed = sum(not row.success for row in record.result.picks)
    if placed == total and failed:
        title += f", {failed} of {counted(len(record.result.picks), 'pick')} failed"
    return (
        f"<h1>{title}</h1>"
        f'<p class="faint">{escape(record.source)}. A simulated robot perceives unknown objects in '
        "noisy depth images, grasps them, and puts them into a tray.</p>"
    )


def _tiles(record: DemoRecord) -> str:
    picks, result = record.report.picks, record.result
    tiles = [
        (f"{result.placed} of {result.total}", f"{plural(result.total, 'object')} in the tray")
    ]
    if picks:
        good = sum(row.success for row in result.picks)
        tiles += [
            (f"{good} of {len(picks)}", f"{plural(len(picks), 'pick')} that succeeded"),
            (f"{np.median([pick.perceive_ms for pick in picks]):.0f} ms", "to perceive an image"),
            (f"{np.median([pick.plan_ms for pick in picks]):.0f} ms", "to select and plan"),
            (f"{np.mean([pick.seconds for pick in picks]):.1f} s", "simulated time per pick"),
        ]
    tiles.append((f"{result.cpu_seconds:.1f} s", "processor time, robot and simulation"))
    if record.film_cpu_seconds is not None:
        tiles.append((f"{record.film_cpu_seconds:.0f} s", "processor time, film"))
    tiles_html = "".join(f'<div class="tile"><b>{a}</b><span>{b}</span></div>' for a, b in tiles)
    return f'<div class="tiles">{tiles_html}</div>'


def _video(record: DemoRecord) -> str:
    film = record.film
    if film is None or not film.is_file():
        return ""
    source = escape(film.name, quote=True)
    if film.stat().st_size <= EMBEDDED_BYTES:
        source = data_url(film.read_bytes(), "video/mp4")
    return (
        '<div class="card"><video controls muted loop playsinline preload="metadata" '
        'aria-label="film of the picks" '
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
    head = [
        "pick",
        "object",
        "outcome",
        "grasp",
        "task rows",
        "perceive ms",
        "plan ms",
        "simulated s",
    ]
    # Explain sizes and scores once for all cards.
    terms = {term for pick in record.report.picks for term in pick.plan.score.terms}
    return (
        '<div class="card wide" tabindex="0" role="region" aria-label="table of the picks">'
        f"{html_table(head, rows, numbers=(5, 6, 7))}"
        f'<p class="legend">{SIZE_NOTE}</p><p class="legend">{score_legend(terms)}</p></div>'
    )


def _row(number: int, capture: Capture) -> list[str]:
    pick = capture.pick
    assert pick is not None
    reason = f'<br><span class="faint">{escape(pick.reason)}</span>' if pick.reason else ""
    return [
        f'<a href="#capture{number}">{number}</a>',
        object_cell(capture),
        f"{outcome_pill(capture)}{reason}",
        escape(pick.plan.name),
        f'<b>{pick.plan.rows}</b> <span class="faint">{escape(task_words(pick.plan))}</span>',
        f"{pick.perceive_ms:.0f}",
        f"{pick.plan_ms:.0f}",
        f"{pick.seconds:.1f}",
    ]
