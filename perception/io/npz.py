"""Reading of named arrays from NumPy archives, without pickled objects."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .input_file import MAX_FILE_BYTES, check_file

COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""What NumPy writes. Other methods unpack a few bytes to any size at once."""


def read_arrays(path: Path | str, names: Sequence[str]) -> dict[str, NDArray]:
    """Read arrays of an `.npz` archive by name. Missing names are left out.

    Raises
    ------
    InputError
        If the file is missing or damaged, is not an archive of arrays, holds Python objects in a
        requested array, holds none of the requested names, or declares more than `MAX_FILE_BYTES`
        for them.
    """
    check_file(path)
    try:
        # A single array is only mapped to memory, not read.
        archive = np.load(path, allow_pickle=False, mmap_mode="r")
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise InputError(f"{path}: holds a single array, expected an .npz archive")
        with archive:
            held = list(archive.files)
            requested = [name for name in names if name in held]
            _check_sizes(path, archive, requested)
            arrays = {name: archive[name] for name in requested}
    except InputError:
        raise
    except Exception as error:
        # On damaged files zipfile, zlib and the header parser raise more than ten exception types.
        fault = " ".join(str(error).split())
        raise InputError(
            f"{path}: not a whole .npz archive of plain arrays ({fault or type(error).__name__})"
        ) from error
    if not arrays:
        raise InputError(f"{path}: holds {held}, expected one of {list(names)}")
    return arrays


def array_names(path: Path | str) -> list[str]:
    """Return the names of all arrays of an `.npz` archive that `read_arrays` can read."""
    with zipfile.ZipFile(path) as archive:
        return [name.removesuffix(".npy") for name in archive.namelist()]


def _check_sizes(path: Path | str, archive: np.lib.npyio.NpzFile, names: Sequence[str]) -> None:
    """Reject arrays that are too large. zipfile never unpacks more than the size declared here."""
    held = [] if archive.zip is None else archive.zip.infolist()
    members = [info for info in held if info.filename.removesuffix(".npy") in names]
    total = sum(member.file_size for member in members)
    if total > MAX_FILE_BYTES:
        raise InputError(
            f"{path}: {', '.join(names)} unpack to {total} bytes, expected at most {MAX_FILE_BYTES}"
        )
    for member in members:
        if member.compress_type not in COMPRESSIONS:
            raise InputError(f"{path}: {member.filename} is not stored or deflated as NumPy does")
