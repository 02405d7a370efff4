"""Tests of LZF decompression."""

from __future__ import annotations

import pytest

from eyehand.errors import InputError
from eyehand.perception.io.lzf import unpack_lzf


@pytest.mark.parametrize(
    ("packed", "expected"),
    [
        (b"\x02abc", b"abc"),
        # A copy of 3 bytes that start 3 bytes earlier.
        (b"\x02abc\x20\x02", b"abcabc"),
        # A copy of 5 bytes that starts 1 byte earlier repeats that byte.
        (b"\x00a\x60\x00", b"aaaaaa"),
        # A long copy: 7 + 4 + 2 bytes that start 2 bytes earlier.
        (b"\x01ab\xe0\x04\x01", b"ab" * 7 + b"a"),
    ],
)
def test_unpacks_literals_and_copies(packed: bytes, expected: bytes) -> None:
    assert unpack_lzf(packed, len(expected)) == expected


@pytest.mark.parametrize(
    ("packed", "size"),
    [
        (b"\x02abc", 2),
        (b"\x02abc", 4),
        (b"\x02ab", 3),
        (b"\x00a\x20\x01", 4),
        (b"\x00a\x20", 4),
        (b"\x00a\xe0\x04", 14),
        (b"\x00a" * 5, 2),
    ],
)
def test_damaged_data_is_rejected(packed: bytes, size: int) -> None:
    with pytest.raises(InputError, match="damaged: they must decompress to"):
        unpack_lzf(packed, size)
