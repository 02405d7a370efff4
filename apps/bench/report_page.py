"""HTML reports: one page that contains its style, tables and pictures."""

from __future__ import annotations

import base64
from collections.abc import Collection, Iterable, Sequence
from html import escape
from pathlib import Path

STYLE_SHEET = Path(__file__).with_suffix(".css")


def html_page(title: str, parts: Iterable[str]) -> str:
    """Return a page with a title in plain text and the HTML parts of its body."""
    style = STYLE_SHEET.read_text(encoding="utf-8")
    return "\n".join(
        [
            '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            # Without an icon in the page, a browser requests one from the network.
            '<link rel="icon" href="data:,">',
            f"<title>{escape(title)}</title><style>{style}</style></head><body><main>",
            *parts,
            "</main></body></html>\n",
        ]
    )


def html_table(
    head: Sequence[str], rows: Iterable[Sequence[str]], numbers: Collection[int] = ()
) -> str:
    """Return a table.

    Parameters
    ----------
    head
        Column headings, plain text.
    rows
        Cells of each row, HTML.
    numbers
        Indices of the columns that are aligned to the right.
    """

    def line(tag: str, cells: Sequence[str]) -> str:
        sides = [' class="n"' if column in numbers else "" for column in range(len(head))]
        made = (f"<{tag}{side}>{cell}</{tag}>" for side, cell in zip(sides, cells, strict=True))
        return f"<tr>{''.join(made)}</tr>"

    body = "".join(line("td", row) for row in rows)
    top = line("th", [escape(name) for name in head])
    return f"<table><thead>{top}</thead><tbody>{body}</tbody></table>"


def data_url(content: bytes, media_type: str) -> str:
    """Return a file as a data URL, which embeds it in the page."""
    return f"data:{media_type};base64,{base64.b64encode(content).decode('ascii')}"
