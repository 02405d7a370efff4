"""Figure of the search by touch: objects from above, paths, detected points, some imprints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, FAINT, GREEN, GREY, INK, LABEL, MARGIN, TEXT, VERMILION, WIDTH
from .seek_run import SHARP, SeekRun

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


BETWEEN, NAME = 0.12, 0.34
"""Distance between panels, and height of a panel's name, inches."""
TOP, FOOT = 0.78, 0.94
"""Height of the title, and of the footer with the legend, inches."""
FACE, RIM = "#E9E2D5", "#8C8271"
"""Colours of an object and of its rim."""
HALF_VIEW = 100.0
"""Half side length of each object's panel, mm. All panels have the same scale."""
SHOWN_KINDS = ("edge", "corner", "inner_corner", "end")
"""Kinds of points with a plotted imprint."""
HALF_PAD = 40.0
"""Half side length of the pad, mm."""
PATH_WIDTH = 1.4
"""Line width of the path, points."""
SPOT_SIZE, TRUE_SIZE = 5.5, 10.5
"""Marker sizes, points. A detected point is drawn inside the ring of the true one."""
KIND_NAMES = {
    "ridge": "ridge",
    "edge": "edge",
    "corner": "corner",
    "inner_corner": "inner corner",
    "end": "end of a ridge",
}


def seek_picture(runs: Sequence[SeekRun], seed: int) -> Figure:
    """Plot each object from above with the pad's path and the detected points.

    Parameters
    ----------
    runs
        Runs, one panel each.
    seed
        Random seed for the footer.
    """
    cells = len(runs) + 1
    columns = 2 if cells in (2, 4) else 3
    rows = -(-cells // columns)
    side = (WIDTH - 2 * MARGIN - (columns - 1) * BETWEEN) / columns
    height = TOP + rows * (side + NAME) + FOOT
    figure, panels = new_chart(
        "Ridges, edges and corners detected by touch alone",
        "objects from above; the method uses the tactile images of the pad only",
        rows=rows,
        columns=columns,
        height=height,
    )
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        left = MARGIN + column * (side + BETWEEN)
        low = height - TOP - (row + 1) * (side + NAME)
        panel.set_position((left / WIDTH, low / height, side / WIDTH, side / height))
    for panel, run in zip(panels, runs, strict=False):
        _map(panel, run)
    for panel in panels[len(runs) :]:
        panel.set_axis_off()
    _imprints(figure, panels[len(runs)], runs)
    _key(figure)
    spots = sum(len(run.spots) for run in runs)
    add_footer(figure, Provenance("simulated 16 × 16 pad on an arm", seed, spots, "spot"))
    return figure


def _map(axes: Axes, run: SeekRun) -> None:
    turn = np.array([[np.cos(run.turn), -np.sin(run.turn)], [np.sin(run.turn), np.cos(run.turn)]])
    whole = run.shape.outline
    around = whole @ turn.T
    middle = 0.5 * (around.min(axis=0) + around.max(axis=0))

    def to_plot(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1e3 * (np.atleast_2d(points) @ turn.T - middle).T

    if len(whole) > 2:
        axes.fill(*to_plot(whole), facecolor=FACE, edgecolor=RIM, linewidth=1.2, zorder=1)
    else:
        axes.plot(*to_plot(whole), color=FACE, linewidth=9.0, solid_capstyle="butt", zorder=1)
        axes.plot(*to_plot(whole), color=RIM, linewidth=1.2, zorder=1)
    if len(run.path):
        axes.plot(*to_plot(run.path), color=BLUE, linewidth=PATH_WIDTH, zorder=3)
        axes.plot(*to_plot(run.path[0]), "o", color=BLUE, markersize=5, zorder=4)
    if len(run.shape.corners):
        x, y = to_plot(run.shape.corners)
        axes.plot(x, y, "o", markersize=TRUE_SIZE, mfc="none", mec=INK, mew=1.1, zorder=5)
    for spot in run.spots:
        marker, colour = ("o", VERMILION) if spot.kind in SHARP else ("D", GREEN)
        x, y = to_plot(spot.place)
        axes.plot(x, y, marker, color=colour, markersize=SPOT_SIZE, mew=0, zorder=6)
    axes.set_xlim(-HALF_VIEW, HALF_VIEW)
    axes.set_ylim(-HALF_VIEW, HALF_VIEW)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines["bottom"].set_visible(False)
    name = run.shape.name.capitalize()
    axes.set_title(name, size=LABEL, color=INK, weight="bold", loc="left", pad=6)
    axes.set_title(_summary(run), size=TEXT - 0.5, color=FAINT, loc="right", pad=6)
    axes.plot([HALF_VIEW - 50.0, HALF_VIEW], [-HALF_VIEW] * 2, color=GREY, linewidth=2.0)
    axes.annotate(
        "50 mm",
        (HALF_VIEW - 25.0, -HALF_VIEW),
        xytext=(0, 3),
        textcoords="offset points",
        ha="center",
        size=TEXT - 1.5,
        color=FAINT,
    )


def _summary(run: SeekRun) -> str:
    errors = [1e3 * s.error for s in run.spots if s.kind in SHARP]
    ended = "" if run.outcome in ("closed", "done") else f"{run.outcome.replace('_', ' ')}, "
    return f"{ended}maximum error {max(errors):.1f} mm" if errors else ended.strip(", ")


def _imprints(figure: Figure, panel: Axes, runs: Sequence[SeekRun]) -> None:
    """Plot the tactile image of the first point of each kind, in the orientation of the maps."""
    from matplotlib.colors import LinearSegmentedColormap

    shades = LinearSegmentedColormap.from_list("touch", ["#FFFFFF", BLUE])
    panel.set_title("Tactile images", size=LABEL, color=INK, weight="bold", loc="left", pad=6)
    place = panel.get_position()
    wide, high = 0.43 * place.width, 0.43 * place.height
    shown = [
        next(((run, s) for run in runs for s in run.spots if s.kind == kind), None)
        for kind in SHOWN_KINDS
    ]
    for number, (run, spot) in enumerate(one for one in shown if one):
        left = place.x0 + (0.02 + (number % 2) * 0.52) * place.width
        low = place.y1 - (0.43 + (number // 2) * 0.54) * place.height
        cell = figure.add_axes((left, low, wide, high))
        middles = [np.linspace(-1.0, 1.0, 2 * n + 1)[1::2] * HALF_PAD for n in spot.image.shape]
        x, y = np.einsum("ij,jrc->irc", run.pad_axes, np.meshgrid(middles[1], middles[0]))
        cell.pcolormesh(x, y, spot.image, cmap=shades, vmin=0.0, shading="nearest")
        cell.set_aspect("equal")
        cell.set_xticks([])
        cell.set_yticks([])
        for edge in cell.spines.values():
            edge.set_color(GREY)
        cell.set_xlabel(KIND_NAMES[spot.kind], size=TEXT - 0.5, color=INK, labelpad=3)


def _key(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    path: dict[str, Any] = {"color": BLUE, "linewidth": PATH_WIDTH, "markevery": (0, 9)}
    ring: dict[str, Any] = {"markerfacecolor": "none", "markeredgecolor": INK}
    handles = [
        Line2D([], [], marker="o", markersize=5, **path),
        Line2D([], [], marker="D", markersize=SPOT_SIZE, linestyle="none", color=GREEN),
        Line2D([], [], marker="o", markersize=SPOT_SIZE, linestyle="none", color=VERMILION),
        Line2D([], [], marker="o", markersize=TRUE_SIZE, linestyle="none", **ring),
    ]
    names = ["path of the pad's centre", "line detected", "corner or end detected", "true one"]
    figure.legend(
        handles,
        names,
        loc="lower center",
        bbox_to_anchor=(0.5, 0.44 / figure.get_size_inches()[1]),
        ncols=4,
        fontsize=TEXT - 0.5,
        labelcolor=INK,
        frameon=False,
        handlelength=1.8,
        columnspacing=1.6,
    )
