"""Compiled kernels that are older than the code they were compiled from.

numba keeps compiled kernels in `__pycache__` and compares each with its own source file only. A
kernel contains the code of the kernels that it calls, and the constants that it imports. Both may
stand in other files.
"""

import re
import time
from contextlib import suppress
from pathlib import Path

KERNEL_PACKAGES = ("apps", "control", "data_synth", "grasping", "perception", "tactile")
"""No kernel calls a kernel of another one of these packages."""
IMPORT = re.compile(r"^from (\.+)([\w.]+) import (\([^)]*\)|.*)", re.MULTILINE)
"""A relative import: dots, module and names."""
CONSTANT = re.compile(r"\b[A-Z][A-Z0-9_]+\b")


def forget_stale_kernels(root: Path) -> list[Path]:
    """Delete the compiled kernels of each package that are older than its newest kernel source.

    Files from which kernel sources import constants count as kernel sources. numba compiles the
    kernels again when they are called. Takes about 20 ms.

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
        sources.update([file for source in sources for file in _constants_of(source)])
        newest = max((_written(source) for source in sources), default=0)
        stale += [index for index, at in written.items() if 0 < at < newest]
    for index in stale:
        # Without the right to write, numba keeps its kernels elsewhere.
        with suppress(OSError):
            index.unlink(missing_ok=True)
    return [index for index in stale if not index.exists()]


def _constants_of(source: Path) -> list[Path]:
    """Return the files of the package from which a source imports constants."""
    try:
        text = source.read_text(encoding="utf-8", errors="ignore")
    except OSError:
        return []
    return [
        source.parents[len(dots) - 1] / f"{module.replace('.', '/')}.py"
        for dots, module, names in IMPORT.findall(text)
        if CONSTANT.search(names)
    ]


def _written(file: Path) -> int:
    """Return when a file was written in ns; 0 if it cannot be read, or if its time lies ahead."""
    try:
        at = file.stat().st_mtime_ns
    except OSError:  # for example deleted by another process in this moment
        return 0
    return at if at <= time.time_ns() else 0
