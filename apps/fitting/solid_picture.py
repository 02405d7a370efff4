"""Draw a fit as a PNG: the cloud above, the cloud with its solid below, in three views."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench.chart_style import DPI, FAINT, FOOTER, INK, MARGIN, TEXT, TITLE, WIDTH
from .flat_panels import flat_panel
from .panel_style import PANEL
from .picture_scene import picture_scene, residual_colours
from .solid_text import headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .fit_inputs import FittedCloud
    from .picture_scene import PictureScene

NAMES, GAP, HEAD, FOOT = 0.34, 0.1, 0.78, 0.62
"""Space for row names, between panels, for the title and for the colour bar, inches."""
BAR_WIDTH, BAR_HEIGHT, BAR_BOTTOM = 2.3, 0.11, 0.36
"""Size of the colour bar, and its height above the lower edge, inches."""
STEPS = 256
"""Number of colours in the colour bar."""
SCALE_SHARE = 0.3
"""Maximum length of the scale bar, relative to a panel. It has the longest round length."""
ROUND_LENGTHS_MM = tuple(step * 10**power for power in range(5) for step in (1, 2, 5))


def fit_picture(fitted: FittedCloud) -> bytes:
    """Draw a fit as a PNG.

    Parameters
    ----------
    fitted
        Cloud and solid. Without a solid the cloud alone is drawn, with the reason in the title.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    scene = picture_scene(fitted)
    names = ("points", "solid") if scene.surfaces else ("points",)
    panel = (WIDTH - 2 * MARGIN - NAMES - 2 * GAP) / 3
    height = HEAD + MARGIN + len(names) * panel + (len(names) - 1) * GAP + FOOT
    figure = Figure(figsize=(WIDTH, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    for row, name in enumerate(names):
        bottom = height - HEAD - MARGIN - (row + 1) * panel - row * GAP
        for column, view in enumerate(scene.views):
            left = MARGIN + NAMES + column * (panel + GAP)
            axes = _add_axes(figure, left, bottom, panel, panel)
            axes.set_facecolor(PANEL)
            flat_panel(axes, scene, view, solid=row == 1, panel=panel)
            axes.set(xlim=(-scene.half, scene.half), ylim=(-scene.half, scene.half))
            if row == 0:
                axes.set_title(view.name, size=TEXT, color=FAINT, pad=3)
        middle = bottom + panel / 2
        style = {"size": TEXT, "color": FAINT, "rotation": 90}
        _write(
            figure, MARGIN + NAMES - 0.03 * panel, middle, name, ha="right", va="center", **style
        )
    title, below = headline(fitted.fit)
    _write(figure, MARGIN, height - MARGIN, title, size=TITLE, weight="bold", va="top")
    _write(figure, MARGIN, height - MARGIN - 0.27, below, size=TEXT, color=FAINT, va="top")
    _write(figure, MARGIN, 0.16, fitted.cloud.name, size=FOOTER, color=FAINT, va="bottom")
    if scene.surfaces:
        _draw_colour_bar(figure, scene)
    _draw_scale_bar(figure, scene, panel)
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DPI, metadata={"Software": None})
    return drawn.getvalue()


def _add_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Add axes without ticks and frame at a place in inches."""
    figure_height = figure.get_figheight()
    axes = figure.add_axes(
        (left / WIDTH, bottom / figure_height, width / WIDTH, height / figure_height)
    )
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    return axes


def _write(figure: Figure, x: float, y: float, text: str, **style: Any) -> None:
    """Write text at a place in inches."""
    figure.text(x / WIDTH, y / figure.get_figheight(), text, **{"color": INK, **style})


def _draw_colour_bar(figure: Figure, scene: PictureScene) -> None:
    limit = scene.limit_mm
    left = WIDTH - MARGIN - BAR_WIDTH
    axes = _add_axes(figure, left, BAR_BOTTOM, BAR_WIDTH, BAR_HEIGHT)
    colours = residual_colours(np.linspace(-1e-3, 1e-3, STEPS) * limit, limit)
    axes.imshow(colours[None], extent=(-limit, limit, 0.0, 1.0), aspect="auto")
    axes.set_xticks([-limit, 0.0, limit], [f"{-limit:g}", "0", f"{limit:g} mm"])
    axes.set_yticks([])
    for label, side in zip(axes.get_xticklabels(), ("left", "center", "right"), strict=True):
        label.set_horizontalalignment(side)
    axes.tick_params(length=0, labelsize=FOOTER + 0.5, labelcolor=INK, pad=3)
    style = {"size": FOOTER + 0.5, "color": FAINT, "ha": "right", "va": "center"}
    text = "inside / outside the solid"
    _write(figure, left - 0.1, BAR_BOTTOM + BAR_HEIGHT / 2, text, **style)


def _draw_scale_bar(figure: Figure, scene: PictureScene, panel: float) -> None:
    """Draw a round length under the first panel, at the scale of the panels."""
    per_mm = panel / (2e3 * scene.half)
    length = max((mm for mm in ROUND_LENGTHS_MM if mm * per_mm <= SCALE_SHARE * panel), default=0)
    if not length:
        return
    left, bottom = MARGIN + NAMES, FOOT + MARGIN - 0.3
    _add_axes(figure, left, bottom, length * per_mm, 0.03).set_facecolor(INK)
    right = left + length * per_mm + 0.06
    style = {"size": FOOTER + 0.5, "va": "center_baseline"}
    _write(figure, right, bottom + 0.015, f"{length:g} mm", **style)
