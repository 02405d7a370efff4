"""A folder for compiled kernels where neither the installation nor the home folder is writable."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path

from .console import say

CACHE_VARIABLE = "NUMBA_CACHE_DIR"
"""Environment variable that numba reads. Without a writable folder numba raises an error."""


def ensure_kernel_folder(installation: Path | None = None, home: Path | None = None) -> Path | None:
    """Use a temporary folder for compiled kernels if numba finds no writable one.

    numba tries `__pycache__` beside the code, then a folder in the user's cache.

    Parameters
    ----------
    installation
        Folder of the code; default: this package's.
    home
        Folder for the user's caches; default: `$XDG_CACHE_HOME`, else `~/.cache`.

    Returns
    -------
    Path or None
        The temporary folder, removed at exit; None if none is needed.
    """
    if os.environ.get(CACHE_VARIABLE):
        return None
    if _is_writable((installation or Path(__file__).parent) / "__pycache__"):
        return None
    if home is None:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    if _is_writable(home / "numba"):
        return None
    folder = Path(tempfile.mkdtemp(prefix="eyehand_kernels_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ[CACHE_VARIABLE] = str(folder)
    say(
        "eyehand: neither the installation nor the home folder is writable, so kernels are "
        f"compiled in every run; set {CACHE_VARIABLE} to a folder that stays"
    )
    return folder


def _is_writable(folder: Path) -> bool:
    """Report whether a folder exists or can be created, and takes files."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True
