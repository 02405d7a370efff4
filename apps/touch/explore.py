"""`eyehand experiment explore`: scan an unknown object with two pads (section 4.5, Fig. 11)."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth.pad import surface_distance
from eyehand.perception.io import write_cloud

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, INK, TEXT, VERMILION, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from .arm_rig import SensorName
from .explore_run import MAX_TILT_DEG, run_explore
from .explore_truth import explore_rows, height_map
from .trial_arguments import measure_with

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .explore_run import ExploreRun

WANTED_MM = 0.3
"""Rms error that the cloud should stay below, mm."""

HEIGHT = 5.0
"""Height of the figure, inches."""
MAX_ERROR_MM = 0.6
"""Error at both ends of the colour scale, mm."""
KEY = 0.55
"""Height of the legend and the colour scale, inches."""
MAX_POINTS = 6000
"""Maximum number of plotted points. More points would hide the surface."""


def experiment_explore(
    *,
    seed: int = 0,
    sensor: SensorName = "good",
    quick: bool = False,
    out: Path = Path("out/experiment_explore"),
    json: bool = False,
) -> int:
    """Scan an unknown object with two pads on two arms, and write the point cloud of its surface.

    Each pad covers its half of the object in lanes, first along one direction and then across. It
    rolls and presses by touch, and the other arm waits. The cloud is compared with the true
    surface. The chapter shows a picture (Fig. 11). The row "blurred" uses the same images without
    correction of the foam's spread. Writes explore.png, explore.csv and explore.ply.

    Parameters
    ----------
    seed
        Seed of the object, the pads' electronics and their noise. The objects take turns: a dome
        with a ridge and a block, a smooth pebble, and a barrel with rims. From 3 on they vary.
    sensor
        Sensor model: ideal, good, real or harsh.
    quick
        Two lanes in each direction, faster, for a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout. The table then goes to stderr.
    """
    experiment = Experiment("explore", partial(measure_with, _measure, sensor))
    return run_experiment(experiment, seed=seed, quick=quick, out=out, json=json)


def _measure(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    run = run_explore(plan.seed, plan.quick, sensor)
    rows = explore_rows(run)
    force_mean, force_std = float(run.forces.mean()), float(run.forces.std())
    table = result_table(
        rows,
        [
            ("", "{name}"),
            ("points", "{points}"),
            ("rms", "{surface_rms_mm:.3f} mm"),
            ("median", "{surface_median_mm:+.3f} mm"),
            ("p95", "{surface_p95_mm:.3f} mm"),
            ("ridges rms", "{ridges_rms_mm:.3f} mm"),
            ("median", "{ridges_median_mm:+.3f} mm"),
            ("covered", "{covered_pct:.1f} %"),
        ],
        title=f"distance of measured points from the true surface; target: {WANTED_MM:g} mm rms",
        caption="distances inside the object are negative; ridges: points on ridges, edges and "
        "corners; blurred: without correction of the foam's spread; covered: share of the surface "
        "with a measured point within 5 mm, where a flat pad can reach it, tilted up to "
        f"{MAX_TILT_DEG:g}°",
    )
    return ExperimentResult(
        rows,
        table,
        explore_picture(run, rows[-1]["surface_rms_mm"] if rows else 0.0, plan.seed),
        files={"explore.ply": partial(write_cloud, points=run.points)},
        notes=(
            f"pads: {', '.join(run.outcomes)}; {run.seconds:.0f} s of scanning at "
            f"{force_mean:.2f} ± {force_std:.2f} N",
            f"largest tilt {run.tilt_deg:.0f}°, lowest rim {run.rim_mm:.0f} mm below the top",
        ),
        more={
            "wanted_rms_mm": WANTED_MM,
            "outcomes": list(run.outcomes),
            "force_mean_n": force_mean,
            "force_std_n": force_std,
            "most_tilt_deg": run.tilt_deg,
            "rim_below_top_mm": run.rim_mm,
        },
    )


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
