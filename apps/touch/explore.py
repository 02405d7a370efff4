"""`eyehand experiment explore`: scan an unknown object with two pads (section 4.5, Fig. 11)."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from eyehand.perception.io import write_cloud

from ..bench import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from .arm_rig import SensorName
from .explore_picture import explore_picture
from .explore_run import MAX_TILT_DEG, run_explore
from .explore_truth import explore_rows
from .trial_arguments import measure_with

WANTED_MM = 0.3
"""Rms error that the cloud should stay below, mm."""


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
