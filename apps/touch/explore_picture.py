"""Figure of an explored object: measured points over the true surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth.pad import surface_distance

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, INK, TEXT, VERMILION, label_axes
from .explore_truth import height_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .explore_run import ExploreRun

HEIGHT = 5.0
"""Height of the figure, inches."""
MAX_ERROR_MM = 0.6
"""Error at both ends of the colour scale, mm."""
KEY = 0.55
"""Height of the legend and the colour scale, inches."""
MAX_POINTS = 6000
"""Maximum number of plotted points. More points would hide the surface."""


def explore_picture(run: ExploreRun, rms_mm: float, seed: int) -> Figure:
    """Plot the paths of both pads over the object, and the point cloud coloured by its error.

    Parameters
    ----------
    run
        Record of the exploration.
    rms_mm
        Root mean square distance of the whole cloud to the surface, mm.
    seed
        Random seed of the run, for the footer.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    figure, (left, right) = new_chart(
        "An unknown object, explored by touch",
        "shaded: the true surface from above; points: measured by two pads on two arms",
        columns=2,
        height=HEIGHT,
        below=KEY,
    )
    rng = np.random.default_rng(seed)
    count = min(MAX_POINTS, len(run.points))
    shown = np.sort(rng.choice(len(run.points), count, replace=False))
    points, pads = 1e3 * run.points[shown], run.pad[shown]
    _surface(left, run)
    for pad, (name, colour) in enumerate((("left pad", BLUE), ("right pad", VERMILION))):
        own = points[pads == pad]
        left.scatter(own[:, 0], own[:, 1], s=2.5, color=colour, alpha=0.5, linewidths=0)
        if len(run.paths[pad]):
            x, y = 1e3 * run.paths[pad][:, 0], 1e3 * run.paths[pad][:, 1]
            left.plot(x, y, color=INK, linewidth=0.9, zorder=4)
        left.plot([], [], "o", color=colour, markersize=6, label=name)
    left.plot([], [], color=INK, linewidth=0.9, label="path of a pad")
    label_axes(left, "x [mm]", "y [mm]", panel="Scan in both directions")
    left.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, -0.24),
        ncols=3,
        fontsize=TEXT - 1,
        labelcolor=INK,
        frameon=False,
        handlelength=1.0,
        columnspacing=1.2,
    )
    _surface(right, run)
    errors = 1e3 * surface_distance(run.touch_object, run.points[shown])
    scale = Normalize(-MAX_ERROR_MM, MAX_ERROR_MM)
    right.scatter(points[:, 0], points[:, 1], s=5, c=errors, cmap="RdBu", norm=scale, linewidths=0)
    place = right.get_position()
    strip = figure.add_axes((place.x0, 0.95 / HEIGHT, place.width, 0.1 / HEIGHT))
    bar = figure.colorbar(ScalarMappable(scale, "RdBu"), cax=strip, orientation="horizontal")
    bar.set_label("signed distance, negative inside [mm]", size=TEXT - 1, color=INK)
    bar.ax.tick_params(labelsize=TEXT - 1, length=0)
    bar.outline.set_visible(False)
    label_axes(right, "x [mm]", "y [mm]", panel=f"Error: {rms_mm:.2f} mm rms")
    data = "two simulated 16 × 16 pads on arms"
    add_footer(figure, Provenance(data, seed, len(run.points), "measured point"))
    return figure


def _surface(axes: Axes, run: ExploreRun) -> None:
    from matplotlib.colors import LightSource

    x, y, heights = height_map(run.touch_object)
    step = float(x[1] - x[0])
    low = np.nanmin(heights)
    light = LightSource(azdeg=315, altdeg=55)
    shade = light.hillshade(np.nan_to_num(heights, nan=low), vert_exag=1.5, dx=step, dy=step)
    picture = np.ones((*heights.shape, 4))
    picture[..., :3] = (0.45 + 0.5 * shade)[..., None]
    picture[..., 3] = np.isfinite(heights)
    half = 0.5 * step
    extent = 1e3 * np.array([x[0] - half, x[-1] + half, y[0] - half, y[-1] + half])
    axes.grid(False)
    left, right, bottom, top = extent.tolist()
    axes.imshow(picture, extent=(left, right, bottom, top), origin="lower", zorder=1)
    axes.set_aspect("equal", adjustable="box")
