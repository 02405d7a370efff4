"""The content of a point-cloud file: a table with one row per point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..frame import MAX_PIXELS

LITTLE_ENDIAN_RECORD = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
"""Layout of one written point without colour."""

MAX_DIGITS = 15
"""Maximum digits of a size or count in a header."""

MAX_POINTS = MAX_PIXELS
"""Maximum number of points: those of the largest depth frame."""


@dataclass(frozen=True)
class PointTable:
    """Points in file order, with the size of the pixel grid that the file declares."""

    points: NDArray[np.floating]
    """Coordinates, (N, 3) float32 or float64 as stored, m; NaN = no reading."""
    colours: NDArray[np.uint8] | None = None
    """Colours, (N, 3) uint8 RGB, or None."""
    width: int = 0
    """Columns of the grid; 0 when the file has no grid."""
    height: int = 1
    """Rows of the grid; 1 when the points form no grid."""


def check_point_count(count: int) -> None:
    """Raise an `InputError` if a file declares more than `MAX_POINTS` points."""
    if count > MAX_POINTS:
        raise InputError(f"holds {count} points, expected at most {MAX_POINTS}")


def parse_rows(
    text: str, count: int, columns: Sequence[int], *, skip: int = 0
) -> NDArray[np.float64]:
    """Parse `count` lines of whitespace-separated numbers, (count, len(columns)) float64.

    Raises
    ------
    InputError
        If there are fewer lines, or a requested column is missing or not a number.
    """
    lines = [line for line in text.splitlines() if line.strip()][skip : skip + count]
    if len(lines) < count:
        raise InputError(f"truncated: holds {len(lines)} of the {count} points that it declares")
    numbers = load_numbers("\n".join(lines), columns)
    if len(numbers) != count:
        raise InputError(f"holds {len(numbers)} rows of numbers, expected {count}")
    return numbers


def load_numbers(text: str, columns: Sequence[int]) -> NDArray[np.float64]:
    """Parse columns of whitespace-separated text, (N, columns) float64. Blank lines are skipped.

    Raises
    ------
    InputError
        If there is no line, or one holds no number in a requested column.
    """
    if not text.strip():
        raise InputError("holds blank lines only, expected a table of numbers")
    try:
        return np.loadtxt(StringIO(text), usecols=columns, ndmin=2, comments=None)
    except (ValueError, OverflowError) as error:
        fault = str(error).split(";")[0]
        raise InputError(f"not a table of numbers ({fault})") from error


def whole_number(word: str) -> int | None:
    """Return the value of a word of ASCII digits, or None. int() would accept ' 1_0 ' as well."""
    plain = word.isascii() and word.isdigit() and len(word) <= MAX_DIGITS
    return int(word) if plain else None


def as_coordinates(columns: Sequence[NDArray]) -> NDArray[np.floating]:
    """Stack x, y, z (N,) of any number type as (N, 3) float32 or float64."""
    # Damaged files can hold signalling NaN. They count as NaN, without a warning.
    with np.errstate(invalid="ignore"):
        points = np.stack(columns, axis=-1)
    return points if points.dtype.kind == "f" else points.astype(np.float64)


def unpack_rgb(packed: NDArray) -> NDArray[np.uint8]:
    """Unpack PCL colours 0xAARRGGBB, integers or the bits of float32, to (N, 3) uint8 RGB."""
    with np.errstate(over="ignore", invalid="ignore"):
        bits = packed.astype(np.float32).view(np.uint32) if packed.dtype.kind == "f" else packed
        bits = bits.astype(np.uint32)
    return np.stack([(bits >> shift) & 0xFF for shift in (16, 8, 0)], axis=-1).astype(np.uint8)


def as_float32(points: NDArray[np.floating]) -> NDArray[np.float32]:
    """Convert coordinates to float32, the type in PCD and PLY files.

    Raises
    ------
    InputError
        If a finite coordinate exceeds the range of float32.
    """
    with np.errstate(over="ignore"):
        single = points.astype(np.float32)
    if np.isinf(single).any():
        raise InputError("a coordinate is too large for a float32 file, expected metres")
    return single
