"""`eyehand chart grasp`: dials of perception and control, seconds per pick against success."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.apps.console import print_json, say, show
from eyehand.errors import InputError

from ...bench.chart_style import Provenance, write_chart
from ...bench.machine import machine_line
from ...bench.pareto import simplest_front
from ...bench.pareto_chart import MIN_SHOWN_PCT, ChartPoint, ParetoChart
from .conditions import check_condition
from .dials import CONTROL, DEFAULT, PERCEPTION
from .evaluate import exit_code, finished_rows, run_scenes
from .jobs import Condition, Family, run_grasp_trial, scene_jobs
from .row_store import PICK, open_rows
from .run_inputs import check_scenes, chosen_machines, own_folder, run_options, trial_extras
from .summary import by_row, summary_rows
from .summary_table import grasp_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .summary import Record

OUT = Path("out/chart_grasp")
"""Each run that is given no folder has its own in this one."""
CHART_FILE = "grasp.png"
FASTEST = ("fast", "fast")
SUREST = ("fine", "slow")
"""Perception and control turned together: both for speed, both for success."""
QUICK_SCENES, QUICK_OBJECTS = 2, 2
SAME_TIME = 1.01
"""Times that differ by less count as equal: the simulated seconds repeat, those of perception on a
busy machine do not."""


def chart_grasp(
    *,
    scenes: int = 20,
    seed: int = 0,
    family: Family = "packed",
    friction: float = 1.0,
    shake: float = 0.0,
    count: int = 5,
    cross: bool = False,
    jobs: int | None = None,
    cluster: str = "",
    quick: bool = False,
    fresh: bool = False,
    out: Path | None = None,
    json: bool = False,
) -> int:
    """Chart seconds per pick against success over the dials of perception and control.

    A pick's seconds are those of the robot and those in which it waits for perception and plan.
    All dials see the same scenes. The same command goes on with a run that was stopped. Writes
    grasp.png and the figures behind it, grasp.csv.

    Parameters
    ----------
    scenes
        Scenes of each dial.
    seed
        Seed of the first.
    family
        How objects stand: single, packed or pile.
    friction
        Coulomb coefficient of the hand's pads.
    shake
        How long the hand shakes after each lift, s.
    count
        Objects of a packed or piled scene, 1 to 15.
    cross
        Turn every dial of perception with every one of control, not each alone.
    jobs
        Processes side by side; default: as many as there are cores.
    cluster
        Address of a Dask scheduler whose workers take the scenes, tcp://host:8786.
    quick
        Two scenes of two objects, three dials: a first look.
    fresh
        Throw away the rows of earlier runs in the output folder.
    out
        Output folder; default: one in out/chart_grasp for each set of options.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    check_scenes(scenes, seed, count)
    check_condition(friction, shake)
    if quick:
        scenes, count = min(scenes, QUICK_SCENES), min(count, QUICK_OBJECTS)
    machines = chosen_machines(jobs, cluster)
    settings = [(DEFAULT, DEFAULT), FASTEST, SUREST] if quick else dial_settings(cross=cross)
    conditions = [Condition(family, friction, shake, False, *dials) for dials in settings]
    more = trial_extras("lift", None, None, "")
    planned = scene_jobs(conditions, range(seed, seed + scenes), count, more)
    options = run_options(conditions, seed, count, more)
    out = out or own_folder(OUT, conditions, options)
    store = open_rows(out, options, fresh=fresh)
    run_scenes(planned, store, machines, run_grasp_trial)
    records = finished_rows(store, planned)
    rows = summary_rows(records, planned)
    for row in rows:
        own = by_row(records)[row["name"]]
        row["pick_p50_s"] = median_pick_s(own)
    show(grasp_table(rows, f"{scenes} {family} scenes, seeds from {seed}"), json_wanted=json)
    say(machines.told)
    drawn = [row for row in rows if row["pick_p50_s"] and row["success_pct"] is not None]
    if not drawn or drawn[0]["name"] != conditions[0].name:
        raise InputError(f"the default finished no pick: nothing to chart, the rows are in {out}")
    points = [
        ChartPoint(dial_name(row), 1e3 * row["pick_p50_s"], row["success_pct"]) for row in drawn
    ]
    front = dial_front(points, [row["picks"] for row in drawn])
    for index, row in enumerate(drawn):
        row["on_front"] = index in front
    said = f"{family} scenes, friction {friction:g}" + (f", shake {shake:g} s" if shake else "")
    picks = min(row["picks"] for row in drawn)
    made = Provenance(f"{said}, {scenes} of them at each dial, at least", seed, picks, "pick")
    figure = ParetoChart(
        "Picking unknown objects: time against success",
        "time with perception and plan; blue: dials of perception and control; default with 95 % "
        f"confidence: {interval_text(drawn[0])}",
        points,
        front,
        "successful picks",
        made,
        # No failure is drawn as half a failure in the largest number of picks.
        max_shown_pct=100.0 - 50.0 / max(row["picks"] for row in drawn),
        min_shown_pct=min([MIN_SHOWN_PCT, *(point.accuracy_pct for point in points)]),
    ).figure()
    flat = [{key: value for key, value in row.items() if key != "outcomes"} for row in rows]
    write_chart(figure, out / CHART_FILE, flat)
    say(f"chart: {out / CHART_FILE}; rows: {store.folder}")
    if json:
        print_json(
            "chart_grasp",
            seed,
            rows,
            scenes=scenes,
            options=options,
            machine=machine_line(),
            timing=machines.told,
            out=str(out),
        )
    return exit_code(records, planned)


def dial_settings(*, cross: bool) -> list[tuple[str, str]]:
    """Names of perception and control that are tried together, the default first."""
    if cross:
        return [(one, other) for one in PERCEPTION for other in CONTROL]
    alone = [(name, DEFAULT) for name in PERCEPTION] + [(DEFAULT, name) for name in CONTROL]
    return list(dict.fromkeys([*alone, FASTEST, SUREST]))


def dial_name(row: dict[str, Any]) -> str:
    """Name of a setting in the chart."""
    words = [f"{row[what]} {what}" for what in ("perception", "control") if row[what] != DEFAULT]
    return ", ".join(words) or DEFAULT


def median_pick_s(records: Sequence[Record]) -> float | None:
    """Median time of a pick with what it waits for perception and plan, s; None without picks."""
    seconds = [
        pick["seconds"] + ((pick["perceive_ms"] or 0.0) + (pick["plan_ms"] or 0.0)) / 1e3
        for pick in records
        if pick["record"] == PICK and pick["seconds"]
    ]
    return round(float(np.median(seconds)), 3) if seconds else None


def dial_front(points: Sequence[ChartPoint], picks: Sequence[int]) -> list[int]:
    """Find settings that no simpler one matches to within a pick, by rising time."""
    return simplest_front(
        [point.time_ms for point in points],
        [point.accuracy_pct for point in points],
        SAME_TIME,
        100.0 / max(picks),
    )


def interval_text(row: dict[str, Any]) -> str:
    """The interval of a row's success in words."""
    return f"{row['ci_low_pct']:.0f} to {row['ci_high_pct']:.0f} %"
