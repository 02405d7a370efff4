"""A file appears whole, with the rights of any other new file, or not at all."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from eyehand.errors import DeviceError, InputError
from eyehand.perception.io.atomic_write import atomic_write


def test_the_temporary_path_has_the_folder_and_the_suffix_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "cloud.npz"
    with atomic_write(path) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".npz"
        assert not temporary.exists()
        temporary.write_bytes(b"new")
        assert not path.exists()
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_is_there_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text("old")
    with atomic_write(str(path)) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
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


def test_a_new_file_has_the_rights_that_the_system_gives_new_files(tmp_path: Path) -> None:
    plain = tmp_path / "plain"
    plain.write_text("")
    with atomic_write(tmp_path / "a.txt") as temporary:
        temporary.write_text("")
    written, expected = (stat.S_IMODE(p.stat().st_mode) for p in (tmp_path / "a.txt", plain))
    assert written == expected


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    path = tmp_path / "absent" / "a.txt"
    with pytest.raises(InputError, match=f"cannot write {path}: there is no folder .*absent"):
        atomic_write(path).__enter__()


def test_a_folder_is_no_file_name(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder, expected a file name"):
        atomic_write(tmp_path).__enter__()


def test_writing_nothing_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match="nothing was written"), atomic_write(tmp_path / "a"):
        pass


def test_a_full_disk_is_a_device_error_that_names_the_file(tmp_path: Path) -> None:
    def fill_disk() -> None:
        with atomic_write(tmp_path / "a.txt") as temporary:
            temporary.write_text("half")
            raise OSError(28, "No space left on device")

    with pytest.raises(DeviceError, match=r"cannot write .*a\.txt: No space left on device"):
        fill_disk()
    assert list(tmp_path.iterdir()) == []
