"""Tests of atomic writing: a file is written completely or not at all."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from eyehand.errors import DeviceError, InputError
from eyehand.perception.io.atomic_write import atomic_write


def test_temporary_path_keeps_folder_and_suffix(tmp_path: Path) -> None:
    path = tmp_path / "cloud.npz"
    with atomic_write(path) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".npz"
        assert not temporary.exists()
        temporary.write_bytes(b"new")
        assert not path.exists()
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]


def test_existing_file_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text("old")
    with atomic_write(str(path)) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"


def test_failure_keeps_old_file_only(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text("old")

    def write_half() -> None:
        with atomic_write(path) as temporary:
            temporary.write_text("half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_half()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_fifo_is_refused_and_kept(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    os.mkfifo(path)
    with pytest.raises(InputError, match="FIFO"), atomic_write(path) as temporary:
        temporary.write_text("new")
    assert path.is_fifo()


def test_new_file_has_default_permissions(tmp_path: Path) -> None:
    reference_file = tmp_path / "plain"
    reference_file.write_text("")
    with atomic_write(tmp_path / "a.txt") as temporary:
        temporary.write_text("")
    written, expected = (
        stat.S_IMODE(p.stat().st_mode) for p in (tmp_path / "a.txt", reference_file)
    )
    assert written == expected


def test_missing_folder_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "absent" / "a.txt"
    with pytest.raises(InputError, match=f"cannot write {path}: there is no folder .*absent"):
        atomic_write(path).__enter__()


def test_folder_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder, expected a file name"):
        atomic_write(tmp_path).__enter__()


def test_missing_output_raises(tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match="nothing was written"), atomic_write(tmp_path / "a"):
        pass


def test_full_disk_raises_device_error(tmp_path: Path) -> None:
    def fill_disk() -> None:
        with atomic_write(tmp_path / "a.txt") as temporary:
            temporary.write_text("half")
            raise OSError(28, "No space left on device")

    with pytest.raises(DeviceError, match=r"cannot write .*a\.txt: No space left on device"):
        fill_disk()
    assert list(tmp_path.iterdir()) == []
