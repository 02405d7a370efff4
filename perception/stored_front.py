"""Stored Pareto fronts of time against accuracy, and the choice of a point by time budget."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from eyehand.errors import InputError


class TimedPoint(Protocol):
    """One setting of a stage's options on the Pareto front."""

    @property
    def name(self) -> str:
        """Difference from the default settings, in words."""
        ...

    @property
    def median_ms(self) -> float:
        """Median time on the machine of the stored front, ms."""
        ...


Point = TypeVar("Point", bound=TimedPoint)


@dataclass(frozen=True)
class StoredFront(Generic[Point]):
    """A Pareto front of time against accuracy, with the data and machine of its measurement."""

    points: tuple[Point, ...]
    """Points in order of increasing time."""
    default_ms: float
    """Median time of the default settings in the same run, ms."""
    data: str
    """Description of the data that it was measured on."""
    seed: int | None
    """Seed of the data."""
    frames: int
    """Number of frames or clouds."""
    machine: str
    """Machine that it was measured on."""


@dataclass(frozen=True)
class FrontFormat(Generic[Point]):
    """File format of one stage's front."""

    schema: str
    """Name and version of the format, as the file states it."""
    point: type[Point]
    """Class of the front's points."""
    command: str
    """Command that writes such a file, for error messages."""

    def text(self, front: StoredFront[Point]) -> str:
        """Return the file's text for a front, which :meth:`read` reads back."""
        rows = [vars(point) for point in front.points]
        stored = {"schema": self.schema, **vars(front), "points": rows}
        return json.dumps(stored, indent=1, allow_nan=False) + "\n"

    def read(self, path: Path) -> StoredFront[Point]:
        """Read a front from a file.

        Raises
        ------
        InputError
            If the file is missing or is no front. The message names the command that writes one.
        """
        try:
            stored = json.loads(path.read_text(encoding="utf-8"))
            if stored.pop("schema") != self.schema:
                raise InputError(f"{path} is not a {self.schema}: make it with {self.command}")
            points = tuple(self.point(**row) for row in stored.pop("points"))
            return StoredFront(points, **stored)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(
                f"cannot read a front from {path}: make it with {self.command}"
            ) from error


def affordable(
    points: Sequence[Point],
    milliseconds: float,
    slower: float,
    stage: str,
    accuracy: Callable[[Point], str],
) -> list[Point]:
    """Select the points that keep to a time budget.

    Parameters
    ----------
    points
        Points of a front, at least one.
    milliseconds
        Maximum median time, ms.
    slower
        Factor by which this machine is slower than the machine of the stored front. It is below 1
        for a faster machine.
    stage
        Name of the stage, for error messages.
    accuracy
        Function that describes a point's accuracy, for error messages.

    Returns
    -------
    list
        Points whose stored time times `slower` is at most `milliseconds`, at least one.

    Raises
    ------
    InputError
        If a value is not positive or no point is fast enough. The message states the time of the
        fastest point.
    """
    if not 0 < milliseconds < float("inf"):
        raise InputError(f"a time budget must be finite and > 0 ms, got {milliseconds}")
    if not 0 < slower < float("inf"):
        raise InputError(f"slower must be a finite factor > 0, got {slower}")
    kept = [point for point in points if point.median_ms * slower <= milliseconds]
    if kept:
        return kept
    fastest = min(points, key=lambda point: point.median_ms)
    machine = f", {slower:g} times the stored {fastest.median_ms:.3g} ms" if slower != 1 else ""
    raise InputError(
        f"no {stage} is as fast as {milliseconds:g} ms: the fastest, {fastest.name}, takes "
        f"{fastest.median_ms * slower:.3g} ms{machine} ({accuracy(fastest)})"
    )
