"""Draw a fit as a PNG: the cloud above, the cloud with its solid below, in three views."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np

from ..bench.chart_style import DPI, FAINT, FOOTER, INK, MARGIN, TEXT, TITLE, WIDTH
from .flat_panels import flat_panel
from .panel_look import PANEL
from .picture_scene import picture_scene, residual_colours
from .solid_text import headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .fit_inputs import FittedCloud
    from .picture_scene import PictureScene

NAMES, GAP, HEAD, FOOT = 0.34, 0.1, 0.78, 0.62
"""Space for row names, between panels, for the title and for the colour bar, inches."""
BAR = (2.3, 0.11)
"""Width and height of the colour bar, inches."""
STEPS = 256
SCALE_SHARE = 0.3
"""Maximum length of the scale bar, share of a panel. It has the longest round length."""
ROUND_LENGTHS_MM = tuple(step * 10**power for power in range(5) for step in (1, 2, 5))


def fit_picture(fitted: FittedCloud) -> bytes:
    """Draw a fit as a PNG.

    Parameters
    ----------
    fitted
        Cloud and solid. Without a solid the cloud alone is drawn, with the reason in the title.
    """
    scene = picture_scene(fitted)
    rows = 2 if scene.surfaces else 1
    panel = (WIDTH - 2 * MARGIN - NAMES - 2 * GAP) / 3
    height = HEAD + MARGIN + rows * panel + (rows - 1) * GAP + FOOT
    figure, axes = _panels(rows, panel, height)
    for row in range(rows):
        for column, view in enumerate(scene.views):
            place = axes[row][column]
            flat_panel(place, scene, view, solid=row == 1, panel=panel)
            place.set_xlim(-scene.half, scene.half)
            place.set_ylim(-scene.half, scene.half)
            if row == 0:
                place.set_title(view.name, size=TEXT, color=FAINT, pad=3)
    for row, name in zip(axes, ("points", "solid"), strict=False):
        row[0].text(
            -0.03, 0.5, name, transform=row[0].transAxes, rotation=90, size=TEXT, color=FAINT,
            ha="right", va="center",
        )  # fmt: skip
    _headline(figure, fitted, height)
    if scene.surfaces:
        _colour_bar(figure, scene, height)
    _scale_bar(figure, scene, panel, height)
    figure.text(
        MARGIN / WIDTH,
        0.16 / height,
        fitted.cloud.name,
        size=FOOTER,
        color=FAINT,
        ha="left",
        va="bottom",
    )
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DPI, metadata={"Software": None})
    return drawn.getvalue()


def _panels(rows: int, panel: float, height: float) -> tuple[Figure, list[list[Axes]]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    axes = []
    for row in range(rows):
        bottom = height - HEAD - MARGIN - (row + 1) * panel - row * GAP
        axes.append([])
        for column in range(3):
            left = MARGIN + NAMES + column * (panel + GAP)
            place = figure.add_axes((left / WIDTH, bottom / height, panel / WIDTH, panel / height))
            place.set_xticks([])
            place.set_yticks([])
            place.set_facecolor(PANEL)
            for spine in place.spines.values():
                spine.set_visible(False)
            axes[-1].append(place)
    return figure, axes


def _headline(figure: Figure, fitted: FittedCloud, height: float) -> None:
    title, below = headline(fitted.fit)
    left, top = MARGIN / WIDTH, 1 - MARGIN / height
    figure.text(left, top, title, size=TITLE, weight="bold", color=INK, va="top", ha="left")
    figure.text(left, top - 0.27 / height, below, size=TEXT, color=FAINT, va="top", ha="left")


def _colour_bar(figure: Figure, scene: PictureScene, height: float) -> None:
    limit = scene.limit_mm
    long, thick = BAR
    place = figure.add_axes(
        (1 - (MARGIN + long) / WIDTH, 0.36 / height, long / WIDTH, thick / height)
    )
    ramp = residual_colours(np.linspace(-1e-3, 1e-3, STEPS) * limit, limit)
    place.imshow(ramp[None], extent=(-limit, limit, 0.0, 1.0), aspect="auto")
    place.set_yticks([])
    ticks = [-limit, 0.0, limit]
    place.set_xticks(ticks, [f"{-limit:g}", "0", f"{limit:g} mm"])
    for label, side in zip(place.get_xticklabels(), ("left", "center", "right"), strict=True):
        label.set_horizontalalignment(side)
    figure.text(
        1 - (MARGIN + long + 0.1) / WIDTH,
        (0.36 + thick / 2) / height,
        "inside / outside the solid",
        size=FOOTER + 0.5,
        color=FAINT,
        ha="right",
        va="center",
    )
    place.tick_params(length=0, labelsize=FOOTER + 0.5, labelcolor=INK, pad=3)
    for spine in place.spines.values():
        spine.set_visible(False)


def _scale_bar(figure: Figure, scene: PictureScene, panel: float, height: float) -> None:
    """Draw a round length under the first panel, at the panels' scale."""
    per_mm = panel / (2e3 * scene.half)
    length = max((mm for mm in ROUND_LENGTHS_MM if mm * per_mm <= SCALE_SHARE * panel), default=0)
    if not length:
        return
    left, low = MARGIN + NAMES, FOOT + MARGIN - 0.3
    place = figure.add_axes((left / WIDTH, low / height, length * per_mm / WIDTH, 0.03 / height))
    place.set_facecolor(INK)
    place.set_xticks([])
    place.set_yticks([])
    for spine in place.spines.values():
        spine.set_visible(False)
    figure.text(
        (left + length * per_mm + 0.06) / WIDTH,
        (low + 0.015) / height,
        f"{length:g} mm",
        size=FOOTER + 0.5,
        color=INK,
        va="center_baseline",
    )
