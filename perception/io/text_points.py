"""Points as text: XYZ files, and tables with commas, semicolons or tabs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .point_table import load_numbers

COMMENTS = ("#", "//")
"""Prefixes of comment lines."""

AXES = ("x", "y", "z")
"""Columns that a header line must name."""

FIRST_COLUMNS = [0, 1, 2]
"""Columns of x, y, z in a file without a header line."""


def parse_text_points(data: bytes) -> NDArray[np.float64]:
    """Parse a text table with one point per line, (N, 3) float64. Further columns are skipped.

    Numbers are separated by white space, commas or semicolons. A first line of words names the
    columns, x, y and z among them.

    Raises
    ------
    InputError
        If the data are not text, hold no point, use decimal commas, or a line lacks a number.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"not a text file (byte {error.start}), expected x y z a line") from error
    lines = [line for line in map(str.strip, text.splitlines()) if line]
    lines = [line for line in lines if not line.startswith(COMMENTS)]
    if not lines:
        raise InputError("holds no points, expected x y z a line")
    if ";" in lines[-1] and "," in lines[-1]:
        raise InputError(f"holds decimal commas ({lines[-1][:40]!r}), expected decimal points")
    rows = [line.replace(",", " ").replace(";", " ") for line in lines]
    columns = FIRST_COLUMNS
    if not _is_number(rows[0].split()[:1]):
        columns = _named_columns(rows[0])
        rows = rows[1:]
    if not rows:
        raise InputError("holds a header and no points, expected x y z a line")
    return load_numbers("\n".join(rows), columns)


def points_text(points: NDArray[np.floating], colours: NDArray[np.uint8] | None) -> str:
    """Format lines `x y z` or `x y z r g b`, with the shortest numbers that read back exactly."""
    rows = points.tolist()
    if colours is not None:
        rows = [row + colour for row, colour in zip(rows, colours.tolist(), strict=True)]
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows)


def _named_columns(header: str) -> list[int]:
    names = [name.strip("\"'").lower() for name in header.split()]
    if any(names.count(axis) != 1 for axis in AXES):
        raise InputError(f"first line is {header[:60]!r}, expected numbers or the names x, y, z")
    return [names.index(axis) for axis in AXES]


def _is_number(words: list[str]) -> bool:
    try:
        float(words[0])
    except (ValueError, IndexError):
        return False
    return True
