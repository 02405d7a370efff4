"""Terminal output, and counts in words.

Messages go to stderr. `--json` prints one JSON object on stdout.
"""

from __future__ import annotations

import json
import sys
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rich.console import Console
    from rich.table import Table

LINE_S = 20.0
"""Time between two lines of progress without a terminal, s."""


def stderr_console() -> Console:
    """Return the console for progress bars."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


def say(message: str) -> None:
    """Print one line on stderr."""
    print(message, file=sys.stderr, flush=True)


def print_text(text: str) -> None:
    """Print text on stdout."""
    print(text, flush=True)


def show(table: Table, *, json_wanted: bool) -> None:
    """Print a table on stdout, or on stderr if stdout is reserved for JSON."""
    from rich.console import Console

    console = Console(stderr=json_wanted, highlight=False)
    if not console.is_terminal:
        console = Console(stderr=json_wanted, highlight=False, width=140)
    console.print(table)


def print_json(
    command: str,
    seed: int | None,
    rows: Iterable[Mapping[str, Any]],
    *,
    schema_version: int = 1,
    **more: Any,
) -> None:
    """Print ``{"schema": "eyehand.<command>/<version>", "seed": …, "rows": […], …}`` on stdout.

    A command whose report loses a member gets the next version of its schema.
    """
    print(json_text(command, seed, rows, schema_version=schema_version, **more), flush=True)


def json_text(
    command: str,
    seed: int | None,
    rows: Iterable[Mapping[str, Any]],
    *,
    schema_version: int = 1,
    **more: Any,
) -> str:
    """Return the JSON object that `print_json` prints."""
    schema = f"eyehand.{command}/{schema_version}"
    report = {"schema": schema, "seed": seed, "rows": list(rows), **more}
    return json.dumps(report, allow_nan=False)


def tracked(items: Iterable[Any], what: str, total: int | None = None) -> Iterator[Any]:
    """Iterate with a progress bar on stderr, or with a line every `LINE_S` without a terminal."""
    from rich.progress import track

    console = stderr_console()
    if console.is_terminal:
        yield from track(items, description=what, total=total, console=console, transient=True)
        return
    said = time.monotonic()
    for done, item in enumerate(items, 1):
        yield item
        if time.monotonic() - said > LINE_S:
            say(f"{what}: {done}" + (f" of {total}" if total else ""))
            said = time.monotonic()


def wide_table(
    title: str, headings: Iterable[str], *, left: Iterable[str] = (), caption: str | None = None
) -> Table:
    """Return an empty table with narrow gaps; the columns in `left` are aligned to the left."""
    from rich import box
    from rich.table import Table

    table = Table(
        title=title,
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        pad_edge=False,
        caption=caption,
        caption_justify="left",
    )
    for heading in headings:
        table.add_column(heading, justify="left" if heading in left else "right", no_wrap=True)
    return table


def counted(count: int, noun: str) -> str:
    """Return a count with its noun: ``1 scene``, ``2 scenes``."""
    return f"{count} {plural(count, noun)}"


def plural(count: int, noun: str) -> str:
    """Return a noun in singular or plural. The plural must end in a plain s."""
    return noun if count == 1 else f"{noun}s"


def seed_span(first: int, count: int) -> str:
    """Return the words for consecutive seeds: ``seed 3``, ``seeds 3 to 7``."""
    return f"seed {first}" if count == 1 else f"seeds {first} to {first + count - 1}"
