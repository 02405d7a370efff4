"""Tests of reading bytes. Every error is one line with the file name."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from eyehand.errors import InputError
from eyehand.perception.io import input_file
from eyehand.perception.io.input_file import is_file, naming, read_bytes


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


def test_fifo_and_device_are_rejected_unopened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.png")
    with pytest.raises(InputError, match=r"a\.png: cannot be read \(it is a FIFO, expected"):
        read_bytes(tmp_path / "a.png")
    (tmp_path / "b.png").symlink_to(os.devnull)
    with pytest.raises(InputError, match=r"b\.png: cannot be read \(it is a device"):
        read_bytes(tmp_path / "b.png")


def test_name_that_is_too_long_names_no_file(tmp_path: Path) -> None:
    path = tmp_path / ("a" * 300)
    assert not is_file(path)
    with pytest.raises(InputError, match="File name too long"):
        read_bytes(path)


def test_file_that_is_too_large_is_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(input_file, "MAX_FILE_BYTES", 3)
    (tmp_path / "a.pcd").write_bytes(b"1234")
    with pytest.raises(InputError, match="holds 4 bytes, expected at most 3"):
        read_bytes(tmp_path / "a.pcd")


def test_name_with_zero_byte_is_rejected() -> None:
    with pytest.raises(InputError, match="not a file name"):
        read_bytes("a\0b")


def test_file_name_is_added_once() -> None:
    with pytest.raises(InputError) as caught, naming("a.png"), naming("a.png"):
        raise InputError("too dark")
    assert str(caught.value) == "a.png: too dark"
