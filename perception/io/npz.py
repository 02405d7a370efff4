"""Reading of named arrays from NumPy archives, without pickled objects."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .input_file import read_bytes

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import NDArray


def read_arrays(path: Path | str, names: Sequence[str]) -> dict[str, NDArray]:
    """Read arrays of an `.npz` archive by name. Missing names are left out.

    Raises
    ------
    InputError
        If the file is missing or damaged, is not an archive of arrays, holds Python objects in a
        requested array, or holds none of the requested names.
    """
    data = io.BytesIO(read_bytes(path))
    try:
        archive = np.load(data, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise InputError(f"{path}: holds a single array, expected an .npz archive")
        held = list(archive.files)
        arrays = {name: archive[name] for name in names if name in held}
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
