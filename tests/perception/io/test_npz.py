"""Tests of reading arrays from NPZ archives."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception.io import npz
from eyehand.perception.io.npz import read_arrays


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    path = tmp_path / "a.npz"
    np.savez_compressed(path, depth=np.arange(600.0), label=np.ones(3))
    return path


def test_requested_arrays_are_read_and_absent_ones_skipped(archive: Path) -> None:
    arrays = read_arrays(archive, ("depth", "rgb"))
    assert list(arrays) == ["depth"]
    np.testing.assert_array_equal(arrays["depth"], np.arange(600.0))


def test_archive_without_requested_arrays_lists_contents(archive: Path) -> None:
    with pytest.raises(InputError, match=r"holds \['depth', 'label'\], expected one of \['points"):
        read_arrays(archive, ("points",))


@pytest.mark.parametrize("keep", [1, 50, 300, -1])
def test_truncated_archive_is_rejected(archive: Path, keep: int) -> None:
    archive.write_bytes(archive.read_bytes()[:keep])
    with pytest.raises(InputError, match=r"a\.npz: not a whole \.npz archive"):
        read_arrays(archive, ("depth",))


def test_python_objects_are_not_unpickled(tmp_path: Path) -> None:
    objects = np.empty(1, dtype=object)
    objects[0] = {"a": 1}
    np.savez(tmp_path / "a.npz", depth=objects, allow_pickle=True)
    with pytest.raises(InputError, match="Object arrays cannot be loaded"):
        read_arrays(tmp_path / "a.npz", ("depth",))


def test_single_array_file_is_rejected(tmp_path: Path) -> None:
    with (tmp_path / "a.npz").open("wb") as file:
        np.save(file, np.ones(3))
    with pytest.raises(InputError, match=r"holds a single array, expected an \.npz archive"):
        read_arrays(tmp_path / "a.npz", ("depth",))


def write_archive(path: Path, method: int, **arrays: np.ndarray) -> Path:
    """Write arrays to an archive compressed by a method of zipfile."""
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, array in arrays.items():
            member = io.BytesIO()
            np.save(member, array)
            archive.writestr(f"{name}.npy", member.getvalue())
    return path


def test_arrays_that_unpack_to_too_much_are_rejected_before_unpacking(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(npz, "MAX_FILE_BYTES", 10_000)
    path = write_archive(
        tmp_path / "a.npz", zipfile.ZIP_DEFLATED, depth=np.zeros(2000), a=np.ones(3)
    )
    assert path.stat().st_size < 2000
    with pytest.raises(InputError, match=r"a\.npz: depth unpack to 16128 bytes, expected at most"):
        read_arrays(path, ("depth",))
    assert list(read_arrays(path, ("a",))) == ["a"]


def test_other_compression_is_rejected(tmp_path: Path) -> None:
    path = write_archive(tmp_path / "a.npz", zipfile.ZIP_LZMA, depth=np.zeros(9))
    with pytest.raises(InputError, match=r"depth\.npy is not stored or deflated"):
        read_arrays(path, ("depth",))


@settings(deadline=None, max_examples=60)
@given(at=st.integers(0, 300), value=st.integers(0, 255))
def test_damaged_byte_is_detected_or_harmless(
    tmp_path_factory: pytest.TempPathFactory, at: int, value: int
) -> None:
    path = tmp_path_factory.mktemp("npz") / "a.npz"
    np.savez_compressed(path, depth=np.arange(600.0))
    data = bytearray(path.read_bytes())
    data[at] = value
    path.write_bytes(data)
    try:
        arrays = read_arrays(path, ("depth",))
    except InputError:
        return
    np.testing.assert_array_equal(arrays["depth"], np.arange(600.0))
