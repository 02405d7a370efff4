"""`eyehand chart grasp`: dials of perception and control, seconds per pick against success."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from eyehand.apps.console import say, show
from eyehand.apps.output_files import make_folder
from eyehand.errors import InputError

from ...bench.chart_style import Provenance, write_chart
from ...bench.pareto import simplest_front
from ...bench.pareto_chart import MIN_SHOWN_PCT, ChartPoint, ParetoChart
from .conditions import check_condition
from .dials import CONTROL, DEFAULT, PERCEPTION
from .jobs import Condition, Family, run_grasp_trial
from .protocol_settings import ProtocolChoice
from .row_store import PICK
from .run_inputs import (
    check_objects_fit,
    checked_machines,
    checked_scenes,
    trial_extras,
    with_objects,
)
from .stored_run import RunPlan, exit_code, flat_rows, print_run_json, run_plan
from .summary import Record, by_row
from .summary_table import grasp_table

OUT = Path("out/chart_grasp")
"""Parent of the default output folders."""
CHART_FILE = "grasp.png"
FASTEST = ("fast", "fast")
MOST_RELIABLE = ("fine", "slow")
"""Dials of perception and control that are changed together, for speed and for success."""
EQUAL_TIME_RATIO = 1.01
"""Times with a smaller ratio count as equal. The perception times vary on a busy machine."""


def chart_grasp(
    *,
    scenes: int = 20,
    seed: int = 0,
    family: Family = "packed",
    friction: float = 1.0,
    shake: float = 0.0,
    count: int = 5,
    jobs: int | None = None,
    cluster: str = "",
    quick: bool = False,
    fresh: bool = False,
    out: Path | None = None,
    json: bool = False,
    public: Annotated[
        ProtocolChoice | None, Parameter(name="*", group="Objects and public protocol")
    ] = None,
) -> int:
    """Chart seconds per pick against success over the dials of perception and control.

    The time of a pick is the robot time plus the times of perception and planning. All dials run
    on the same scenes. Objects are solids, or drawn from the folder --objects. The same command
    continues a stopped run. Writes grasp.png and its figures, grasp.csv.

    Parameters
    ----------
    scenes
        Number of scenes of each dial setting.
    seed
        Seed of the first scene.
    family
        Arrangement of the objects: single, packed or pile.
    friction
        Coulomb friction coefficient of the hand's pads.
    shake
        Duration of the shake after each lift, s.
    count
        Number of objects of a packed or piled scene, 1 to 15.
    jobs
        Number of parallel processes; default: the number of cores.
    cluster
        Address of a Dask scheduler whose workers run the scenes, tcp://host:8786.
    quick
        Run two scenes of two objects at three dial settings only.
    fresh
        Discard the stored rows in the output folder.
    out
        Output folder; default: a folder in out/chart_grasp per set of options.
    json
        Print one JSON object on stdout; the table goes to stderr.
    public
        The objects, and the public protocol instead of the own one.
    """
    public = public or ProtocolChoice()
    if public.protocol == "clutter-removal":
        # The protocol loads the planner's kernels, which other charts do not need.
        from .protocol_chart import chart_protocol

        settings = public.settings(family, seed, jobs, quick=quick)
        folder = out or OUT / f"protocol_{Path(public.hand).stem}_{family}"
        make_folder(folder)
        return chart_protocol(settings, folder / CHART_FILE, quick=quick, json=json)
    seeds, count = checked_scenes(scenes, seed, count, quick=quick)
    check_condition(friction, shake)
    machines = checked_machines(jobs, cluster)
    settings = [(DEFAULT, DEFAULT), FASTEST, MOST_RELIABLE] if quick else dial_settings()
    conditions = [
        Condition(family, friction, shake, perception=perception, control=control)
        for perception, control in settings
    ]
    conditions = with_objects(conditions, public.objects, public.split, None)
    extras = trial_extras("lift", public.objects)
    check_objects_fit(public.objects, conditions, seeds, count)
    plan = RunPlan.of(conditions, seeds, count, extras, out, OUT)
    done = run_plan(plan, machines, run_grasp_trial, fresh=fresh)
    records = by_row(done.records)
    for row in done.summaries:
        row["pick_p50_s"] = median_pick_s(records[row["name"]])
    title = f"{len(seeds)} {family} scenes, seeds from {seed}"
    show(grasp_table(done.summaries, title), json_wanted=json)
    say(machines.timing_note)
    drawn = [row for row in done.summaries if row["pick_p50_s"] and row["success_pct"] is not None]
    if not drawn or drawn[0]["name"] != conditions[0].name:
        raise InputError(f"no pick of the default setting finished; the rows are in {plan.out}")
    default = drawn[0]
    points = [
        ChartPoint(dial_name(row), 1e3 * row["pick_p50_s"], row["success_pct"]) for row in drawn
    ]
    front = dial_front(points, [row["picks"] for row in drawn])
    for index, row in enumerate(drawn):
        row["on_front"] = index in front
    drawn_from = "solids" if public.objects is None else f"{public.split} objects of a folder"
    data = f"{family} scenes of {drawn_from}, friction {friction:g}"
    data += f", shake {shake:g} s" if shake else ""
    min_picks = min(row["picks"] for row in drawn)
    data = f"{data}, {len(seeds)} of them at each dial, at least"
    provenance = Provenance(data, seed, min_picks, "pick")
    figure = ParetoChart(
        "Picking unknown objects: time against success",
        "time with perception and planning; blue: dials of perception and control; default with "
        f"95 % confidence: {default['ci_low_pct']:.0f} to {default['ci_high_pct']:.0f} %",
        points,
        front,
        "successful picks",
        provenance,
        # No failure is drawn as half a failure in the largest number of picks.
        max_shown_pct=100.0 - 50.0 / max(row["picks"] for row in drawn),
        min_shown_pct=min([MIN_SHOWN_PCT, *(point.accuracy_pct for point in points)]),
    ).figure()
    write_chart(figure, plan.out / CHART_FILE, flat_rows(done.summaries))
    say(f"chart: {plan.out / CHART_FILE}; rows: {done.store.folder}")
    if json:
        print_run_json("chart_grasp", plan, done, machines)
    return exit_code(done.records, plan.scene_jobs)


def dial_settings() -> list[tuple[str, str]]:
    """Return the pairs of perception and control dials to run, the default first."""
    alone = [(name, DEFAULT) for name in PERCEPTION] + [(DEFAULT, name) for name in CONTROL]
    return list(dict.fromkeys([*alone, FASTEST, MOST_RELIABLE]))


def dial_name(row: dict[str, Any]) -> str:
    """Return the name of a setting in the chart."""
    words = [f"{row[what]} {what}" for what in ("perception", "control") if row[what] != DEFAULT]
    return ", ".join(words) or DEFAULT


def median_pick_s(records: Sequence[Record]) -> float | None:
    """Return the median time of a pick with perception and planning, s; None without picks."""
    seconds = [
        pick["seconds"] + ((pick["perceive_ms"] or 0.0) + (pick["plan_ms"] or 0.0)) / 1e3
        for pick in records
        if pick["record"] == PICK and pick["seconds"]
    ]
    return round(float(np.median(seconds)), 3) if seconds else None


def dial_front(points: Sequence[ChartPoint], picks: Sequence[int]) -> list[int]:
    """Return the indices of the settings on the Pareto front, within one pick, by rising time."""
    return simplest_front(
        [point.time_ms for point in points],
        [point.accuracy_pct for point in points],
        EQUAL_TIME_RATIO,
        100.0 / max(picks),
    )
