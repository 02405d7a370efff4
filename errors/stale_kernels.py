"""Compiled kernels of former code.

numba keeps compiled kernels in `__pycache__`, or in the folder that `NUMBA_CACHE_DIR` names. It
compares each with its own source file only. A kernel contains the code of the kernels that it
calls, and the constants that it imports. Both may stand in other files.
"""

import hashlib
import json
import os
import re
from contextlib import suppress
from pathlib import Path

KERNEL_PACKAGES = ("apps", "control", "data_synth", "grasping", "perception", "tactile")
"""No kernel calls a kernel of another one of these packages."""
RECORD = "kernel_sources.json"
"""File in the cache of a package's folder: time and size of each source at the last start."""
IMPORT = re.compile(r"^from (\.+)([\w.]+) import (\([^)]*\)|.*)", re.MULTILINE)
"""A relative import: dots, module and names."""
CONSTANT = re.compile(r"\b[A-Z][A-Z0-9_]+\b")


def forget_stale_kernels(root: Path) -> list[Path]:
    """Delete the compiled kernels of each package of which a kernel source has changed.

    Files from which kernel sources import constants count as kernel sources. A source has changed
    if its time or size differs from the last start: copies and archives keep old times, so a new
    source may be older than its kernel. numba compiles the kernels again when they are called.
    Takes about 10 ms.

    Parameters
    ----------
    root : Path
        Folder that holds the packages.

    Returns
    -------
    list of Path
        The deleted index files.
    """
    deleted: list[Path] = []
    for package in KERNEL_PACKAGES:
        folder = root / package
        # Without the right to write, numba keeps its kernels elsewhere. Another process may delete
        # a file in this moment.
        with suppress(OSError):
            record = _cache(folder) / RECORD
            stamps = {_name(file, folder): _stamp(file) for file in folder.rglob("*.py")}
            before = _read(record)
            if stamps == before:
                continue
            kept = {
                index: folder / name
                for name in {Path(name).parent for name in stamps}
                for index in _cache(folder / name).glob("*.nbi")
            }
            names = {_name(source, folder) for source in _kernel_sources(kept)}
            if any(stamps.get(name) != before.get(name) for name in names):
                for index in kept:
                    index.unlink(missing_ok=True)
                deleted += kept
            _write(record, stamps)
    return deleted


def _cache(folder: Path) -> Path:
    """Return the folder in which numba keeps the kernels of the sources in a folder."""
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        digest = hashlib.sha1(str(folder).encode(), usedforsecurity=False).hexdigest()
        return Path(chosen) / f"{folder.name}_{digest}"
    return folder / "__pycache__"


def _kernel_sources(kept: dict[Path, Path]) -> set[Path]:
    """Return the sources of compiled kernels, and the files from which these import constants.

    `kept` maps the index file of each kernel to the folder of its source.
    """
    sources = {folder / f"{index.name.partition('.')[0]}.py" for index, folder in kept.items()}
    files = set(sources)
    for source in sources:
        text = source.read_text(encoding="utf-8", errors="ignore") if source.exists() else ""
        for dots, module, names in IMPORT.findall(text):
            if CONSTANT.search(names):
                files.add(source.parents[len(dots) - 1] / f"{module.replace('.', '/')}.py")
    return files


def _name(file: Path, folder: Path) -> str:
    """Return the path of a file in the folder of its package."""
    return file.relative_to(folder).as_posix()


def _stamp(file: Path) -> list[int]:
    """Return the time in ns and the size in bytes of a file; nothing if it is gone."""
    try:
        found = file.stat()
    except OSError:
        return []
    return [found.st_mtime_ns, found.st_size]


def _read(record: Path) -> dict[str, list[int]]:
    """Return the stamps of the last start; empty without a record."""
    try:
        return json.loads(record.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def _write(record: Path, stamps: dict[str, list[int]]) -> None:
    """Write the record completely or not at all."""
    record.parent.mkdir(parents=True, exist_ok=True)
    part = record.with_suffix(f".{os.getpid()}")
    part.write_text(json.dumps(stamps), encoding="utf-8")
    part.replace(record)
