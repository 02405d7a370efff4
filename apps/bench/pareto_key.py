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
"""Minimum decrease of log(100 - accuracy) from one named point to the next. Lower differences are
chance."""
MIN_NUMBER_DISTANCE = 0.17
"""Minimum distance of two numbers, inches."""
MAX_NAMES = 8
"""Maximum number of named points. Those with the largest gains are named."""
BESIDE_PT = (11.0, -10.0)
"""Offset of a number from its chart point if another number covers the point, to the right and up
(negative is down), in 1/72 inch."""
KEY_LINE, KEY_INDENT = 0.21, 0.2
"""Height of a line of the key and width of its number, inches."""
MAX_SHORT = 56
"""Maximum length of a text of the key that fits into half the width."""
KEY_FOOT, KEY_GAP = 0.52, 0.12
"""Height of the footer under the key, and free space above the key, inches."""


@dataclass(frozen=True)
class ChartPoint:
    """One setting of a method, with its measured time and accuracy."""

    name: str
    """Name for the reader."""
    time_ms: float
    """Median time, ms."""
    accuracy_pct: float
    """Accuracy as drawn, per cent."""
    true_pct: float | None = None
    """True accuracy if the point is drawn lower because the axis ends below it, per cent; else
    None."""

    @property
    def written_pct(self) -> float:
        """Accuracy for text, per cent."""
        return self.accuracy_pct if self.true_pct is None else self.true_pct


@dataclass(frozen=True)
class ChartView:
    """Ranges of the axes."""

    times_ms: tuple[float, float]
    """Range of the time axis, ms."""
    accuracies_pct: tuple[float, float]
    """Range of the accuracy axis, per cent."""

    def place(self, point: ChartPoint) -> tuple[float, float]:
        """Return the position of a point on the panel, inches from its lower left corner."""
        first, last = self.times_ms
        low, high = self.accuracies_pct
        across = log(point.time_ms / first) / log(last / first)
        up = log((100 - low) / (100 - point.accuracy_pct)) / log((100 - low) / (100 - high))
        return (WIDTH - LEFT - MARGIN) * across, (HEIGHT - HEADER - FOOT) * up


def fit_view(points: Sequence[ChartPoint], min_shown_pct: float) -> ChartView:
    """Compute axis ranges that contain all points of at least `min_shown_pct`.

    There is space above the best point for its label. Less accurate points may lie below the axis.
    """
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
    """Select the points of the front to be numbered.

    They have a clear gain, and no other number covers them. The gain is the decrease of
    log(100 - accuracy), which is the distance on the accuracy axis.

    Parameters
    ----------
    own
        All settings of our method.
    front
        Indices of the points on the front, in order of increasing time.
    default
        The default setting, which is not numbered.
    view
        Ranges of the axes.
    """
    gains = [-log(100 - point.accuracy_pct) for point in own]
    kept, min_gain = list(front), MIN_NAMED_GAIN
    # Raise the minimum gain until at most MAX_NAMES points remain.
    while len(kept) > MAX_NAMES or min_gain == MIN_NAMED_GAIN:
        kept, min_gain = thin_front(gains, front, min_gain), 1.2 * min_gain
    # The most accurate point has priority, then the fastest.
    selected: list[int] = []
    for index in dict.fromkeys([*kept[-1:], *kept]):
        place = view.place(own[index])
        others = [default, *(own[other] for other in selected)]
        if all(dist(place, view.place(other)) >= MIN_NUMBER_DISTANCE for other in others):
            selected.append(index)
    return [own[index] for index in kept if index in selected]


def draw_numbers(
    axes: Axes,
    named: Sequence[ChartPoint],
    front: Sequence[ChartPoint],
    default: ChartPoint,
    view: ChartView,
) -> None:
    """Write the numbers of the key on their points.

    A number is written beside its point if another number or the default covers the point.
    """
    taken = [default]
    for number, point in enumerate(named, start=1):
        place = view.place(point)
        covering = sum(dist(place, view.place(other)) < MIN_NUMBER_DISTANCE for other in taken)
        taken.append(point)
        on_front = point in front
        style: dict[str, Any] = {"size": 7.5, "weight": "bold", "textcoords": "offset points"}
        spot = (point.time_ms, point.accuracy_pct)
        if covering:
            style |= {"color": BLUE, "ha": "left", "va": "center_baseline", "zorder": 5.5}
            axes.annotate(
                str(number), spot, xytext=(BESIDE_PT[0] * covering, BESIDE_PT[1]), **style
            )
            continue
        axes.plot(
            *spot,
            "o",
            color=BLUE if on_front else "white",
            markersize=11.5,
            markeredgecolor="white" if on_front else BLUE,
            markeredgewidth=1.0,
            zorder=4.5,
        )
        style |= {"color": "white" if on_front else BLUE, "ha": "center", "va": "center_baseline"}
        axes.annotate(str(number), spot, xytext=(0, -0.3), zorder=4.6, **style)


def write_key(figure: Figure, named: Sequence[ChartPoint]) -> None:
    """Write the number, name, accuracy and time of each numbered point above the footer.

    The key has two columns, or one if a text is too long for half the width.
    """
    height = figure.get_size_inches()[1]
    lines = key_lines(named)
    for index, point in enumerate(named):
        column, line = divmod(index, lines)
        left = MARGIN + column * (WIDTH - 2 * MARGIN) / 2
        up = (KEY_FOOT + (lines - line) * KEY_LINE) / height
        style: dict[str, Any] = {"size": TEXT - 0.5, "va": "top", "ha": "left"}
        figure.text(left / WIDTH, up, str(index + 1), color=BLUE, weight="bold", **style)
        figure.text((left + KEY_INDENT) / WIDTH, up, _key_text(point), color=INK, **style)


def key_lines(named: Sequence[ChartPoint]) -> int:
    """Return the number of lines of the key."""
    long = any(len(_key_text(point)) > MAX_SHORT for point in named)
    return len(named) if long else -(-len(named) // 2)


def _key_text(point: ChartPoint) -> str:
    return f"{point.name}: {point.written_pct:.1f} %, {short_time(point)}"


def short_time(point: ChartPoint) -> str:
    """Format the time of a point with two significant digits."""
    return format_time(float(f"{point.time_ms:.2g}"))
