"""Integrity checks and checksums of MCAP container files.

depthai writes MCAP files without a checksum of the data, and it ignores the checksums of the chunks
when it reads. A damaged file therefore plays back with missing or wrong frames and no error. The
format's DataEnd record can hold a checksum: `seal` writes it and `check_mcap` verifies it.

Source: MCAP format specification, version 0, https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from eyehand.errors import InputError

from ..io.input_file import check_file

MAGIC = b"\x89MCAP0\r\n"
"""First and last eight bytes of every complete MCAP file."""

FOOTER, SCHEMA, STATISTICS, DATA_END = 0x02, 0x03, 0x0B, 0x0F
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

BLOCK_SIZE = 1 << 20
"""Bytes per read while the checksum is computed."""


@dataclass(frozen=True)
class McapContents:
    """Contents of an MCAP file according to its summary."""

    schemas: tuple[str, ...]
    """Names of the message types."""
    messages: int
    """Number of messages, all channels together."""
    sealed: bool
    """Whether the data have a checksum. It has been verified."""


def check_mcap(path: Path | str) -> McapContents:
    """Verify that an MCAP file is complete and return its contents.

    Damage is detected only in sections that have a checksum.

    Raises
    ------
    InputError
        If the file is missing, not MCAP, truncated, without a summary, or fails a checksum.
    """
    path = Path(path)
    check_file(path)
    try:
        with path.open("rb") as file:
            return _check(path, file)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error


def seal(path: Path) -> McapContents:
    """Write the checksum of the data into the file's DataEnd record, in place.

    Raises
    ------
    InputError
        As `check_mcap`: only a complete file is sealed.
    """
    check_mcap(path)
    with path.open("r+b") as file:
        at = _data_end(path, file, _read_footer(path, file)[0])
        crc = _checksum(file, at)
        file.seek(at + RECORD_HEAD.size)
        file.write(DATA_END_BODY.pack(crc))
    return check_mcap(path)


def _check(path: Path, file: BinaryIO) -> McapContents:
    summary_start, stored = _read_footer(path, file)
    end = _size(file) - len(MAGIC)
    file.seek(summary_start)
    summary = file.read(end - summary_start)
    # The checksum also covers the footer, up to the checksum field.
    if stored and zlib.crc32(summary[: -DATA_END_BODY.size]) != stored:
        raise InputError(f"{path}: damaged, the checksum of its summary is wrong")
    at = _data_end(path, file, summary_start)
    file.seek(at + RECORD_HEAD.size)
    (stored,) = DATA_END_BODY.unpack(file.read(DATA_END_BODY.size))
    if stored and _checksum(file, at) != stored:
        raise InputError(f"{path}: damaged, the checksum of its data is wrong")
    try:
        schemas, messages = _read_summary(summary[:-FOOTER_SIZE])
    except (struct.error, ValueError) as error:
        raise InputError(f"{path}: damaged, its summary cannot be read ({error})") from error
    if messages is None:
        raise InputError(f"{path}: its summary does not say how many messages it holds")
    return McapContents(schemas, messages, sealed=stored != 0)


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
        raise InputError(f"{path}: has no summary section, expected one as depthai writes")
    if not len(MAGIC) + DATA_END_SIZE <= start <= size - len(MAGIC) - FOOTER_SIZE:
        raise InputError(f"{path}: damaged, its summary would begin at byte {start} of {size}")
    return start, crc


def _data_end(path: Path, file: BinaryIO, summary_start: int) -> int:
    """Return the offset of the DataEnd record, the last one before the summary."""
    at = summary_start - DATA_END_SIZE
    file.seek(at)
    if RECORD_HEAD.unpack(file.read(RECORD_HEAD.size)) != (DATA_END, DATA_END_BODY.size):
        raise InputError(f"{path}: damaged, there is no end-of-data record before its summary")
    return at


def _read_summary(summary: bytes) -> tuple[tuple[str, ...], int | None]:
    schemas: list[str] = []
    messages = None
    for opcode, body in _records(summary):
        if opcode == SCHEMA:
            _, length = struct.unpack_from("<HI", body)
            schemas.append(body[6 : 6 + length].decode())
        elif opcode == STATISTICS:
            (messages,) = struct.unpack_from("<Q", body)
    return tuple(schemas), messages


def _records(section: bytes) -> Iterator[tuple[int, bytes]]:
    at = 0
    while at < len(section):
        opcode, length = RECORD_HEAD.unpack_from(section, at)
        at += RECORD_HEAD.size
        if at + length > len(section):
            raise ValueError(f"a record of {length} bytes reaches past its end")
        yield opcode, section[at : at + length]
        at += length


def _checksum(file: BinaryIO, end: int) -> int:
    """Return the CRC-32 of the first `end` bytes."""
    file.seek(0)
    crc = 0
    left = end
    while left > 0 and (block := file.read(min(BLOCK_SIZE, left))):
        crc = zlib.crc32(block, crc)
        left -= len(block)
    return crc


def _size(file: BinaryIO) -> int:
    return file.seek(0, 2)
