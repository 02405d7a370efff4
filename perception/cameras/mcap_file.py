"""Integrity check of MCAP container files before they are read.

The package mcap verifies the checksums of the chunks, but not the end of a file and the checksum of
its summary.

Source: MCAP format specification, version 0, https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import BinaryIO

from eyehand.errors import InputError

from ..io.input_file import check_file

MAGIC = b"\x89MCAP0\r\n"
"""First and last eight bytes of every complete MCAP file."""

FOOTER, DATA_END = 0x02, 0x0F
"""Opcodes of the records that are read."""

RECORD_HEAD = struct.Struct("<BQ")
"""Start of every record: the opcode and the length of the rest, bytes."""

FOOTER_BODY = struct.Struct("<QQI")
"""Footer: start of the summary, start of its offsets, CRC-32 of the summary (0 = none)."""

FOOTER_SIZE = RECORD_HEAD.size + FOOTER_BODY.size
"""Bytes of a footer record."""

DATA_END_BODY = struct.Struct("<I")
"""CRC-32 of everything before the DataEnd record (0 = none)."""

DATA_END_SIZE = RECORD_HEAD.size + DATA_END_BODY.size
"""Bytes of a DataEnd record."""


def check_mcap(path: Path | str) -> None:
    """Verify that an MCAP file is complete and that its summary is undamaged.

    Raises
    ------
    InputError
        If the file is missing, not MCAP, truncated, without a summary, or fails a checksum.
    """
    path = Path(path)
    check_file(path)
    try:
        with path.open("rb") as file:
            _check(path, file)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error


def _check(path: Path, file: BinaryIO) -> None:
    summary_start, stored = _read_footer(path, file)
    end = _size(file) - len(MAGIC)
    file.seek(summary_start)
    summary = file.read(end - summary_start)
    # The checksum also covers the footer, up to the checksum field.
    if stored and zlib.crc32(summary[: -DATA_END_BODY.size]) != stored:
        raise InputError(f"{path}: damaged, the checksum of its summary is wrong")
    file.seek(summary_start - DATA_END_SIZE)
    if RECORD_HEAD.unpack(file.read(RECORD_HEAD.size)) != (DATA_END, DATA_END_BODY.size):
        raise InputError(f"{path}: damaged, there is no end-of-data record before its summary")


def _read_footer(path: Path, file: BinaryIO) -> tuple[int, int]:
    """Return the offset of the summary section and its CRC-32."""
    size = _size(file)
    file.seek(0)
    head = file.read(len(MAGIC))
    if head != MAGIC:
        raise InputError(f"{path}: not an MCAP file, it begins with {head!r}, expected {MAGIC!r}")
    smallest = 2 * len(MAGIC) + FOOTER_SIZE + DATA_END_SIZE
    file.seek(max(0, size - len(MAGIC) - FOOTER_SIZE))
    tail = file.read()
    if size < smallest or not tail.endswith(MAGIC):
        raise InputError(
            f"{path}: truncated, its {size} bytes lack the end mark; was the recording interrupted?"
        )
    opcode, length = RECORD_HEAD.unpack_from(tail)
    start, _, crc = FOOTER_BODY.unpack_from(tail, RECORD_HEAD.size)
    if (opcode, length) != (FOOTER, FOOTER_BODY.size):
        raise InputError(f"{path}: damaged, there is no footer before its end mark")
    if start == 0:
        raise InputError(f"{path}: has no summary section, expected one as recorders write")
    if not len(MAGIC) + DATA_END_SIZE <= start <= size - len(MAGIC) - FOOTER_SIZE:
        raise InputError(f"{path}: damaged, its summary would begin at byte {start} of {size}")
    return start, crc


def _size(file: BinaryIO) -> int:
    return file.seek(0, 2)
