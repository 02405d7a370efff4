"""Describe the machine of a measurement in one line."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

CPU_INFO = Path("/proc/cpuinfo")
"""File in which Linux names the processor. Other systems use `platform.processor`."""


def machine_line() -> str:
    """Return processor, usable cores, and versions of Python, NumPy and numba in one line."""
    return (
        f"{processor_name()}, {core_count()} cores, "
        f"Python {platform.python_version()}, NumPy {metadata.version('numpy')}, "
        f"numba {metadata.version('numba')}"
    )


def processor_name() -> str:
    """Return the name of the processor without trade marks."""
    name = platform.processor() or platform.machine()
    if CPU_INFO.is_file():
        for line in CPU_INFO.read_text(errors="replace").splitlines():
            if line.startswith("model name"):
                name = line.partition(":")[2]
                break
    for mark in ("(R)", "(TM)", "(r)", "(tm)", "CPU"):
        name = name.replace(mark, " ")
    return " ".join(name.split())


def core_count() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
