"""The grasps of a gripper as a table for the terminal and as rows for JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.table import Table

from ..console import counted
from ..scene_picture import colour_of

if TYPE_CHECKING:
    from .jaw_frame import GraspedFrame

DOUBTS = {
    "depth_error": "the scale of the depth is uncertain. --table-height or --depth-error corrects "
    "this, and --guarded makes it matter less",
    "friction": "the object may slip out of the pads, whose faces are not parallel to its own. "
    "--friction says how rough they are",
    "width": "the object is nearly as wide as the gripper opens",
    "thickness": "the object is hardly thicker than the minimum opening",
    "overlap": "the pads cover little of the object",
    "torque": "the object may turn between the pads",
    "seen": "the camera did not see both sides that the pads touch",
    "object": "the solid is doubtful",
    "existence": "the object is as low as the noise of the support",
    "order": "another object stands on it",
    "own_clearance": "the hand may touch the object early. --calibration-error says how exactly it "
    "moves",
    "clearance": "the hand may touch something else. --calibration-error says how exactly it moves",
    "misplaced": "the pads lose the object if the hand is a little beside its place. "
    "--calibration-error says how exactly it moves",
    "opening": "something beside the object leaves no room to open fully",
    "unseen": "a finger enters space that the camera did not see",
    "behind": "the hand enters space that the object itself hides, and it may be thicker than it "
    "looks",
    "overhang": "a side that the pads touch faces down and was not seen",
    "memory": "a similar grasp failed before",
}
"""Term of a grasp → the doubt, and the option that removes it."""
CERTAIN = 0.9
"""Success from which no doubt is named."""

COLUMNS = ("rank", "object", "width mm", "opens mm", "approach", "position mm", "success %")


def grasp_table(found: GraspedFrame) -> Table:
    """Return a table with one row per reported grasp and the times in the caption."""
    scene, grasps = found.scene, found.grasps
    safe = sum(grasp.safe for grasp in grasps)
    table = Table(
        title=f"{escape(found.source)}: {counted(len(scene.objects), 'object')}, "
        f"{counted(len(grasps), 'grasp')} of {escape(found.hand.name)}, {safe} safe",
        title_justify="left",
        caption=f"{1e3 * (scene.seconds + grasps.seconds):.0f} ms: perception "
        f"{1e3 * scene.seconds:.0f}, planning {1e3 * grasps.seconds:.0f}; positions of the tool "
        f"centre point in the {scene.reference_frame} frame",
        caption_justify="left",
    )
    for column in COLUMNS:
        table.add_column(column, justify="left" if column == "approach" else "right")
    table.add_column("safe, or forbidden by", overflow="fold")
    for rank, grasp in enumerate(found.shown, 1):
        r, g, b = colour_of(grasp.object_label).tolist()
        table.add_row(
            str(rank),
            f"[rgb({r},{g},{b})]{grasp.object_label}[/]",
            f"{1e3 * grasp.object_width:.0f}",
            f"{1e3 * grasp.width:.0f}",
            grasp.side,
            " ".join(f"{1e3 * x:.0f}" for x in grasp.position),
            f"{100 * grasp.success:.0f}",
            "safe" if grasp.safe else "; ".join(grasp.forbidden_by),
        )
    return table


def doubt_note(found: GraspedFrame) -> str:
    """Return what lowers the success of the best grasp most; empty for a certain one."""
    best = found.grasps[0]
    if best.success >= CERTAIN:
        return ""
    name = best.largest_doubt
    return f"grasp 1: {DOUBTS[name]} ({name} {best.terms[name]:.2f})"


def object_notes(found: GraspedFrame) -> list[str]:
    """Return one line for each object whose grasps are not among the reported ones."""
    notes, ranks = [], found.best_ranks
    for item in found.scene.objects:
        rank = ranks.get(item.label)
        if rank is None:
            notes.append(f"object {item.label}: no grasp: {found.why_none(item.label)}")
        elif rank > found.top:
            success = 100 * found.grasps[rank - 1].success
            notes.append(f"object {item.label}: its best grasp is number {rank}, {success:.0f} %")
    return notes


def grasp_rows(found: GraspedFrame, prefix: str | None = None) -> list[dict[str, Any]]:
    """Return the rows of ``--json``: one per reported grasp."""
    lead = f"{prefix}/" if prefix else ""
    return [
        {
            "name": f"{lead}grasp {rank}",
            "rank": rank,
            **grasp.to_dict(),
        }
        for rank, grasp in enumerate(found.shown, 1)
    ]


def frame_json(found: GraspedFrame, prefix: str | None = None) -> dict[str, Any]:
    """Return what ``--json`` reports of a frame besides its grasps."""
    scene, correction = found.scene, found.correction
    ranks = found.best_ranks
    return {
        "name": prefix or "frame",
        "source": found.source,
        "frame": scene.reference_frame,
        "grasps": len(found.grasps),
        "reason": found.grasps.reason,
        "perceive_ms": round(1e3 * scene.seconds, 2),
        "plan_ms": round(1e3 * found.grasps.seconds, 2),
        "correct_depth_ms": round(1e3 * found.correct_seconds, 2) if correction else None,
        "depth_correction": None
        if correction is None
        else {
            "scale": round(correction.scale, 6),
            "height_error_mm": round(1e3 * correction.height_error, 2),
            "tilt_deg": round(math.degrees(correction.tilt), 3),
        },
        "objects": [
            {
                "label": item.label,
                "best_rank": ranks.get(item.label),
                "reason": "" if item.label in ranks else found.why_none(item.label),
                "rejected": dict(found.grasps.rejected.get(item.label, {})),
            }
            for item in scene.objects
        ],
        "warnings": [
            {"kind": one.kind, "message": one.message, "object": one.label}
            for one in scene.warnings
        ]
        + (
            [{"kind": "depth_scale", "message": correction.warning, "object": None}]
            if correction is not None and correction.warning
            else []
        ),
    }
