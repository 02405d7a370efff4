"""Tests of reading bytes. Every error is one line with the file name."""

from __future__ import annotations

from pathlib import Path

import pytest

from eyehand.errors import InputError
from eyehand.perception.io.input_file import naming, read_bytes


def test_bytes_are_read_unchanged(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"\x00\xff\r\n")
    assert read_bytes(str(path)) == b"\x00\xff\r\n"


def test_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.pcd: no such file"):
        read_bytes(tmp_path / "absent.pcd")


def test_empty_file_is_reported(tmp_path: Path) -> None:
    (tmp_path / "a.pcd").touch()
    with pytest.raises(InputError, match=r"a\.pcd: the file is empty"):
        read_bytes(tmp_path / "a.pcd")


def test_folder_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be read .*directory"):
        read_bytes(tmp_path)


def test_name_with_zero_byte_is_rejected() -> None:
    with pytest.raises(InputError, match="not a file name"):
        read_bytes("a\0b")


def test_file_name_is_added_once() -> None:
    with pytest.raises(InputError) as caught, naming("a.png"), naming("a.png"):
        raise InputError("too dark")
    assert str(caught.value) == "a.png: too dark"
