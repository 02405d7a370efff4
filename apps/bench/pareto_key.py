"""The numbered points of a Pareto chart, and the key that names them."""

from __future__ import annotations

from dataclasses import dataclass
from math import dist, log
from typing import TYPE_CHECKING, Any

from .chart_style import BLUE, FOOT, HEADER, INK, LEFT, MARGIN, TEXT, WIDTH, format_time
from .pareto import thin_front

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 5.2
"""Height of the figure without its key, inches."""
MIN_NAMED_GAIN = 0.03
"""A named point has a log error smaller by at least this; smaller differences are chance."""
NUMBER_SIZE = 0.17
"""Minimum distance of two numbers, inches."""
MAX_NAMES = 8
"""Most named points of the front: those with the largest gains."""
BESIDE_PT = (11.0, -10.0)
"""Offset of a number whose point is covered by another: right and down, points."""
KEY_LINE, KEY_INDENT = 0.21, 0.2
"""Height of a line of the key and width of its number, inches."""
KEY_FOOT, KEY_GAP = 0.52, 0.12
"""Height of the footer under the key, and free space above the key, inches."""


@dataclass(frozen=True)
class ChartPoint:
    """One measured setting."""

    name: str
    """Name in words."""
    time_ms: float
    """Median time, ms."""
    accuracy_pct: float
    """Accuracy as drawn, per cent."""
    true_pct: float | None = None
    """Accuracy for text when the point is drawn at another level, per cent."""

    @property
    def written_pct(self) -> float:
        """Accuracy for text, per cent."""
        return self.accuracy_pct if self.true_pct is None else self.true_pct


@dataclass(frozen=True)
class ChartView:
    """Ranges of the axes."""

    times_ms: tuple[float, float]
    shares_pct: tuple[float, float]

    def place(self, point: ChartPoint) -> tuple[float, float]:
        """Return the position of a point on the panel, inches from its lower left corner."""
        first, last = self.times_ms
        low, high = self.shares_pct
        across = log(point.time_ms / first) / log(last / first)
        up = log((100 - low) / (100 - point.accuracy_pct)) / log((100 - low) / (100 - high))
        return (WIDTH - LEFT - MARGIN) * across, (HEIGHT - HEADER - FOOT) * up


def fit_view(points: Sequence[ChartPoint], min_shown_pct: float) -> ChartView:
    """Choose axes that hold all points, with space above the best one for its label."""
    times = [point.time_ms for point in points]
    best = max(point.accuracy_pct for point in points)
    worst = min(max(point.accuracy_pct, min_shown_pct) for point in points)
    return ChartView(
        (0.75 * min(times), 1.35 * max(times)),
        (worst - 0.15 * (100 - worst), 100 - 0.55 * (100 - best)),
    )


def select_named(
    own: Sequence[ChartPoint], front: Sequence[int], default: ChartPoint, view: ChartView
) -> list[ChartPoint]:
    """Select points of the front with a clear gain and space for a number, except the default.

    The gain is the decrease of the log error, as the axis shows it.
    """
    gains = [-log(100 - point.accuracy_pct) for point in own]
    kept, least = list(front), MIN_NAMED_GAIN
    while len(kept) > MAX_NAMES or least == MIN_NAMED_GAIN:
        kept, least = thin_front(gains, front, least), 1.2 * least
    # The most accurate point has priority, then the fastest.
    chosen: list[int] = []
    for index in dict.fromkeys([*kept[-1:], *kept]):
        place = view.place(own[index])
        others = [default, *(own[other] for other in chosen)]
        if all(dist(place, view.place(other)) >= NUMBER_SIZE for other in others):
            chosen.append(index)
    return [own[index] for index in kept if index in chosen]


def draw_numbers(
    axes: Axes,
    named: Sequence[ChartPoint],
    front: Sequence[ChartPoint],
    default: ChartPoint,
    view: ChartView,
) -> None:
    """Write the numbers of the key on their points, or beside points that another one covers."""
    taken = [default]
    for number, point in enumerate(named, start=1):
        place = view.place(point)
        under = sum(dist(place, view.place(other)) < NUMBER_SIZE for other in taken)
        taken.append(point)
        full = point in front
        style: dict[str, Any] = {"size": 7.5, "weight": "bold", "textcoords": "offset points"}
        spot = (point.time_ms, point.accuracy_pct)
        if under:
            style |= {"color": BLUE, "ha": "left", "va": "center_baseline", "zorder": 5.5}
            axes.annotate(str(number), spot, xytext=(BESIDE_PT[0] * under, BESIDE_PT[1]), **style)
            continue
        axes.plot(
            *spot,
            "o",
            color=BLUE if full else "white",
            markersize=11.5,
            markeredgecolor="white" if full else BLUE,
            markeredgewidth=1.0,
            zorder=4.5,
        )
        style |= {"color": "white" if full else BLUE, "ha": "center", "va": "center_baseline"}
        axes.annotate(str(number), spot, xytext=(0, -0.3), zorder=4.6, **style)


def write_key(figure: Figure, named: Sequence[ChartPoint]) -> None:
    """Write number, name and figures of the numbered points in two columns above the footer."""
    height = figure.get_size_inches()[1]
    lines = key_lines(len(named))
    for index, point in enumerate(named):
        column, line = divmod(index, lines)
        left = MARGIN + column * (WIDTH - 2 * MARGIN) / 2
        text = f"{point.name}: {point.written_pct:.1f} %, {short_time(point)}"
        up = (KEY_FOOT + (lines - line) * KEY_LINE) / height
        style: dict[str, Any] = {"size": TEXT - 0.5, "va": "top", "ha": "left"}
        figure.text(left / WIDTH, up, str(index + 1), color=BLUE, weight="bold", **style)
        figure.text((left + KEY_INDENT) / WIDTH, up, text, color=INK, **style)


def short_time(point: ChartPoint) -> str:
    """Format the time of a point with two significant digits."""
    return format_time(float(f"{point.time_ms:.2g}"))


def key_lines(names: int) -> int:
    """Return the number of lines of a key in two columns."""
    return -(-names // 2)
