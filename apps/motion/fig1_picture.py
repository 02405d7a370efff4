"""Fig. 1 as a picture: three panels of ways around obstacles, and the figures under them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.control import Box, Cylinder

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
from .fig1_scene import OPTIONS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from eyehand.control import Obstacle

    from .fig1_run import Fig1Run
    from .fig1_scene import Fig1Scene

X, Y = (-0.58, 0.44), (-0.07, 0.86)
"""What of the plane is shown, m."""
GAP = 0.16
"""Between panels, inches."""
LINK, RADIUS = 0.25, 0.015
"""Length and radius of the arm's links, m."""
INSTANTS = 6
"""Postures that are drawn, evenly along the way."""
MIN_OPACITY, MAX_OPACITY = 0.16, 0.66
"""Opacity of the first posture and of the last."""
FIXED = {"beta 0.5": "#F3B36B", "beta 1": "#E88A33", "beta 2": "#CF5C13", "beta 5": "#8F3606"}
"""Colours of the fixed weights: the heavier, the darker."""
WAYS = {"beta 0": BLUE, **FIXED, "dynamic": GREEN}
"""Colour of each way."""
ARM = "#8A94A3"
"""The arm, which is not what the picture is about."""
SOLID = "#4A5260"
"""Obstacles."""
FIELD = (0.835, 0.369, 0.0)
"""Vermilion: the cost of being near."""
FIELD_OPACITY = 0.42
"""Of that colour at an obstacle's surface."""
CELL = 0.002
"""Size of the cells in which the field is drawn, m."""
ROW = 0.235
"""Height of a row of the table, inches."""
TABLE = 4.25 * ROW
"""Height of the table with the space above it, inches."""
TIGHTER = 0.34
"""What the footer needs less than in a chart, inches: the panels have no axis."""
WORDS = 0.28
"""Height of the words under a panel, inches."""
PANELS = (
    ("Redundancy alone", ("beta 0",), "a straight way, whatever is near"),
    ("Fixed weights", tuple(FIXED), "heavier: farther round, farther off"),
    ("Dynamic weight", ("dynamic",), "swerves, and arrives"),
)
"""Name, runs and words of each panel."""


def fig1_picture(scene: Fig1Scene, runs: Sequence[Fig1Run]) -> Figure:
    """Return Fig. 1 with one panel per kind of weight and a table of the results below."""
    by_name = {run.name: run for run in runs}
    wide = (WIDTH - 2 * MARGIN - 2 * GAP) / 3
    high = wide * (Y[1] - Y[0]) / (X[1] - X[0])
    height = HEADER + PANEL_NAME + high + WORDS + TABLE + FOOT - TIGHTER
    figure, panels = new_chart(
        "A weight that follows the way keeps its distance and arrives",
        "Hand of a 4-joint arm past a pole to a goal beside a wall; shaded: where obstacles repel",
        columns=3,
        height=height,
        below=WORDS + TABLE - TIGHTER,
    )
    figure.subplots_adjust(left=MARGIN / WIDTH, right=1 - MARGIN / WIDTH, wspace=GAP / wide)
    for panel, (name, shown, told) in zip(panels, PANELS, strict=True):
        _draw_scene(panel, scene)
        _draw_arm(panel, by_name[shown[min(1, len(shown) - 1)]], 72 * wide / (X[1] - X[0]))
        for number, run in enumerate(shown):
            _draw_way(panel, by_name[run], number)
        _draw_goal(panel, scene)
        panel.set_title(name, size=LABEL, color=INK, weight="bold", loc="left", pad=6)
        panel.set_xlabel(told, size=TEXT - 0.5, color=FAINT, labelpad=5, loc="left")
    _draw_table(figure, height, (FOOT - TIGHTER + TABLE) / height, by_name)
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
    nearest = np.min([_distance(obstacle, plane) for obstacle in obstacles], axis=0)
    field = np.empty((*nearest.shape, 4))
    field[..., :3] = FIELD
    # As eq. 6 has it: with the square of how deep a point is inside the influence.
    field[..., 3] = FIELD_OPACITY * np.clip(1.0 - nearest / OPTIONS.influence, 0.0, 1.0) ** 2
    axes.imshow(field, extent=(*X, *Y), origin="lower", interpolation="bilinear", zorder=1)
    axes.contour(
        x,
        y,
        nearest,
        levels=[OPTIONS.influence],
        colors=[FIELD],
        linewidths=0.7,
        linestyles=[(0, (3, 3))],
        alpha=0.7,
        zorder=1.2,
    )
    for obstacle in obstacles:
        at = obstacle.pose.translation[:2]
        if isinstance(obstacle.shape, Cylinder):
            patch: Any = Circle((at[0], at[1]), obstacle.shape.radius)
        else:
            half = _box(obstacle).half_extents[:2]
            patch = Rectangle((at[0] - half[0], at[1] - half[1]), *(2.0 * half))
        patch.set(facecolor=SOLID, edgecolor="none", zorder=4)
        axes.add_patch(patch)


def _draw_arm(axes: Axes, run: Fig1Run, points_a_metre: float) -> None:
    gone = np.linalg.norm(np.diff(run.hand, axis=0), axis=1).cumsum()
    instants = np.searchsorted(gone, np.linspace(0.0, gone[-1] * (1 - 1e-4), INSTANTS))
    opacity = np.linspace(MIN_OPACITY, MAX_OPACITY, INSTANTS) ** 1.3
    for number, index in enumerate(instants):
        last = number == INSTANTS - 1
        joints = _joints(run.postures[-1 if last else index])
        axes.plot(
            *joints.T,
            color=ARM,
            alpha=opacity[number],
            linewidth=2 * RADIUS * points_a_metre,
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


def _draw_way(axes: Axes, run: Fig1Run, number: int) -> None:
    colour = WAYS[run.name]
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

    first, step = 2.35, (WIDTH - 2.35 - MARGIN) / len(WAYS)
    rows = (
        ("closest in mid-course", lambda run: f"{1e3 * run.midcourse:.0f} mm"),
        ("closest on the whole way", lambda run: f"{1e3 * run.closest:.0f} mm"),
        ("error at the end", lambda run: _millimetres(run.error)),
    )

    def put(text: str, x: float, row: int, **look: Any) -> None:
        place = top - (0.75 + row) * ROW / height
        figure.text(x / WIDTH, place, text, size=TEXT, va="center", **look)

    put("weight β of avoidance", MARGIN, 0, color=FAINT)
    for row, (name, _) in enumerate(rows, 1):
        put(name, MARGIN, row, color=INK)
    for column, (name, colour) in enumerate(WAYS.items()):
        right = first + (column + 1) * step
        bold = {"weight": "bold"} if name == "dynamic" else {}
        put(name.removeprefix("beta "), right, 0, color=colour, ha="right", weight="bold")
        for row, (_, told) in enumerate(rows, 1):
            put(told(by_name[name]), right, row, color=INK, ha="right", **bold)
    rule = top - 1.28 * ROW / height
    figure.add_artist(
        Line2D([MARGIN / WIDTH, 1 - MARGIN / WIDTH], [rule, rule], color=GREY, linewidth=0.7)
    )


def _millimetres(metres: float) -> str:
    return "< 0.1 mm" if metres < 1e-4 else f"{1e3 * metres:.0f} mm"


def _joints(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ends of the links in a posture, (5, 2), m."""
    heading = np.cumsum(q)
    steps = LINK * np.column_stack([np.cos(heading), np.sin(heading)])
    return np.vstack([np.zeros((1, 2)), steps.cumsum(axis=0)])


def _distance(obstacle: Obstacle, plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of points (..., 2) of the plane from an obstacle, m."""
    away = plane - obstacle.pose.translation[:2]
    if isinstance(obstacle.shape, Cylinder):
        return np.linalg.norm(away, axis=-1) - obstacle.shape.radius
    outside = np.abs(away) - _box(obstacle).half_extents[:2]
    return np.linalg.norm(np.maximum(outside, 0.0), axis=-1)


def _box(obstacle: Obstacle) -> Box:
    assert isinstance(obstacle.shape, Box)
    return obstacle.shape
