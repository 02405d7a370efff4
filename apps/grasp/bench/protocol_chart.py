"""`eyehand chart grasp --protocol clutter-removal`: planning time of a gripper against success."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from eyehand.apps.console import counted, print_json, say, seed_span, show
from eyehand.errors import InputError
from eyehand.grasping import JawOptions

from ...bench.chart_style import Provenance, write_chart
from ...bench.dials import DialBoard
from ...bench.machine import machine_line
from ...bench.pareto import simplest_front
from ...bench.pareto_chart import MIN_SHOWN_PCT, ChartPoint, ParetoChart
from .protocol import protocol_jobs, run_rounds, summaries
from .protocol_settings import ProtocolSettings
from .protocol_table import protocol_table

DIALS = DialBoard(
    JawOptions(),
    {
        "approaches": (8, 12, 18, 24, 36),
        "tested": (30, 100, 220, 600),
        "per_object": (1, 3),
    },
    ({"approaches": (8, 12), "tested": (30, 100), "per_object": (1,)},),
    quick={"approaches": (8,)},
    words={("per_object", 1): "one grasp per object"},
)
"""The dials of the planner."""
SAME_TIME = 1.05
"""Times with a smaller ratio count as equal: processor time varies on a busy machine."""


def chart_protocol(settings: ProtocolSettings, out: Path, *, quick: bool, json: bool) -> int:
    """Run the same rounds at each setting of the planner, and chart time against success.

    Parameters
    ----------
    settings
        One family and one noise of the protocol.
    out
        The chart, .png; its figures are written beside it.
    quick
        Whether to run two settings only.
    json
        Whether to print one JSON object.

    Returns
    -------
    int
        Exit code: 0 if all rounds have an outcome.

    Raises
    ------
    InputError
        If a setting is out of range, the folder has no objects, or no grasp was tried.
    DeviceError
        If no round has an outcome.
    """
    dials = DIALS.settings(quick=quick)
    jobs = protocol_jobs(settings, dials)
    outcomes = run_rounds(jobs, settings.jobs)
    rows = summaries(jobs, outcomes)
    span = seed_span(settings.seed, settings.rounds)
    rounds = counted(settings.rounds, "round")
    title = f"clutter-removal protocol, {settings.hand}, {rounds} of each row, {span}"
    show(protocol_table(rows, title), json_wanted=json)
    names = {jobs[index].row: dial.name for index, dial in enumerate(dials)}
    drawn = [row for row in rows if row["plan_ms"] is not None]
    if not drawn or drawn[0]["name"] != jobs[0].row:
        raise InputError("no grasp was tried at the default setting, choose another --seed")
    points = [ChartPoint(names[row["name"]], row["plan_ms"], row["success_pct"]) for row in drawn]
    grasps = [row["attempts"] for row in drawn]
    front = _front(points, grasps)
    for index, row in enumerate(drawn):
        row["on_front"] = index in front
    write_chart(_chart(points, front, grasps, drawn[0], settings).figure(), out, _flat(rows))
    say(f"chart: {out}")
    if json:
        print_json(
            "chart_grasp_protocol",
            settings.seed,
            rows,
            protocol="clutter-removal",
            hand=settings.hand,
            machine=machine_line(),
            version=metadata.version("eyehand"),
        )
    return int(sum(len(found) for found in outcomes.values()) < len(jobs))


def _front(points: Sequence[ChartPoint], grasps: Sequence[int]) -> list[int]:
    """Return the indices of the Pareto front. Differences of one grasp are none."""
    times = [point.time_ms for point in points]
    return simplest_front(
        times, [point.accuracy_pct for point in points], SAME_TIME, 100.0 / max(grasps)
    )


def _chart(
    points: Sequence[ChartPoint],
    front: Sequence[int],
    grasps: Sequence[int],
    default: dict[str, Any],
    settings: ProtocolSettings,
) -> ParetoChart:
    noise = "dex noise" if settings.noises[0] == "dex" else "no noise"
    table = ", table known" if settings.known_table else ""
    data = f"clutter-removal protocol, {settings.hand}, {settings.families[0]}, {noise}{table}"
    return ParetoChart(
        "Planning grasps of unknown objects: time against success",
        "processor time on one thread; blue: dials of the planner; default with 95 % confidence: "
        f"{default['success_ci_low_pct']:.0f} to {default['success_ci_high_pct']:.0f} %",
        points,
        front,
        "successful grasps",
        Provenance(data, settings.seed, min(grasps), "grasp"),
        # No failure is drawn as half a failure in the largest number of grasps.
        max_shown_pct=100.0 - 50.0 / max(grasps),
        min_shown_pct=min([MIN_SHOWN_PCT, *(point.accuracy_pct for point in points)]),
    )


def _flat(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows without nested values, for the .csv file."""
    return [
        {key: value for key, value in row.items() if not isinstance(value, (dict, list))}
        for row in rows
    ]
