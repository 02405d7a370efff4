"""Names beside the points of a chart that touch neither each other nor what is drawn."""

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
"""Where a name should rather be."""

ANGLES: dict[Side, tuple[int, ...]] = {
    "above": (60, 75, 90, 45, 120, 30, 150, 0, 180, 330, 210, 270),
    "right": (0, 330, 30, 300, 60, 270, 90, 240, 120, 210, 150, 180),
}
"""Directions in which a name is tried, degrees counter-clockwise from the right, best first."""
DISTANCES = (7.0, 10.0, 14.0, 18.0, 26.0, 36.0, 48.0, 62.0, 78.0, 96.0, 120.0, 150.0)
"""Distances from the point at which it is tried, points of type; the nearest free one wins."""
LEADER = 11.0
"""From this distance on a thin line leads from the point to its name, points of type."""
CLEAR = 3.0
"""Free space around a name, px."""
MARK = 14.0
"""A leader keeps so far from the middle of other named points, px: as far as their marks reach."""
SAMPLE = 5.0
"""Lines are avoided by points so far apart, px."""

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
    """Where the name should rather be."""
    colour: str = INK
    bold: bool = False


def label_points(
    axes: Axes, names: Sequence[PointLabel], lines: Sequence[Sequence[tuple[float, float]]]
) -> list[Box]:
    """Write each name near its point, where there is room, with a thin line to it when far.

    Names are placed in the order given, each at the nearest place that keeps clear of the names
    before it, of all points and lines, and of the border of the axes; where there is none, at the
    place that hits least. Scales and limits of the axes must be final.

    Parameters
    ----------
    axes
        Where to write.
    names
        The names, the most important first.
    lines
        What else is drawn, as lines through data points (a single point is a line too).

    Returns
    -------
    list of Box
        Where the names are, px.
    """
    drawn = [axes.transData.transform(np.asarray(line, float)) for line in lines if len(line)]
    points = axes.transData.transform([(name.x, name.y) for name in names]).reshape(-1, 2)
    boxes: list[Box] = []
    for name, point in zip(names, points, strict=True):
        own = [_sampled(line) for line in drawn if np.any(np.all(line == point, axis=1))]
        others = [_sampled(line) for line in drawn if not np.any(np.all(line == point, axis=1))]
        elsewhere = points[np.any(points != point, axis=1)]
        around = _Around(
            np.asarray(axes.bbox.extents),
            boxes,
            np.concatenate([point[None], *own]),
            np.concatenate([elsewhere, *others]),
            elsewhere,
        )
        angle, distance, box = _best_place(axes, name, point, around)
        _write(axes, name, point, box, angle, distance)
        boxes.append(box)
        if distance >= LEADER:
            drawn.append(_leader(point, box))
    return boxes


@dataclass(frozen=True)
class _Around:
    """What a name must keep clear of, px."""

    border: NDArray[np.float64]
    names: list[Box]
    own: NDArray[np.float64]
    """Points along the line that is named, (n, 2)."""
    others: NDArray[np.float64]
    """Points along all other lines, and the other named points, (n, 2)."""
    points: NDArray[np.float64]
    """The other named points, (n, 2)."""

    def faults(self, point: NDArray[np.float64], box: Box, distance: float) -> float:
        """How bad a place is; 0 is free."""
        left, bottom, right, top = self.border
        faults = 20.0 * sum(_hit(box, name) for name in self.names)
        faults += np.count_nonzero(_inside(self.own, box))
        faults += np.count_nonzero(_inside(self.others, box))
        if box[0] < left or box[1] < bottom or box[2] > right or box[3] > top:
            faults += 1000.0
        if distance >= LEADER:
            line = _sampled(_leader(point, box))
            faults += 5.0 * sum(bool(np.any(_inside(line, name))) for name in self.names)
            # Across another point it would seem to begin there.
            across = np.linalg.norm(line[:, None] - self.points[None], axis=2) < MARK
            faults += 5.0 * np.count_nonzero(across.any(axis=0))
        # A name nearer to another curve than to its own would be taken for that one's.
        elif _gap(self.others, box) < 1.5 * _gap(self.own, box):
            faults += 2.0
        return float(faults)


def _best_place(
    axes: Axes, name: PointLabel, point: NDArray[np.float64], around: _Around
) -> tuple[int, float, Box]:
    size, pixels = _text_size(axes, name), _pixels_per_point(axes)
    best: tuple[float, int, float, Box] | None = None
    for distance in DISTANCES:
        for angle in ANGLES[name.side]:
            box = _box(point, size, angle, distance * pixels)
            faults = around.faults(point, box, distance)
            if best is None or faults < best[0]:
                best = (faults, angle, distance, box)
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
    # By itself the line would run to the middle of the text, and not where room was found for it.
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
    """Give the box of a name at a distance (px) and angle from its point."""
    anchor = point + _direction(angle) * distance
    across, up = _alignment(angle)
    left = anchor[0] - size[0] * (0.0, 0.5, 1.0)[1 - across]
    bottom = anchor[1] - size[1] * (0.0, 0.5, 1.0)[1 - up]
    return float(left), float(bottom), float(left + size[0]), float(bottom + size[1])


def _alignment(angle: int) -> tuple[int, int]:
    """Which way the text runs from its anchor: -1, 0, 1 across (left to right) and up."""
    across, up = _direction(angle)
    return int(np.rint(across)), int(np.rint(up))


def _direction(angle: int) -> NDArray[np.float64]:
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


def _leader(point: NDArray[np.float64], box: Box) -> NDArray[np.float64]:
    """Line from a point to the nearest place of a box."""
    near = np.clip(point, [box[0], box[1]], [box[2], box[3]])
    return np.array([point, near])


def _sampled(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points along a line, (n, 2) px."""
    pieces = [line[-1:]]
    for start, end in pairwise(line):
        steps = max(int(np.ceil(np.linalg.norm(end - start) / SAMPLE)), 1)
        pieces.append(start + (end - start) * np.linspace(0, 1, steps, endpoint=False)[:, None])
    return np.concatenate(pieces)


def _inside(points: NDArray[np.float64], box: Box) -> NDArray[np.bool_]:
    x, y = points.T
    return (x > box[0] - CLEAR) & (x < box[2] + CLEAR) & (y > box[1] - CLEAR) & (y < box[3] + CLEAR)


def _hit(one: Box, other: Box) -> bool:
    return (
        one[0] < other[2] + CLEAR
        and other[0] < one[2] + CLEAR
        and one[1] < other[3] + CLEAR
        and other[1] < one[3] + CLEAR
    )


def _gap(points: NDArray[np.float64], box: Box) -> float:
    """Least distance of points to a box, px, other than those at the named point itself."""
    nearest = np.clip(points, box[:2], box[2:])
    return float(np.linalg.norm(points - nearest, axis=1).min(initial=np.inf))


def _text_size(axes: Axes, name: PointLabel) -> tuple[float, float]:
    """Width and height of a name, px."""
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
