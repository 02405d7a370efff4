"""Reading of whole files, with errors of one line that name the file."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from eyehand.errors import InputError

MAX_FILE_BYTES = 1 << 28
"""Maximum size of a file, and of the arrays of an archive, bytes. The largest frames that are read
need 200 MB as text. Reading takes up to 4 times this memory."""

KINDS = {
    stat.S_ISDIR: "a directory",
    stat.S_ISFIFO: "a FIFO",
    stat.S_ISSOCK: "a socket",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
}
"""Test of a file's mode → what it is instead of a file."""


def read_bytes(path: Path | str) -> bytes:
    """Read all bytes of a file.

    Raises
    ------
    InputError
        As `check_file`, or if the file is larger than `MAX_FILE_BYTES` or cannot be opened.
    """
    path = Path(path)
    size = check_file(path)
    if size > MAX_FILE_BYTES:
        raise InputError(f"{path}: holds {size} bytes, expected at most {MAX_FILE_BYTES}")
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error


def check_file(path: Path | str) -> int:
    """Check that a path leads to a file with content, and return its size, bytes.

    To open a FIFO or a device could wait forever, or never end. They are rejected unopened.

    Raises
    ------
    InputError
        If the file is missing, empty, or a directory, FIFO, socket or device.
    """
    try:
        status = Path(path).stat()
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    except ValueError as error:
        raise InputError(f"{str(path)!r} is not a file name: {error}") from error
    if not stat.S_ISREG(status.st_mode):
        kind = next((kind for test, kind in KINDS.items() if test(status.st_mode)), "special")
        raise InputError(f"{path}: cannot be read (it is {kind}, expected a file)")
    if not status.st_size:
        raise InputError(f"{path}: the file is empty (0 bytes)")
    return status.st_size


def is_file(path: Path) -> bool:
    """Return whether a file exists. A name that is too long names none."""
    try:
        return path.is_file()
    except OSError:
        return False


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """Add the file's name to an `InputError` of the block if the message lacks the name."""
    try:
        yield
    except InputError as error:
        if str(path) in str(error):
            raise
        raise InputError(f"{path}: {error}") from error
