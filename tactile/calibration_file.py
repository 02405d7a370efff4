"""Calibrations in files: one versioned .npz, written whole or not at all."""

from __future__ import annotations

import io
import secrets
import zipfile
from pathlib import Path

import numpy as np

from eyehand.errors import DeviceError, InputError

from .calibration import Calibration

SCHEMA = "eyehand.calibration/1"
"""Name and version of the format."""
_ARRAYS = ("raws", "pressures", "rest", "noise", "ceiling", "dead")


def save_calibration(calibration: Calibration, path: Path | str) -> None:
    """Write a calibration; an existing file is replaced only when the new one is complete.

    Raises
    ------
    InputError
        If the name does not end in .npz, the folder does not exist or cannot be written to.
    DeviceError
        If the system fails to write.
    """
    path = Path(path)
    if path.suffix != ".npz":
        raise InputError(f"a calibration must be a .npz file, got {path}")
    if not path.parent.is_dir():
        raise InputError(f"cannot write {path}: there is no folder {path.parent}")
    data = io.BytesIO()
    arrays = {name: getattr(calibration, name) for name in _ARRAYS}
    np.savez_compressed(data, allow_pickle=False, schema=np.array(SCHEMA), **arrays)
    # Rooms on the ground floor import nothing, so this is the tactile one's own way of the swap.
    temporary = path.parent / f".{secrets.token_hex(8)}{path.suffix}"
    try:
        temporary.write_bytes(data.getvalue())
        temporary.replace(path)
    except PermissionError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error
    except OSError as error:
        raise DeviceError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def load_calibration(path: Path | str) -> Calibration:
    """Read a calibration.

    Raises
    ------
    InputError
        If the file is missing, not a calibration, or of another version.
    """
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as archive:
            if "schema" not in archive or str(archive["schema"]) != SCHEMA:
                raise InputError(f"{path} is no calibration of version {SCHEMA}")
            arrays = {name: archive[name] for name in _ARRAYS}
    except FileNotFoundError as error:
        raise InputError(f"there is no calibration {path}") from error
    except (OSError, ValueError, KeyError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        raise InputError(f"{path} is no calibration: {error}") from error
    for name, values in arrays.items():
        wanted = "b" if name == "dead" else "f"
        if values.dtype.kind != wanted:
            raise InputError(f"{path}: {name} has the wrong type {values.dtype}")
    return Calibration(**arrays)
