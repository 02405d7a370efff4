"""A perceived frame as a table for the terminal and as rows for JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.table import Table

from .console import counted
from .scene_picture import colour_of

if TYPE_CHECKING:
    from eyehand.perception import SceneObject

    from .perceived_frame import PerceivedFrame


WHOSE = "grasps of the demo's hand (three fingers and a thumb); of your gripper: eyehand grasp"
"""Whose grasps a table shows."""


def scene_table(found: PerceivedFrame, source: str) -> Table:
    """Return a table with one row per object and the times in the caption."""
    scene = found.scene
    stages = ", ".join(f"{stage} {value * 1e3:.0f}" for stage, value in scene.timings.items())
    total = scene.seconds + found.plan_seconds
    table = Table(
        title=f"{escape(source)}: {counted(len(scene.objects), 'object')}",
        title_justify="left",
        caption=f"{total * 1e3:.0f} ms: {stages}, grasps {found.plan_seconds * 1e3:.0f}\n{WHOSE}",
        caption_justify="left",
    )
    for column in ("#", "solid", "size mm", "ε1 ε2", "spread mm", "seen %", "on", "grasp", "rows"):
        table.add_column(column, justify="right" if column in ("spread mm", "seen %") else "left")
    table.add_column("why", overflow="fold")
    for item in scene.objects:
        plan = found.plans[item.label]
        r, g, b = colour_of(item.label).tolist()
        table.add_row(
            f"[rgb({r},{g},{b})]{item.label}[/]",
            *_solid_cells(item),
            f"{item.visible_share * 100:.0f}",
            _support_name(item),
            f"{plan.prototype}, {plan.approach}" if plan else "none",
            str(plan.rows) if plan else "-",
            plan.reason,
        )
    return table


def scene_rows(found: PerceivedFrame, prefix: str | None = None) -> list[dict[str, Any]]:
    """Return the rows of ``--json``: one named ``frame`` with totals, then one per object."""
    lead = f"{prefix}/" if prefix else ""
    scene = found.scene
    rows: list[dict[str, Any]] = [
        {
            "name": f"{lead}frame",
            "objects": len(scene.objects),
            "perceive_ms": round(scene.seconds * 1e3, 2),
            "plan_ms": round(found.plan_seconds * 1e3, 2),
            **{f"{stage}_ms": round(value * 1e3, 2) for stage, value in scene.timings.items()},
        }
    ]
    for item in scene.objects:
        plan = found.plans[item.label]
        solid = item.fit.superquadric
        rows.append(
            {
                "name": f"{lead}object {item.label}",
                "kind": solid.kind if solid is not None and item.fit else None,
                "parts": len(item.fit.parts),
                "size_mm": None
                if solid is None
                else [round(2e3 * a, 1) for a in solid.semi_axes.tolist()],
                "spread_mm": round(item.fit.spread * 1e3, 3) if item.fit.residuals.size else None,
                "visible_pct": round(item.visible_share * 100, 1),
                "rests_on": item.rests_on,
                "prototype": plan.prototype,
                "task_rows": plan.rows,
                "reason": plan.reason,
            }
        )
    return rows


def _solid_cells(item: SceneObject) -> tuple[str, str, str, str]:
    solid = item.fit.superquadric
    if solid is None or not item.fit:
        return "none", "-", "-", "-"
    size = " x ".join(f"{2e3 * a:.0f}" for a in solid.semi_axes)
    exponents = f"{solid.exponents[0]:.2f} {solid.exponents[1]:.2f}"
    more = len(item.fit.parts) - 1
    kind = f"{solid.kind} + {more}" if more > 0 else solid.kind
    return kind, size, exponents, f"{item.fit.spread * 1e3:.1f}"


def _support_name(item: SceneObject) -> str:
    if item.rests_on is None:
        return "?"
    return "table" if item.rests_on == 0 else f"object {item.rests_on}"
