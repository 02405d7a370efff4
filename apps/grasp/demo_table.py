"""The picks of a demo as a printed table and as JSON rows."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.table import Table

from ..console import plural
from ..scene_picture import colour_of

if TYPE_CHECKING:
    from eyehand.grasping import ClearReport, GraspPlan

    from .demo_record import Capture, DemoRecord

TEXT_COLUMNS = ("object", "size mm", "grasp", "outcome")
"""Columns of the table that are aligned to the left. Numbers are aligned to the right."""


def demo_table(record: DemoRecord) -> Table:
    """Return the table, with one row per pick and the result as caption."""
    table = Table(
        title=escape(record.source),
        title_justify="left",
        caption=escape(ending(record)),
        caption_justify="left",
    )
    names = "pick,object,size mm,grasp,rows,perceive ms,plan ms,simulated s,outcome"
    for name in names.split(","):
        table.add_column(name, justify="left" if name in TEXT_COLUMNS else "right")
    for number, capture in enumerate(_picked(record), start=1):
        pick = capture.pick
        assert pick is not None
        red, green, blue = colour_of(capture.colours.get(pick.label, pick.label)).tolist()
        outcome = f"{capture.outcome}: {pick.reason}" if pick.reason else capture.outcome
        tasks = task_words(pick.plan)
        table.add_row(
            str(number),
            f"[rgb({red},{green},{blue})]■[/] {pick.kind}",
            _size(capture),
            pick.plan.name,
            f"{pick.plan.rows}: {tasks}" if tasks else str(pick.plan.rows),
            f"{pick.perceive_ms:.0f}",
            f"{pick.plan_ms:.0f}",
            f"{pick.seconds:.1f}",
            f"[{'green' if capture.succeeded else 'red'}]{escape(outcome)}[/]",
        )
    return table


def demo_rows(record: DemoRecord) -> list[dict[str, Any]]:
    """Return the rows for ``--json``, one per pick."""
    rows = []
    for number, capture in enumerate(_picked(record), start=1):
        pick, row = capture.pick, capture.row
        assert pick is not None
        rows.append(
            {
                "name": f"pick {number}",
                "object": None if row is None else row.object,
                "kind": pick.kind,
                "prototype": pick.plan.prototype,
                "approach": pick.plan.approach,
                "task_rows": pick.plan.rows,
                "tasks": [
                    {"task": task.name, "rows": task.rows, "description": task.description}
                    for task in pick.plan.tasks
                ],
                "perceive_ms": round(pick.perceive_ms, 2),
                "plan_ms": round(pick.plan_ms, 2),
                "simulated_s": round(pick.seconds, 3),
                "outcome": pick.outcome,
                "reason": pick.reason,
                "in_tray": None if row is None else row.success,
                "touched_before": None if row is None else row.touched_before,
                "largest_force_n": round(float(pick.forces.max(initial=0.0)), 2),
                "pads": pick.contact_pads,
                "curl_rad": round(pick.finger_curl, 3),
                "phases": [
                    {
                        "phase": phase.phase,
                        "seconds": round(phase.end - phase.start, 3),
                        "outcome": phase.outcome,
                    }
                    for phase in pick.phases
                ],
            }
        )
    return rows


def task_words(plan: GraspPlan) -> str:
    """Name the tasks with rows, equal ones with a count: ``2 x point on plane + orientation``."""
    counts = Counter(task.name.replace("_", " ") for task in plan.tasks if task.rows)
    return " + ".join(f"{count} x {name}" if count > 1 else name for name, count in counts.items())


def ending(record: DemoRecord) -> str:
    """Describe the result in a few lines."""
    result = record.result
    objects = plural(result.total, "object")
    lines = [f"{result.placed} of {result.total} {objects} in the tray; {stop_text(record.report)}"]
    lines += [f"remaining {line}" for line in record.report.remaining]
    film = record.film_cpu_seconds
    film_time = "" if film is None else f"; {film:.1f} s more for the film"
    lines.append(
        f"{result.cpu_seconds:.1f} s of processor time for robot and simulation{film_time}"
    )
    return "\n".join(lines)


def stop_text(report: ClearReport) -> str:
    """Describe why clearing ended."""
    return "the table is clear" if report.cleared else f"stopped: {report.stop_reason}"


def _picked(record: DemoRecord) -> list[Capture]:
    return [capture for capture in record.captures if capture.pick is not None]


def _size(capture: Capture) -> str:
    item = capture.target
    solid = item.fit.superquadric if item is not None else None
    return "-" if solid is None else " x ".join(f"{2e3 * a:.0f}" for a in solid.semi_axes)
