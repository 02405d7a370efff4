"""Place the names of chart points so that they cover neither each other nor a curve.

adjustText 1.4 keeps names away from points and from other names, but not from lines. On a chart
with 14 names it wrote 5 over the drawn front. This placement wrote none over it. That is why it is
written by hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from .chart_style import GREY, INK, TEXT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

Side = Literal["above", "right"]
"""Preferred side of a name."""

ANGLES: dict[Side, tuple[int, ...]] = {
    "above": (60, 75, 90, 45, 120, 30, 150, 0, 180, 330, 210, 270),
    "right": (0, 330, 30, 300, 60, 270, 90, 240, 120, 210, 150, 180),
}
"""Directions to try, best first, degrees counter-clockwise from the right."""
DISTANCES = (7.0, 10.0, 14.0, 18.0, 26.0, 36.0, 48.0, 62.0, 78.0, 96.0, 120.0, 150.0)
"""Distances from the point to try, typographic points. The smallest free one is used."""
LEADER = 11.0
"""Distance from which a thin line connects the point and its name, typographic points."""
CLEAR = 3.0
"""Free space obstacles a name, px."""
MARK = 14.0
"""Minimum distance of a leader line from the centre of another named point, px: a mark's radius."""
SAMPLE = 5.0
"""Distance of the samples that stand for a line, px."""

Box = tuple[float, float, float, float]
"""Left, bottom, right, top, px."""


@dataclass(frozen=True)
class PointLabel:
    """A name for a point."""

    x: float
    """Data coordinates of the point."""
    y: float
    text: str
    side: Side = "above"
    """Preferred side of the name."""
    colour: str = INK
    bold: bool = False


def label_points(
    axes: Axes, names: Sequence[PointLabel], lines: Sequence[Sequence[tuple[float, float]]]
) -> list[Box]:
    """Write each name near its point, with a thin line to the point when it is far.

    Names are placed in the given order. Each takes the nearest position that is free of earlier
    names, points, lines and the border of the axes. Without a free position it takes the one with
    the lowest penalty. Scales and limits of the axes must be final.

    Parameters
    ----------
    axes
        Axes to write on.
    names
        The names, the most important first.
    lines
        Everything else that is drawn, as lines through data points. A single point is a line too.

    Returns
    -------
    list of Box
        Boxes of the names, px.
    """
    drawn = [axes.transData.transform(np.asarray(line, float)) for line in lines if len(line)]
    points = axes.transData.transform([(name.x, name.y) for name in names]).reshape(-1, 2)
    boxes: list[Box] = []
    for name, point in zip(names, points, strict=True):
        own = [_sampled(line) for line in drawn if np.any(np.all(line == point, axis=1))]
        others = [_sampled(line) for line in drawn if not np.any(np.all(line == point, axis=1))]
        other_points = points[np.any(points != point, axis=1)]
        obstacles = _Obstacles(
            np.asarray(axes.bbox.extents),
            boxes,
            np.concatenate([point[None], *own]),
            np.concatenate([other_points, *others]),
            other_points,
        )
        angle, distance, box = _best_box(axes, name, point, obstacles)
        _write(axes, name, point, box, angle, distance)
        boxes.append(box)
        if distance >= LEADER:
            drawn.append(_leader(point, box))
    return boxes


@dataclass(frozen=True)
class _Obstacles:
    """The obstacles of a name, px."""

    border: NDArray[np.float64]
    names: list[Box]
    own: NDArray[np.float64]
    """Samples of the line through the named point, (n, 2)."""
    others: NDArray[np.float64]
    """Samples of all other lines, and the other named points, (n, 2)."""
    points: NDArray[np.float64]
    """The other named points, (n, 2)."""

    def penalty(self, point: NDArray[np.float64], box: Box, distance: float) -> float:
        """Return the penalty of a box; 0 is a free position."""
        left, bottom, right, top = self.border
        penalty = 200.0 * sum(_overlap(box, name) for name in self.names)
        penalty += np.count_nonzero(_contained(self.own, box))
        penalty += np.count_nonzero(_contained(self.others, box))
        if box[0] < left or box[1] < bottom or box[2] > right or box[3] > top:
            penalty += 1000.0
        if distance >= LEADER:
            line = _sampled(_leader(point, box))
            penalty += 5.0 * sum(bool(np.any(_contained(line, name))) for name in self.names)
            # A line across another point would seem to start there.
            across = np.linalg.norm(line[:, None] - self.points[None], axis=2) < MARK
            penalty += 5.0 * np.count_nonzero(across.any(axis=0))
        # A name nearer to another curve would be read as a name of that curve.
        elif _distance_to(self.others, box) < 1.5 * _distance_to(self.own, box):
            penalty += 2.0
        return float(penalty)


def _best_box(
    axes: Axes, name: PointLabel, point: NDArray[np.float64], obstacles: _Obstacles
) -> tuple[int, float, Box]:
    size, pixels = _text_size(axes, name), _pixels_per_point(axes)
    best: tuple[float, int, float, Box] | None = None
    for distance in DISTANCES:
        for angle in ANGLES[name.side]:
            box = _box(point, size, angle, distance * pixels)
            penalty = obstacles.penalty(point, box, distance)
            if best is None or penalty < best[0]:
                best = (penalty, angle, distance, box)
        if best is not None and best[0] == 0:
            break
    assert best is not None
    return best[1:]


def _write(
    axes: Axes,
    name: PointLabel,
    point: NDArray[np.float64],
    box: Box,
    angle: int,
    distance: float,
) -> None:
    shift = _direction(angle) * distance
    # Without relpos the line would end at the middle of the text, where the space was not checked.
    near = _leader(point, box)[1] - box[:2]
    share = np.clip(near / [box[2] - box[0], box[3] - box[1]], 0.0, 1.0)
    line = {
        "arrowstyle": "-",
        "color": GREY,
        "linewidth": 0.7,
        "shrinkA": 1,
        "shrinkB": 4,
        "relpos": (float(share[0]), float(share[1])),
    }
    across, up = _alignment(angle)
    axes.annotate(
        name.text,
        (name.x, name.y),
        xytext=(float(shift[0]), float(shift[1])),
        textcoords="offset points",
        ha=("left", "center", "right")[1 - across],
        va=("bottom", "center", "top")[1 - up],
        size=TEXT - 0.5,
        color=name.colour,
        weight="bold" if name.bold else "normal",
        zorder=6,
        arrowprops=line if distance >= LEADER else None,
    )


def _box(point: NDArray[np.float64], size: tuple[float, float], angle: int, distance: float) -> Box:
    """Return the box of a name at a distance (px) and angle (°) from its point."""
    anchor = point + _direction(angle) * distance
    across, up = _alignment(angle)
    left = anchor[0] - size[0] * (0.0, 0.5, 1.0)[1 - across]
    bottom = anchor[1] - size[1] * (0.0, 0.5, 1.0)[1 - up]
    return float(left), float(bottom), float(left + size[0]), float(bottom + size[1])


def _alignment(angle: int) -> tuple[int, int]:
    """Return the direction of the text from its anchor: -1, 0 or 1, to the right and up."""
    across, up = _direction(angle)
    return int(np.rint(across)), int(np.rint(up))


def _direction(angle: int) -> NDArray[np.float64]:
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


def _leader(point: NDArray[np.float64], box: Box) -> NDArray[np.float64]:
    """Return the line from a point to the nearest point of a box."""
    near = np.clip(point, [box[0], box[1]], [box[2], box[3]])
    return np.array([point, near])


def _sampled(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sample a line, (n, 2) px."""
    pieces = [line[-1:]]
    for start, end in pairwise(line):
        steps = max(int(np.ceil(np.linalg.norm(end - start) / SAMPLE)), 1)
        pieces.append(start + (end - start) * np.linspace(0, 1, steps, endpoint=False)[:, None])
    return np.concatenate(pieces)


def _contained(points: NDArray[np.float64], box: Box) -> NDArray[np.bool_]:
    x, y = points.T
    return (x > box[0] - CLEAR) & (x < box[2] + CLEAR) & (y > box[1] - CLEAR) & (y < box[3] + CLEAR)


def _overlap(one: Box, other: Box) -> bool:
    return (
        one[0] < other[2] + CLEAR
        and other[0] < one[2] + CLEAR
        and one[1] < other[3] + CLEAR
        and other[1] < one[3] + CLEAR
    )


def _distance_to(points: NDArray[np.float64], box: Box) -> float:
    """Return the smallest distance of points (n, 2) to a box, px."""
    nearest = np.clip(points, box[:2], box[2:])
    return float(np.linalg.norm(points - nearest, axis=1).min(initial=np.inf))


def _text_size(axes: Axes, name: PointLabel) -> tuple[float, float]:
    """Return width and height of a name, px."""
    text = axes.text(
        0.5,
        0.5,
        name.text,
        size=TEXT - 0.5,
        weight="bold" if name.bold else "normal",
        transform=axes.transAxes,
    )
    extent = text.get_window_extent()
    text.remove()
    return extent.width, extent.height


def _pixels_per_point(axes: Axes) -> float:
    figure = axes.get_figure()
    assert figure is not None
    return figure.dpi / 72.0
