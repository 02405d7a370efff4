"""Chart, table, rows and stored front of the `eyehand chart` commands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from eyehand.apps.console import print_json, say, show, wide_table
from eyehand.errors import InputError
from eyehand.perception import FrontFormat, StoredFront
from eyehand.perception.io import atomic_write

from .chart_style import Provenance, write_chart
from .machine import machine_line
from .pareto import simplest_front
from .pareto_chart import BaselineCurve, ChartPoint, ParetoChart

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from matplotlib.figure import Figure

    from .comparison import Method, MethodResult
    from .dials import DialSetting

SAME_TIME = 1.05
"""Ratio of two run times of the same setting on a busy machine. Smaller ratios are noise."""


def check_chart_arguments(
    count_option: str, count: int | None, seed: int, *, store: bool, quick: bool
) -> None:
    """Raise InputError for arguments of a chart command that are out of range."""
    if count is not None and count < 1:
        raise InputError(f"{count_option} must be >= 1, got {count}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    if store and quick:
        raise InputError("--store needs all settings: leave --quick out")


@dataclass(frozen=True)
class Measured:
    """The time and the figures of one method over all cases."""

    method: Method[Any, Any]
    median_ms: float
    """Median over cases of the fastest round's wall time, ms."""
    median_cpu_ms: float
    """Median processor time of all threads, ms. It depends less on other load."""
    figures: Mapping[str, float]
    """Accuracy figures by name, with the unit as suffix."""

    @classmethod
    def of(cls, result: MethodResult[Any, Any, Any], figures: Mapping[str, float]) -> Measured:
        """Return the median times of a comparison result with the given figures."""
        wall, cpu = (round(float(np.median(ms)), 3) for ms in (result.wall_ms, result.cpu_ms))
        return cls(result.method, wall, cpu, figures)


@dataclass(frozen=True)
class ChartWords:
    """The words and limits of a stage's chart."""

    title: str
    gain: str
    """Name of the figure that is charted against time, in per cent."""
    accuracy: str
    """Axis label of that figure."""
    same_gain_pct: float
    """Differences up to this are noise: its standard error over the usual cases."""
    columns: Mapping[str, str]
    """Figure name → heading of its table column."""
    caption: str
    """Explanation of the headings."""
    min_shown_pct: float
    """Points below this are in the table only."""


@dataclass(frozen=True)
class FrontPlace:
    """The file in which a stage stores its front for time budgets."""

    stage: str
    """Name of the stage, for the files of the chart and the JSON schema."""
    form: FrontFormat[Any]
    """Format of the file."""
    path: Path
    """The file."""
    options: str
    """Name of the option class that reads it."""


@dataclass(frozen=True)
class DialChart:
    """Own settings and baselines, measured on the same cases."""

    words: ChartWords
    settings: Sequence[DialSetting[Any]]
    """Our settings, simplest first. The first is the default."""
    own: Sequence[Measured]
    """Measurements of our settings, in the same order."""
    others: Sequence[Measured]
    """Measurements of the baselines."""
    made: Provenance
    """Origin of the figures."""

    @property
    def front(self) -> list[int]:
        """Indices of our settings on the Pareto front beyond measurement noise, by rising time."""
        times = [result.median_ms for result in self.own]
        gains = [result.figures[self.words.gain] for result in self.own]
        return simplest_front(times, gains, SAME_TIME, self.words.same_gain_pct)

    def rows(self) -> list[dict[str, Any]]:
        """Return a row of figures per setting, ours first."""
        front = self.front
        own = [
            _row(result, not setting.dials, index in front) | setting.all_dials()
            for index, (result, setting) in enumerate(zip(self.own, self.settings, strict=True))
        ]
        return own + [_row(result, False, False) for result in self.others]

    def figure(self) -> Figure:
        """Draw the chart."""
        subtitle = "blue: every dial, alone and crossed; line: Pareto front beyond noise"
        if self.others:
            subtitle += "; grey: other methods"
        chart = ParetoChart(
            self.words.title,
            subtitle,
            [self._point(result) for result in self.own],
            self.front,
            self.words.accuracy,
            self.made,
            baselines=[
                BaselineCurve(method, tuple(self._point(result) for result in curve))
                for method, curve in self._curves().items()
            ],
            min_shown_pct=self.words.min_shown_pct,
        )
        return chart.figure()

    def table(self) -> Table:
        """Tabulate the front, the default, and each baseline at its best."""
        left = ("method", "setting")
        table = wide_table(
            "the Pareto front, the default, and each baseline at its best",
            (*left, "ms", *self.words.columns.values()),
            left=left,
            caption=self.words.caption,
        )
        front = self.front
        for index in sorted({0, *front}, key=lambda index: self.own[index].median_ms):
            style = None if index in front else "dim"
            table.add_row(*self._cells(self.own[index]), style=style)
        table.add_section()
        for curve in self._curves().values():
            table.add_row(*self._cells(max(curve, key=lambda r: r.figures[self.words.gain])))
        return table

    def publish(
        self, out: Path, place: FrontPlace, *, store: bool, json: bool, **members: Any
    ) -> float | None:
        """Write the chart and its figures, print the table, and store the front on request.

        Parameters
        ----------
        out
            Folder of the chart and of the CSV file with its figures.
        place
            File of the stored front.
        store
            Whether to replace the stored front.
        json
            Whether to print one JSON object on stdout.
        members
            Further members of the JSON object.

        Returns
        -------
        float or None
            Run time of the default here, divided by that in the stored front. None without a
            stored front.

        Raises
        ------
        InputError
            If a file or the installed package cannot be written to.
        """
        picture = out / f"{place.stage}.png"
        write_chart(self.figure(), picture, self.rows())
        show(self.table(), json_wanted=json)
        say(f"chart: {picture}, figures: {picture.with_suffix('.csv')}")
        if store:
            self.store(place)
        slower = self._slower(place)
        if json:
            members |= {"machine": machine_line(), "slower": slower, "out": str(out)}
            print_json(f"chart_{place.stage}", self.made.seed, self.rows(), **members)
        return slower

    def _slower(self, place: FrontPlace) -> float | None:
        """Compare the run time of the default with that in the stored front."""
        if not place.path.is_file():
            return None
        slower = round(self.own[0].median_ms / place.form.read(place.path).default_ms, 3)
        say(
            f"here, on these {self.made.each}s, the default takes {slower:.2f} times as long as in "
            f"the stored front: {place.options}.for_budget(ms, slower={slower:.2f})"
        )
        return slower

    def store(self, place: FrontPlace) -> None:
        """Store the front: name, dials, median_ms and all figures of each point."""
        points = tuple(
            place.form.point(
                name=self.settings[index].name,
                dials=self.settings[index].all_dials(),
                median_ms=self.own[index].median_ms,
                **self.own[index].figures,
            )
            for index in self.front
        )
        made = self.made
        stored = StoredFront(
            points, self.own[0].median_ms, made.data, made.seed, made.frames, machine_line()
        )
        with atomic_write(place.path) as temporary:
            temporary.write_text(place.form.text(stored), encoding="utf-8")
        say(f"stored {len(points)} settings for {place.options}.for_budget")

    def _curves(self) -> dict[str, list[Measured]]:
        curves: dict[str, list[Measured]] = {}
        for result in self.others:
            curves.setdefault(result.method.name, []).append(result)
        return curves

    def _point(self, result: Measured) -> ChartPoint:
        return ChartPoint(result.method.setting, result.median_ms, result.figures[self.words.gain])

    def _cells(self, result: Measured) -> tuple[str, ...]:
        return (
            result.method.name,
            result.method.setting,
            f"{result.median_ms:.1f}",
            *(f"{result.figures[key]:.1f}" for key in self.words.columns),
        )


def _row(result: Measured, default: bool, on_front: bool) -> dict[str, Any]:
    return {
        "method": result.method.name,
        "name": result.method.setting,
        "default": default,
        "front": on_front,
        "median_ms": result.median_ms,
        "median_cpu_ms": result.median_cpu_ms,
        **result.figures,
    }
