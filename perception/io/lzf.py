"""Decompression of LZF data, the compression of binary_compressed PCD files."""

from __future__ import annotations

from eyehand.errors import InputError

MAX_LITERALS = 32
"""A control byte below this number starts a run of literal bytes. Others start a copy."""

LONG_COPY = 7
"""Length code of a copy whose next byte adds to its length."""

DAMAGED = "the compressed data are damaged: they do not unpack"
"""Error message for data that is no LZF stream of the declared size."""


def unpack_lzf(packed: bytes, size: int) -> bytes:
    """Decompress an LZF stream (Lehmann, liblzf: the format is defined by its `lzf_d.c`).

    Parameters
    ----------
    packed : bytes
        The compressed data.
    size : int
        Length of the decompressed data, bytes.

    Raises
    ------
    InputError
        If the stream ends early, refers to bytes before its start, or has another size.
    """
    unpacked = bytearray()
    at = 0
    try:
        while at < len(packed) and len(unpacked) <= size:
            control = packed[at]
            at += 1
            if control < MAX_LITERALS:
                unpacked += packed[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == LONG_COPY:
                length += packed[at]
                at += 1
            length += 2
            distance = ((control & 0x1F) << 8) + packed[at] + 1
            at += 1
            start = len(unpacked) - distance
            if start < 0:
                raise InputError(DAMAGED)
            # A copy that reaches beyond the current end repeats the bytes in between.
            run = unpacked[start : start + length]
            unpacked += (run * (length // distance + 1))[:length] if length > distance else run
    except IndexError as error:
        raise InputError(DAMAGED) from error
    if at != len(packed) or len(unpacked) != size:
        raise InputError(DAMAGED)
    return bytes(unpacked)
