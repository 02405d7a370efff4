"""Compiled kernels that are older than the code they were compiled from.

numba keeps compiled kernels in `__pycache__` and compares each with its own source file only. A
kernel contains the code of the kernels that it calls, which may stand in other files.
"""

import time
from pathlib import Path

KERNEL_PACKAGES = ("apps", "control", "data_synth", "grasping", "perception", "tactile")
"""No kernel calls a kernel of another one of these packages."""


def forget_stale_kernels(root: Path) -> list[Path]:
    """Delete the compiled kernels of each package that are older than its newest kernel source.

    numba compiles them again when they are called. Takes about 5 ms.

    Parameters
    ----------
    root : Path
        Folder that holds the packages.

    Returns
    -------
    list of Path
        The deleted index files.
    """
    stale: list[Path] = []
    for package in KERNEL_PACKAGES:
        written = {index: _written(index) for index in (root / package).rglob("__pycache__/*.nbi")}
        sources = {index.parent.parent / f"{index.name.partition('.')[0]}.py" for index in written}
        newest = max((_written(source) for source in sources), default=0)
        stale += [index for index, at in written.items() if 0 < at < newest]
    for index in stale:
        try:
            index.unlink(missing_ok=True)
        except OSError:  # a folder without the right to write: numba keeps its kernels elsewhere
            return []
    return stale


def _written(file: Path) -> int:
    """Return when a file was written in ns; 0 if it is gone, or if its time lies ahead."""
    try:
        at = file.stat().st_mtime_ns
    except FileNotFoundError:  # deleted by another process in this moment
        return 0
    return at if at <= time.time_ns() else 0
