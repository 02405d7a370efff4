"""What every `eyehand chart` command makes of measurements: chart, table, rows, stored front."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.table import Table

from eyehand.apps.console import say, show
from eyehand.perception import StoredFront
from eyehand.perception.io import atomic_write

from .chart_style import write_chart
from .machine import machine_line
from .pareto import simplest_front
from .pareto_chart import BaselineCurve, ChartPoint, ParetoChart

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from matplotlib.figure import Figure

    from eyehand.perception import FrontFormat

    from .chart_style import Provenance
    from .comparison import Method, MethodResult
    from .dials import DialSetting

SAME_TIME = 1.05
"""Factor by which the same setting's times differ between runs on a busy machine."""


@dataclass(frozen=True)
class Measured:
    """Time and figures of one method over all cases."""

    method: Method[Any, Any]
    median_ms: float
    """Median over cases of the fastest round's wall time, ms."""
    median_cpu_ms: float
    """The same of processor time, of all threads: less shaken by what else runs, ms."""
    figures: Mapping[str, float]
    """Accuracy figures by name, with the unit as suffix."""

    @classmethod
    def of(cls, result: MethodResult[Any, Any, Any], figures: Mapping[str, float]) -> Measured:
        """Take the median times of a comparison's result, and add figures."""
        wall, cpu = (round(float(np.median(ms)), 3) for ms in (result.wall_ms, result.cpu_ms))
        return cls(result.method, wall, cpu, figures)


@dataclass(frozen=True)
class ChartWords:
    """What a stage's chart is about."""

    title: str
    gain: str
    """Name of the figure that is charted against time, per cent."""
    accuracy: str
    """The same for the axis."""
    same_gain_pct: float
    """Difference of it that says nothing: its standard error over the usual cases."""
    columns: Mapping[str, str]
    """Figures of the table by their name, with their headings."""
    caption: str
    """What the headings mean."""
    min_shown_pct: float
    """Worse points are in the table only."""


@dataclass(frozen=True)
class FrontPlace:
    """Where a stage keeps its front for time budgets."""

    form: FrontFormat[Any]
    """How it is kept."""
    path: Path
    """In which file."""
    options: str
    """Name of the class that reads it."""


@dataclass(frozen=True)
class DialChart:
    """Own settings and baselines, measured on the same cases."""

    words: ChartWords
    settings: Sequence[DialSetting[Any]]
    """Own settings, simplest first: the first is the default."""
    own: Sequence[Measured]
    """What each of them reached."""
    others: Sequence[Measured]
    """What baselines reached."""
    made: Provenance
    """Where the figures come from."""

    @property
    def front(self) -> list[int]:
        """Own settings that are the best for their time beyond chance, by rising time."""
        times = [result.median_ms for result in self.own]
        gains = [result.figures[self.words.gain] for result in self.own]
        return simplest_front(times, gains, SAME_TIME, self.words.same_gain_pct)

    def rows(self) -> list[dict[str, Any]]:
        """Give all figures, the own settings first, a row each."""
        front = self.front
        own = [
            _row(result, not setting.dials, index in front) | setting.all_dials()
            for index, (result, setting) in enumerate(zip(self.own, self.settings, strict=True))
        ]
        return own + [_row(result, False, False) for result in self.others]

    def figure(self) -> Figure:
        """Draw the chart."""
        subtitle = "blue: every dial, alone and crossed; line: the best for its time, beyond chance"
        if self.others:
            subtitle += "; grey: other ways"
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
        table = Table(
            title="the Pareto front, the default, and each baseline at its best",
            title_justify="left",
            box=box.SIMPLE_HEAD,
            pad_edge=False,
            caption=self.words.caption,
            caption_justify="left",
        )
        for name in ("method", "setting"):
            table.add_column(name)
        for name in ("ms", *self.words.columns.values()):
            table.add_column(name, justify="right")
        front = self.front
        for index in sorted({0, *front}, key=lambda index: self.own[index].median_ms):
            style = None if index in front else "dim"
            table.add_row(*self._cells(self.own[index]), style=style)
        table.add_section()
        for curve in self._curves().values():
            table.add_row(*self._cells(max(curve, key=lambda r: r.figures[self.words.gain])))
        return table

    def publish(self, picture: Path, place: FrontPlace, *, store: bool, json: bool) -> float | None:
        """Write the picture and its figures, print the table, and keep the front where asked to.

        Parameters
        ----------
        picture
            The chart, .png; its figures go into the .csv beside it.
        place
            Where the front is kept.
        store
            Whether to keep this one.
        json
            Whether stdout belongs to JSON.

        Returns
        -------
        float or None
            How many times longer the default takes here than for the stored front; None where
            there is none.

        Raises
        ------
        InputError
            If a file or the installed package cannot be written to.
        """
        write_chart(self.figure(), picture, self.rows())
        show(self.table(), json_wanted=json)
        say(f"chart: {picture}, figures: {picture.with_suffix('.csv')}")
        if store:
            self.store(place)
        if not place.path.is_file():
            return None
        slower = round(self.own[0].median_ms / place.form.read(place.path).default_ms, 3)
        say(
            f"here, on these {self.made.each}s, the default takes {slower:.2f} times as long as in "
            f"the stored front: {place.options}.for_budget(ms, slower={slower:.2f})"
        )
        return slower

    def store(self, place: FrontPlace) -> None:
        """Write the front for time budgets: its points get name, dials, median_ms, all figures."""
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
