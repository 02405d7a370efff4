"""Calibration files: one versioned .npz, written completely or not at all."""

from __future__ import annotations

import io
import secrets
from pathlib import Path

import numpy as np

from eyehand.errors import DeviceError, InputError

from .calibration import Calibration

SCHEMA = "eyehand.calibration/1"
"""Name and version of the format."""
MAX_FILE_BYTES = 1 << 28
"""Maximum size of a file, and of its arrays unpacked, bytes."""
_ARRAYS = ("raws", "pressures", "rest", "noise", "ceiling", "dead")


def save_calibration(calibration: Calibration, path: Path | str) -> None:
    """Write a calibration to a file; it replaces an existing one only when it is complete.

    Raises
    ------
    InputError
        If the name does not end in .npz, the folder does not exist, or it is not writable.
    DeviceError
        If the system fails to write.
    """
    path = Path(path)
    if path.suffix != ".npz":
        raise InputError(f"a calibration must be a .npz file, got {path}")
    if not path.parent.is_dir():
        raise InputError(f"cannot write {path}: folder {path.parent} does not exist")
    # `perception.io.atomic_write` is similar, but the base packages do not import one another.
    temporary = path.parent / f".{secrets.token_hex(8)}{path.suffix}"
    try:
        temporary.write_bytes(calibration_bytes(calibration))
        temporary.replace(path)
    except PermissionError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error
    except OSError as error:
        raise DeviceError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def calibration_bytes(calibration: Calibration) -> bytes:
    """Return the content of a calibration file."""
    data = io.BytesIO()
    arrays = {name: getattr(calibration, name) for name in _ARRAYS}
    arrays |= {"schema": np.array(SCHEMA), "bits": np.array(calibration.bits)}
    np.savez_compressed(data, allow_pickle=False, **arrays)
    return data.getvalue()


def load_calibration(path: Path | str) -> Calibration:
    """Read a calibration from a file.

    Raises
    ------
    InputError
        If the file does not exist, is not a calibration, or has another version.
    """
    try:
        size = Path(path).stat().st_size
        if size > MAX_FILE_BYTES:
            raise InputError(
                f"calibration {path} has {size} bytes, expected at most {MAX_FILE_BYTES}"
            )
        data = Path(path).read_bytes()
    except FileNotFoundError as error:
        raise InputError(f"calibration {path} does not exist") from error
    except OSError as error:
        raise InputError(f"cannot read calibration {path}: {error.strerror}") from error
    return read_calibration(data, str(path))


def read_calibration(data: bytes, name: str) -> Calibration:
    """Read a calibration from the content of a file; `name` is for messages.

    Raises
    ------
    InputError
        If the content is not a calibration, or has another version.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            # zipfile never unpacks more than the sizes declared here.
            unpacked = sum(member.file_size for member in archive.zip.infolist())
            if unpacked > MAX_FILE_BYTES:
                raise InputError(
                    f"{name}: its arrays unpack to {unpacked} bytes, expected at most "
                    f"{MAX_FILE_BYTES}"
                )
            if "schema" not in archive or str(archive["schema"]) != SCHEMA:
                raise InputError(f"schema must be {SCHEMA}")
            arrays = {name: archive[name] for name in _ARRAYS}
            # Files of earlier versions have no bits: all converters had 12.
            bits = int(archive["bits"]) if "bits" in archive else 12
    except Exception as error:  # The decoders of a damaged file raise exceptions of many types.
        raise InputError(f"{name} is not a calibration: {error}") from error
    for field, values in arrays.items():
        kind = np.bool_ if field == "dead" else np.floating
        if not np.issubdtype(values.dtype, kind):
            raise InputError(f"{name}: {field} must be {kind.__name__}, got {values.dtype}")
    return Calibration(**arrays, bits=bits)
