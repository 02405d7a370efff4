"""The output folder of a run: only one process writes to it at a time."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from eyehand.errors import InputError

_held: dict[tuple[int, int], int] = {}
"""Device and inode of a folder → the descriptor that holds its lock, in this process."""


def claim_folder(folder: Path) -> None:
    """Create an output folder with its parents, and lock it until the command ends.

    The system releases the lock when the process ends, also when it is killed. No file is left. On
    file systems without locks, as some network folders, nothing is locked.

    Raises
    ------
    InputError
        If the folder cannot be created, or another process writes to it.
    """
    # Imported here: it loads OpenCV, which the command line does not need.
    from .output_files import make_folder

    make_folder(folder)
    try:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return
    status = os.fstat(descriptor)
    key = (status.st_dev, status.st_ino)
    if key in _held:
        os.close(descriptor)
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(descriptor)
        raise InputError(
            f"another run writes to {folder}: wait for its end, or name another folder with --out"
        ) from error
    except OSError:
        pass
    _held[key] = descriptor


def release_folders() -> None:
    """Release the locks of all folders of this process."""
    while _held:
        os.close(_held.popitem()[1])
