"""Tests of MCAP files with every part damaged in turn."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

import pytest

from eyehand.errors import InputError
from eyehand.perception.cameras.mcap_file import MAGIC, McapContents, check_mcap, seal

from .oak_frames import record_frames

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from eyehand.perception.frame import DepthFrame

    Frames = Callable[..., list[DepthFrame]]


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def schema(name: str) -> bytes:
    encoded = name.encode()
    return record(0x03, struct.pack("<HI", 1, len(encoded)) + encoded + bytes(8))


def statistics(messages: int) -> bytes:
    return record(0x0B, struct.pack("<QHIIIIQQI", messages, 1, 1, 0, 0, 0, 0, 0, 0))


def mcap(summary: bytes, *, data: bytes = b"", data_crc: int = 0, summed: bool = True) -> bytes:
    """Return the bytes of a minimal file that follows the MCAP specification."""
    head = MAGIC + record(0x01, bytes(8)) + data + record(0x0F, struct.pack("<I", data_crc))
    tail = summary + struct.pack("<BQ", 0x02, 20) + struct.pack("<QQ", len(head), 0)
    return head + tail + struct.pack("<I", zlib.crc32(tail) if summed else 0) + MAGIC


def test_minimal_file_of_specification_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(mcap(schema("some.Type") + schema("Ünï") + statistics(7)))

    assert check_mcap(path) == McapContents(("some.Type", "Ünï"), 7, sealed=False)


def test_sealed_file_detects_changed_data(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(mcap(statistics(1), data=record(0x80, b"private data")))

    assert seal(path).sealed
    assert check_mcap(path).sealed
    content = bytearray(path.read_bytes())
    content[content.index(b"private")] ^= 1
    path.write_bytes(content)
    with pytest.raises(InputError, match="the checksum of its data is wrong"):
        check_mcap(path)


def test_seal_is_crc_of_data_section(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(mcap(statistics(1), data=record(0x80, bytes(range(256)) * 5000)))
    seal(path)

    content = path.read_bytes()
    offset = content.index(struct.pack("<BQ", 0x0F, 4), 1_280_000)
    assert struct.unpack_from("<I", content, offset + 9)[0] == zlib.crc32(content[:offset])


def test_sealing_twice_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(mcap(statistics(1)))
    seal(path)
    once = path.read_bytes()
    seal(path)

    assert path.read_bytes() == once


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
        (mcap(schema("a"), summed=False), "does not say how many messages"),
        (mcap(statistics(1)[:-30], summed=False), "does not say how many|cannot be read"),
        (mcap(statistics(1)[:12], summed=False), "cannot be read"),
        (mcap(record(0x03, b"\x01"), summed=False), "cannot be read"),
        (mcap(record(0x03, struct.pack("<HI", 1, 2) + b"\xff\xfe"), summed=False), "cannot be"),
    ],
)
def test_broken_file_is_reported_in_one_line(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)

    with pytest.raises(InputError, match=message) as caught:
        check_mcap(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError):
        seal(path)
    assert path.read_bytes() == content


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


def test_depthai_recording_is_read(tmp_path: Path, frames: Frames) -> None:
    record_frames(tmp_path / "a.mcap", frames(4))

    contents = check_mcap(tmp_path / "a.mcap")

    assert contents == McapContents(("dai.proto.img_frame.ImgFrame",), 4, sealed=True)
