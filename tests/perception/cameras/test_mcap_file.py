"""Tests of MCAP files with every part damaged in turn."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

import pytest

from eyehand.errors import InputError
from eyehand.perception.cameras.mcap_file import MAGIC, check_mcap

if TYPE_CHECKING:
    from pathlib import Path


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def statistics(messages: int) -> bytes:
    return record(0x0B, struct.pack("<QHIIIIQQI", messages, 1, 1, 0, 0, 0, 0, 0, 0))


def mcap(summary: bytes, *, summed: bool = True) -> bytes:
    """Return the bytes of a minimal file that follows the MCAP specification."""
    head = MAGIC + record(0x01, bytes(8)) + record(0x0F, bytes(4))
    tail = summary + struct.pack("<BQ", 0x02, 20) + struct.pack("<QQ", len(head), 0)
    return head + tail + struct.pack("<I", zlib.crc32(tail) if summed else 0) + MAGIC


def test_minimal_file_of_specification_is_accepted(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(mcap(statistics(7)))
    check_mcap(path)


def test_damaged_summary_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    content = bytearray(mcap(statistics(7)))
    content[content.index(struct.pack("<QH", 7, 1))] = 8
    path.write_bytes(content)

    with pytest.raises(InputError, match="the checksum of its summary is wrong"):
        check_mcap(path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b"hello", "begins with b'hello'"),
        (MAGIC, "truncated, its 8 bytes"),
        (MAGIC + bytes(1000), "truncated, its 1008 bytes"),
        (MAGIC + bytes(1000) + MAGIC, "there is no footer"),
        (mcap(b"")[:-1], "truncated"),
    ],
)
def test_broken_file_is_reported_in_one_line(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)

    with pytest.raises(InputError, match=message) as caught:
        check_mcap(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("start", "message"),
    [(0, "no summary section"), (3, "would begin at byte 3"), (10**12, "would begin at byte 1000")],
)
def test_footer_with_invalid_offset_is_rejected(tmp_path: Path, start: int, message: str) -> None:
    content = bytearray(mcap(statistics(1), summed=False))
    struct.pack_into("<Q", content, len(content) - 28, start)
    path = tmp_path / "a.mcap"
    path.write_bytes(content)

    with pytest.raises(InputError, match=message):
        check_mcap(path)


def test_summary_without_data_end_record_is_rejected(tmp_path: Path) -> None:
    content = bytearray(mcap(statistics(1), summed=False))
    (start,) = struct.unpack_from("<Q", content, len(content) - 28)
    content[start - 13] = 0x80
    path = tmp_path / "a.mcap"
    path.write_bytes(content)

    with pytest.raises(InputError, match="no end-of-data record"):
        check_mcap(path)
