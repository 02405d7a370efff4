"""Draw Fig. 1: three panels with paths around obstacles, and a table of the results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.control import Box, Cylinder, Obstacle

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import (
    BLUE,
    FAINT,
    FOOT,
    GREEN,
    GREY,
    HEADER,
    INK,
    LABEL,
    MARGIN,
    PANEL_NAME,
    RULE,
    TEXT,
    WIDTH,
)
from .fig1_run import OPTIONS, Fig1Scene

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from .fig1_run import Fig1Run

X, Y = (-0.58, 0.44), (-0.07, 0.86)
"""Limits of the drawn part of the plane, m."""
GAP = 0.16
"""Space between panels, inches."""
LINK, RADIUS = 0.25, 0.015
"""Length and radius of the arm's links, m."""
INSTANTS = 6
"""Number of drawn postures, evenly spaced along the path."""
FIRST_OPACITY, LAST_OPACITY = 0.16, 0.66
"""Opacity of the first and the last posture."""
FIXED = {"beta 0.5": "#F3B36B", "beta 1": "#E88A33", "beta 2": "#CF5C13", "beta 5": "#8F3606"}
"""Colours of the fixed weights. A larger weight is darker."""
COLOURS = {"beta 0": BLUE, **FIXED, "dynamic": GREEN}
"""Name of a run → colour of its path."""
ARM = "#8A94A3"
"""Colour of the arm."""
SOLID = "#4A5260"
"""Colour of obstacles."""
FIELD = (0.835, 0.369, 0.0)
"""Colour of the repulsion near obstacles: vermilion."""
FIELD_OPACITY = 0.42
"""Opacity of this colour at an obstacle's surface."""
CELL = 0.002
"""Pixel size of the drawn repulsion, m."""
ROW = 0.235
"""Height of a table row, inches."""
TABLE = 4.25 * ROW
"""Height of the table and the space above it, inches."""
LESS_FOOT = 0.34
"""Reduction of the footer's height, inches, because the panels have no axis labels."""
CAPTION = 0.28
"""Height of the caption below a panel, inches."""
PANELS = (
    ("Redundancy alone", ("beta 0",), "a straight path, close to the pole"),
    ("Fixed weights", tuple(FIXED), "larger: more distance, more error"),
    ("Dynamic weight", ("dynamic",), "keeps distance and reaches the goal"),
)
"""Title, runs and caption of each panel."""


def fig1_picture(scene: Fig1Scene, runs: Sequence[Fig1Run]) -> Figure:
    """Return Fig. 1 with one panel per kind of weight and a table of the results below."""
    by_name = {run.name: run for run in runs}
    wide = (WIDTH - 2 * MARGIN - 2 * GAP) / 3
    high = wide * (Y[1] - Y[0]) / (X[1] - X[0])
    height = HEADER + PANEL_NAME + high + CAPTION + TABLE + FOOT - LESS_FOOT
    figure, panels = new_chart(
        "The dynamic weight keeps its distance and reaches the goal",
        "Path of a 4-joint arm's hand past a pole to a goal beside a wall; shaded: repulsion",
        columns=3,
        height=height,
        below=CAPTION + TABLE - LESS_FOOT,
    )
    figure.subplots_adjust(left=MARGIN / WIDTH, right=1 - MARGIN / WIDTH, wspace=GAP / wide)
    for panel, (title, names, caption) in zip(panels, PANELS, strict=True):
        _draw_scene(panel, scene)
        _draw_arm(panel, by_name[names[min(1, len(names) - 1)]], 72 * wide / (X[1] - X[0]))
        for number, name in enumerate(names):
            _draw_path(panel, by_name[name], number)
        _draw_goal(panel, scene)
        panel.set_title(title, size=LABEL, color=INK, weight="bold", loc="left", pad=6)
        panel.set_xlabel(caption, size=TEXT - 0.5, color=FAINT, labelpad=5, loc="left")
    _draw_table(figure, height, (FOOT - LESS_FOOT + TABLE) / height, by_name)
    add_footer(figure, Provenance("planar arm, 5 ms cycle, no safety level", None, 1, "scene"))
    return figure


def _draw_scene(axes: Axes, scene: Fig1Scene) -> None:
    from matplotlib.patches import Circle, Rectangle

    for side in ("bottom", "left", "right", "top"):
        axes.spines[side].set(visible=True, color=RULE)
    axes.grid(False)
    axes.set(xlim=X, ylim=Y, xticks=[], yticks=[], aspect="equal")
    obstacles = scene.world.obstacles
    x = np.arange(*X, CELL)
    y = np.arange(*Y, CELL)
    plane = np.stack(np.meshgrid(x, y), axis=-1)
    distance = np.min([_distance(obstacle, plane) for obstacle in obstacles], axis=0)
    field = np.empty((*distance.shape, 4))
    field[..., :3] = FIELD
    # Eq. 6: the cost grows with the square of the depth inside the influence distance.
    field[..., 3] = FIELD_OPACITY * np.clip(1.0 - distance / OPTIONS.influence, 0.0, 1.0) ** 2
    axes.imshow(field, extent=(*X, *Y), origin="lower", interpolation="bilinear", zorder=1)
    axes.contour(
        x,
        y,
        distance,
        levels=[OPTIONS.influence],
        colors=[FIELD],
        linewidths=0.7,
        linestyles=[(0, (3, 3))],
        alpha=0.7,
        zorder=1.2,
    )
    for obstacle in obstacles:
        centre = obstacle.pose.translation[:2]
        if isinstance(obstacle.shape, Cylinder):
            patch: Any = Circle((centre[0], centre[1]), obstacle.shape.radius)
        else:
            half = _box(obstacle).half_extents[:2]
            patch = Rectangle((centre[0] - half[0], centre[1] - half[1]), *(2.0 * half))
        patch.set(facecolor=SOLID, edgecolor="none", zorder=4)
        axes.add_patch(patch)


def _draw_arm(axes: Axes, run: Fig1Run, points_per_metre: float) -> None:
    length = np.linalg.norm(np.diff(run.hand, axis=0), axis=1).cumsum()
    instants = np.searchsorted(length, np.linspace(0.0, length[-1] * (1 - 1e-4), INSTANTS))
    opacity = np.linspace(FIRST_OPACITY, LAST_OPACITY, INSTANTS) ** 1.3
    for number, index in enumerate(instants):
        last = number == INSTANTS - 1
        joints = _joints(run.postures[-1 if last else index])
        axes.plot(
            *joints.T,
            color=ARM,
            alpha=opacity[number],
            linewidth=2 * RADIUS * points_per_metre,
            solid_capstyle="round",
            solid_joinstyle="round",
            zorder=2 + 0.1 * number,
        )
        axes.plot(
            *joints[1:-1].T,
            color="white",
            alpha=min(1.0, 1.8 * opacity[number]),
            marker="o",
            markersize=2.2,
            linestyle="none",
            zorder=2.05 + 0.1 * number,
        )
    axes.plot(0.0, 0.0, marker="o", markersize=9, color=INK, zorder=5)
    axes.plot(0.0, 0.0, marker="o", markersize=3, color="white", zorder=5.1)


def _draw_path(axes: Axes, run: Fig1Run, number: int) -> None:
    colour = COLOURS[run.name]
    x, y = run.hand[:, 0], run.hand[:, 1]
    axes.plot(x, y, color="white", linewidth=3.6, alpha=0.8, zorder=5.9 + 0.2 * number)
    axes.plot(x, y, color=colour, linewidth=2.0, solid_capstyle="round", zorder=6 + 0.2 * number)
    axes.plot(
        x[-1],
        y[-1],
        marker="o",
        markersize=6,
        color=colour,
        markeredgecolor="white",
        markeredgewidth=0.8,
        zorder=7 + 0.1 * number,
    )


def _draw_goal(axes: Axes, scene: Fig1Scene) -> None:
    from matplotlib.patheffects import withStroke

    x, y = scene.goal[:2]
    axes.plot(x, y, marker="o", markersize=9.5, color="none", markeredgecolor=INK, zorder=6.9)
    axes.plot(x, y, marker="+", markersize=15, color=INK, markeredgewidth=0.8, zorder=6.9)
    axes.annotate(
        "goal",
        (x, y),
        xytext=(-1, 10),
        textcoords="offset points",
        size=TEXT - 1.5,
        color=INK,
        ha="center",
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
    )


def _draw_table(figure: Figure, height: float, top: float, by_name: Mapping[str, Fig1Run]) -> None:
    from matplotlib.lines import Line2D

    first, step = 2.35, (WIDTH - 2.35 - MARGIN) / len(COLOURS)
    rows = (
        ("closest in mid-course", lambda run: f"{1e3 * run.midcourse:.0f} mm"),
        ("closest on the whole path", lambda run: f"{1e3 * run.closest:.0f} mm"),
        ("final error", lambda run: _millimetres(run.error)),
    )

    def put(text: str, x: float, row: int, **style: Any) -> None:
        y = top - (0.75 + row) * ROW / height
        figure.text(x / WIDTH, y, text, size=TEXT, va="center", **style)

    put("weight β of avoidance", MARGIN, 0, color=FAINT)
    for row, (name, _) in enumerate(rows, 1):
        put(name, MARGIN, row, color=INK)
    for column, (name, colour) in enumerate(COLOURS.items()):
        right = first + (column + 1) * step
        bold = {"weight": "bold"} if name == "dynamic" else {}
        put(name.removeprefix("beta "), right, 0, color=colour, ha="right", weight="bold")
        for row, (_, text) in enumerate(rows, 1):
            put(text(by_name[name]), right, row, color=INK, ha="right", **bold)
    rule = top - 1.28 * ROW / height
    figure.add_artist(
        Line2D([MARGIN / WIDTH, 1 - MARGIN / WIDTH], [rule, rule], color=GREY, linewidth=0.7)
    )


def _millimetres(metres: float) -> str:
    return "< 0.1 mm" if metres < 1e-4 else f"{1e3 * metres:.0f} mm"


def _joints(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the ends of the links in a posture, (5, 2), m."""
    heading = np.cumsum(q)
    steps = LINK * np.column_stack([np.cos(heading), np.sin(heading)])
    return np.vstack([np.zeros((1, 2)), steps.cumsum(axis=0)])


def _distance(obstacle: Obstacle, plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance of points (..., 2) of the plane from an obstacle, m."""
    offset = plane - obstacle.pose.translation[:2]
    if isinstance(obstacle.shape, Cylinder):
        return np.linalg.norm(offset, axis=-1) - obstacle.shape.radius
    outside = np.abs(offset) - _box(obstacle).half_extents[:2]
    return np.linalg.norm(np.maximum(outside, 0.0), axis=-1)


def _box(obstacle: Obstacle) -> Box:
    assert isinstance(obstacle.shape, Box)
    return obstacle.shape
