"""Tests of tables of points."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.perception.io.point_table import (
    as_float32,
    load_numbers,
    parse_rows,
    unpack_rgb,
    whole_number,
)


@pytest.mark.parametrize(
    ("word", "number"),
    [("0", 0), ("640", 640), ("-1", None), ("1_0", None), ("²", None), ("9" * 5000, None)],
)
def test_whole_number_accepts_ascii_digits_only(word: str, number: int | None) -> None:
    assert whole_number(word) == number


@pytest.mark.parametrize("dtype", [np.uint32, np.int32, np.float32])
def test_colours_unpack_from_integers_and_float_bits(dtype: type) -> None:
    packed = np.array([0x00C86432, 0x3F0A141E], dtype=np.uint32).view(dtype)
    np.testing.assert_array_equal(unpack_rgb(packed), [[200, 100, 50], [10, 20, 30]])


def test_rows_are_skipped_and_columns_selected() -> None:
    table = parse_rows("9\n\n1 2 3\n4 5 6\n7\n", 2, [2, 0], skip=1)
    np.testing.assert_array_equal(table, [[3, 1], [6, 4]])


def test_missing_rows_are_counted() -> None:
    with pytest.raises(InputError, match="truncated: holds 1 of the 2 points"):
        parse_rows("1 2 3\n", 2, [0])


@pytest.mark.parametrize("text", ["1 2\n", "1 two 3\n", "1 2 \n1\n"])
def test_non_numeric_text_is_rejected(text: str) -> None:
    with pytest.raises(InputError, match="not a table of numbers"):
        load_numbers(text, [0, 1, 2])


def test_coordinates_beyond_float32_are_rejected() -> None:
    with pytest.raises(InputError, match="too large for a float32 file"):
        as_float32(np.array([[1e300, 0.0, 0.0]]))
