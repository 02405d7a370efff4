"""Decompression of LZF data, the compression of binary_compressed PCD files."""

from __future__ import annotations

from eyehand.errors import InputError

MAX_LITERALS = 32
"""Maximum number of literal bytes in a run. A control byte below it starts such a run. Any other
starts a copy."""

LONG_COPY = 7
"""Length code of a copy whose next byte adds to its length."""

DAMAGED = "the LZF data are damaged: they must decompress to {} bytes"
"""Error message for data that is no LZF stream of the declared size."""


def unpack_lzf(packed: bytes, size: int) -> bytes:
    """Decompress an LZF stream (Lehmann, liblzf: the format is defined by its `lzf_d.c`).

    Parameters
    ----------
    packed : bytes
        The compressed data.
    size : int
        Length of the decompressed data, bytes.

    Returns
    -------
    bytes
        The decompressed data, of length `size`.

    Raises
    ------
    InputError
        If the stream ends early, refers to bytes before its start, or has another size.
    """
    unpacked = bytearray()
    position = 0
    try:
        while position < len(packed) and len(unpacked) <= size:
            control = packed[position]
            position += 1
            if control < MAX_LITERALS:
                unpacked += packed[position : position + control + 1]
                position += control + 1
                continue
            length = control >> 5
            if length == LONG_COPY:
                length += packed[position]
                position += 1
            length += 2
            distance = ((control & 0x1F) << 8) + packed[position] + 1
            position += 1
            start = len(unpacked) - distance
            if start < 0:
                raise InputError(DAMAGED.format(size))
            # A copy may be longer than its distance. It then repeats the last `distance` bytes.
            run = unpacked[start : start + length]
            unpacked += (run * (length // distance + 1))[:length] if length > distance else run
    except IndexError as error:
        raise InputError(DAMAGED.format(size)) from error
    if position != len(packed) or len(unpacked) != size:
        raise InputError(DAMAGED.format(size))
    return bytes(unpacked)
