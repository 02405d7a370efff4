"""The most accurate settings for a time budget, from a front that was measured once and stored."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from eyehand.errors import InputError

from .options import SegmentationOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

STORED_FRONT = Path(__file__).parent / "front.json"
"""What ``eyehand chart segmentation --store`` wrote last."""
SCHEMA = "eyehand.segmentation_front/1"


@dataclass(frozen=True)
class FrontPoint:
    """One setting that no other beats in both time and accuracy."""

    name: str
    """How it differs from the default, in words."""
    dials: dict[str, int | bool]
    """Options that were turned, by field name, all of them; the others keep their defaults."""
    median_ms: float
    """Median time of a 640x480 frame on the machine of the stored front, ms."""
    overlap_f_pct: float
    """Mean overlap F on the frames of the stored front, per cent."""
    boundary_f_pct: float
    """Mean boundary F, per cent."""
    found_pct: float
    """Mean share of objects with an own F above 0.75, per cent."""

    def options(self) -> SegmentationOptions:
        """Turn the dials."""
        return replace(SegmentationOptions(), **self.dials)


@dataclass(frozen=True)
class StoredFront:
    """A Pareto front of time against overlap F, and what it was measured on."""

    points: tuple[FrontPoint, ...]
    """By rising time."""
    default_ms: float
    """Median time of the default settings in the same run, ms."""
    data: str
    """Frames it was measured on, in words."""
    seed: int | None
    """Seed of those frames."""
    frames: int
    """How many."""
    machine: str
    """Machine it was measured on."""

    def as_json(self) -> dict[str, Any]:
        """Give what :func:`read_front` reads back."""
        rows = [vars(point) for point in self.points]
        return {"schema": SCHEMA, **vars(self), "points": rows}


def options_for_budget(
    milliseconds: float,
    *,
    slower: float = 1.0,
    threads: int = 2,
    front: StoredFront | None = None,
) -> SegmentationOptions:
    """Pick the most accurate stored settings that keep to a time budget.

    Parameters
    ----------
    milliseconds
        Longest median time of a 640x480 frame, ms. Single frames vary about the median, so leave
        room for them.
    slower
        How many times slower this machine is than that of the stored front; below 1 when it is
        faster. ``eyehand chart segmentation --quick`` measures and prints it.
    threads
        Most threads the segmentation may take, >= 1.
    front
        Points to choose from; the stored ones by default.

    Returns
    -------
    SegmentationOptions
        Settings whose stored time times `slower` is at most `milliseconds`.

    Raises
    ------
    InputError
        If a value is not positive or no point is that fast; the message tells what the fastest
        one costs.
    """
    if not 0 < milliseconds < float("inf"):
        raise InputError(f"a time budget must be finite and > 0 ms, got {milliseconds}")
    if not 0 < slower < float("inf"):
        raise InputError(f"slower must be a finite factor > 0, got {slower}")
    if threads < 1:
        raise InputError(f"threads must be >= 1, got {threads}")
    front = read_front() if front is None else front
    allowed = [point for point in front.points if point.dials.get("threads", 1) <= threads]
    if not allowed:
        raise InputError(f"no stored setting of the segmentation runs on {threads} threads")
    affordable = [point for point in allowed if point.median_ms * slower <= milliseconds]
    if not affordable:
        raise InputError(_too_little(milliseconds, slower, allowed))
    return max(affordable, key=lambda point: point.overlap_f_pct).options()


def read_front(path: Path = STORED_FRONT) -> StoredFront:
    """Read a stored front.

    Raises
    ------
    InputError
        If the file is missing or no front; the message names the command that makes one.
    """
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        if stored.pop("schema") != SCHEMA:
            raise InputError(f"{path} is not a {SCHEMA}: make it with {_HOW}")
        points = tuple(FrontPoint(**row) for row in stored.pop("points"))
        return StoredFront(points, **stored)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot read a front from {path}: make it with {_HOW}") from error


_HOW = "eyehand chart segmentation --store"


def _too_little(milliseconds: float, slower: float, points: Sequence[FrontPoint]) -> str:
    fastest = min(points, key=lambda point: point.median_ms)
    machine = f", {slower:g} times the stored {fastest.median_ms:.3g} ms" if slower != 1 else ""
    return (
        f"no segmentation is as fast as {milliseconds:g} ms: the fastest, {fastest.name}, takes "
        f"{fastest.median_ms * slower:.3g} ms{machine} (overlap F {fastest.overlap_f_pct:.1f} %)"
    )
