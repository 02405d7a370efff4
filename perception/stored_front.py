"""Fronts of time against accuracy that were measured once, and what a time budget buys of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path


class TimedPoint(Protocol):
    """One setting of a stage's options that no other beats in both time and accuracy."""

    @property
    def name(self) -> str:
        """How it differs from the default, in words."""
        ...

    @property
    def median_ms(self) -> float:
        """Median time on the machine of the stored front, ms."""
        ...


Point = TypeVar("Point", bound=TimedPoint)


@dataclass(frozen=True)
class StoredFront(Generic[Point]):
    """A Pareto front of time against accuracy, and what it was measured on."""

    points: tuple[Point, ...]
    """By rising time."""
    default_ms: float
    """Median time of the default settings in the same run, ms."""
    data: str
    """What it was measured on, in words."""
    seed: int | None
    """Seed of that."""
    frames: int
    """How many frames, or clouds."""
    machine: str
    """Machine it was measured on."""


@dataclass(frozen=True)
class FrontFormat(Generic[Point]):
    """How a stage's front is kept in a file."""

    schema: str
    """Name and version that the file says."""
    point: type[Point]
    """What its rows are."""
    command: str
    """What makes one, for messages."""

    def text(self, front: StoredFront[Point]) -> str:
        """Write a front as :meth:`read` reads it back."""
        rows = [vars(point) for point in front.points]
        stored = {"schema": self.schema, **vars(front), "points": rows}
        return json.dumps(stored, indent=1, allow_nan=False) + "\n"

    def read(self, path: Path) -> StoredFront[Point]:
        """Read a front.

        Raises
        ------
        InputError
            If the file is missing or no front; the message names the command that makes one.
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
    """Points that keep to a time budget.

    Parameters
    ----------
    points
        At least one.
    milliseconds
        Longest median time, ms.
    slower
        How many times slower this machine is than that of the stored front; below 1 when it is
        faster.
    stage
        What takes the time, for messages.
    accuracy
        Tells a point's accuracy, for messages.

    Returns
    -------
    list
        Those whose stored time times `slower` is at most `milliseconds`, at least one.

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
    kept = [point for point in points if point.median_ms * slower <= milliseconds]
    if kept:
        return kept
    fastest = min(points, key=lambda point: point.median_ms)
    machine = f", {slower:g} times the stored {fastest.median_ms:.3g} ms" if slower != 1 else ""
    raise InputError(
        f"no {stage} is as fast as {milliseconds:g} ms: the fastest, {fastest.name}, takes "
        f"{fastest.median_ms * slower:.3g} ms{machine} ({accuracy(fastest)})"
    )
