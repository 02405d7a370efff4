"""Atomic file writing: a file appears completely or not at all."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from eyehand.errors import DeviceError, InputError


@contextmanager
def atomic_write(path: Path | str) -> Iterator[Path]:
    """Yield a temporary path to write to, and rename it to `path` when the block succeeds.

    The temporary file is in the same folder, so that one rename replaces `path`. It has the same
    suffix, because some writers choose the format by suffix. If the block raises, the temporary
    file is removed and `path` is unchanged. The data are not flushed to the disk: readers never get
    half a file, but a power failure may lose it.

    Parameters
    ----------
    path : Path or str
        The file to write. An existing file is replaced.

    Yields
    ------
    Path
        The path to write to. The file does not exist yet.

    Raises
    ------
    InputError
        If the folder does not exist, `path` is a folder, FIFO, socket or device, or writing there
        is not allowed.
    DeviceError
        If the system fails to write (a full disk, say), or the block wrote nothing.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"cannot write {path}: there is no folder {path.parent}")
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder, expected a file name")
    if path.exists() and not path.is_file():
        raise InputError(f"cannot write {path}: it is a FIFO or device, expected a file name")
    temporary = path.parent / f".{secrets.token_hex(8)}{path.suffix}"
    try:
        yield temporary
        if not temporary.is_file():
            raise DeviceError(f"cannot write {path}: nothing was written to its temporary file")
        temporary.replace(path)
    except PermissionError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error
    except OSError as error:
        raise DeviceError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)
