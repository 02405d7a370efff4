"""Reading of whole files, with errors of one line that name the file."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator


def read_bytes(path: Path | str) -> bytes:
    """Read all bytes of a file.

    Raises
    ------
    InputError
        If the file is missing, empty, a folder, or cannot be opened.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    except ValueError as error:
        raise InputError(f"{str(path)!r} is not a file name: {error}") from error
    if not data:
        raise InputError(f"{path}: the file is empty (0 bytes)")
    return data


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """Add the file's name to an `InputError` of the block if the message lacks the name."""
    try:
        yield
    except InputError as error:
        if str(path) in str(error):
            raise
        raise InputError(f"{path}: {error}") from error
