"""The machine that a figure was measured on, in one line: a time means nothing without it."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

CPU_INFO = Path("/proc/cpuinfo")
"""Where Linux names the processor; elsewhere the platform's own word for it has to do."""


def machine_line() -> str:
    """Processor, cores that this process may use, Python, NumPy and numba, in one line."""
    return (
        f"{processor_name()}, {core_count()} cores, "
        f"Python {platform.python_version()}, NumPy {metadata.version('numpy')}, "
        f"numba {metadata.version('numba')}"
    )


def processor_name() -> str:
    """Name of the processor, without trade marks."""
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
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
