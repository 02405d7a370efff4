"""Rows of picks and scenes as figures: rates with their intervals, counts, the worst scenes."""

from __future__ import annotations

from collections import Counter
from shlex import quote
from typing import TYPE_CHECKING, Any

import numpy as np

from ...bench.shares import wilson_interval
from .row_store import FAULT, PICK, SCENE

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from .jobs import SceneJob

Record = dict[str, Any]
"""A row of the store, by column."""

DIGITS = 1
"""Decimals of per cent and ms: finer is noise."""
PLACED, MISPLACED = "placed", "misplaced"
"""Outcome of a pick that the robot takes for done, and of one where it is wrong."""
NO_PROTOTYPE = (None, "", "None")
"""What stands for the prototype of a refusal or a fault."""
USUAL = {
    "friction": 1.0,
    "shake": 0.0,
    "perception": "default",
    "control": "default",
}
"""Conditions of a demo: a command names those of its trial that are others."""
FILES = {"objects_dir": "objects", "robot": "robot", "hand_frame": "hand-frame"}
"""Those that are empty most often, and what the command calls them."""
AGAIN = "out/again"
"""Scenes run again have a folder each in this one."""
FAILURES = 2
"""Failed picks in a row that end a scene here; a demo goes on for longer."""


def summary_rows(
    records: Sequence[Record], planned: Sequence[SceneJob] = ()
) -> list[dict[str, Any]]:
    """Sum up each condition, in the order of their first scenes.

    Parameters
    ----------
    records
        Rows of the scenes that are done.
    planned
        All scenes; of a condition with none done there is no row.

    Returns
    -------
    list of dict
        `scenes`: those done; `missing`: those planned and not done; `attempts`: grasps begun;
        `picks`: those and what was never tried: objects that were refused, that no way led to, or
        that were not seen, a look that left a doubt, a scene that broke; `success_pct`: successful
        ones of all these picks; `cleared_pct`: objects in the tray of all objects; each with its
        95 % Wilson interval; `perceive_ms` and `plan_ms`: medians over picks, with the 90th
        percentile; `seconds_per_pick`: mean simulated time; `touched_before`: contacts with table
        or other objects before a grasp that were not meant, summed over picks; `pushing_picks`:
        picks that might push neighbours aside as the last resort; `touched_pushing`: neighbours
        that these touched. None where there is nothing to tell from.
    """
    wanted = Counter(job.row for job in planned)
    rows = [_summary(name, own) for name, own in by_row(records).items()]
    return [{**row, "missing": max(0, wanted[row["name"]] - row["scenes"])} for row in rows]


def by_row(records: Iterable[Record]) -> dict[str, list[Record]]:
    """Sort records by the name of their condition."""
    rows: dict[str, list[Record]] = {}
    for record in records:
        rows.setdefault(record["row"], []).append(record)
    return rows


def outcome_counts(records: Sequence[Record]) -> dict[str, Counter[str]]:
    """How often each outcome came, by condition."""
    return {
        name: Counter(ended(record) for record in own if record["record"] == PICK)
        for name, own in by_row(records).items()
    }


def ended(pick: Record) -> str:
    """How a pick ended: in the robot's word, unless it takes for placed what is not."""
    return MISPLACED if pick["outcome"] == PLACED and not pick["success"] else pick["outcome"]


def prototype_rows(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Success by prototype, over all conditions with a camera and over those with known poses."""
    rows = []
    picks = [r for r in records if r["record"] == PICK and r["prototype"] not in NO_PROTOTYPE]
    for known in (False, True):
        own = [pick for pick in picks if bool(pick["known"]) == known]
        for prototype, count in Counter(pick["prototype"] for pick in own).most_common():
            wins = sum(pick["success"] for pick in own if pick["prototype"] == prototype)
            name = f"{prototype}, known" if known else prototype
            rows.append({"name": name, **_rate("", wins, count), "picks": count, "successes": wins})
    return rows


def worst_scenes(records: Sequence[Record], most: int) -> list[dict[str, Any]]:
    """List scenes that left something: faults, then the least cleared, those with most failures.

    Returns
    -------
    list of dict
        `name` of the condition, `seed`, `placed`, `objects`, `failed` picks, `why` (the first
        failure in words), and the `command` that runs it again.
    """
    found = []
    for scene in (record for record in records if record["record"] == SCENE):
        picks = [r for r in records if r["record"] == PICK and r["key"] == scene["key"]]
        failed = [pick for pick in picks if not pick["success"]]
        if failed or (scene["placed"] or 0) < (scene["total"] or 0):
            found.append((scene, failed))
    found.sort(key=lambda item: _badness(*item))
    return [_told(scene, failed) for scene, failed in found[:most]]


def again(record: Record) -> str:
    """Command that shows a scene again, or runs it where the demo has no such conditions."""
    if not record["known"] and not record["objects_dir"] and not _unusual(record):
        purpose = "" if record["purpose"] in (None, "lift") else f" --purpose {record['purpose']}"
        return (
            f"eyehand demo --scene {record['family']} --seed {record['seed']} "
            f"--objects {record['objects']} --failures {FAILURES}{purpose}{_files(record)} "
            f"--out {AGAIN}/{record['key']}"
        )
    words = ["eyehand evaluate grasp", "--scenes 1", f"--seed {record['seed']}"]
    words.append(f"--family {record['family']}")
    words += [f"--{name} {_word(record[name])}" for name in _unusual(record)]
    words += [] if record["purpose"] in (None, "lift") else [f"--purpose {record['purpose']}"]
    words.append("--no-camera" if record["known"] else "--no-known")
    if record["family"] != "single":
        words.append(f"--count {record['objects']}")
    return f"{' '.join(words)}{_files(record)} --out {AGAIN}/{record['key']}"


def _unusual(record: Record) -> list[str]:
    return [name for name, usual in USUAL.items() if record[name] not in (usual, None)]


def _files(record: Record) -> str:
    return "".join(
        f" --{option} {quote(record[column])}" for column, option in FILES.items() if record[column]
    )


def _summary(name: str, records: Sequence[Record]) -> dict[str, Any]:
    scenes = [record for record in records if record["record"] == SCENE]
    picks = [record for record in records if record["record"] == PICK]
    wins = sum(bool(pick["success"]) for pick in picks)
    placed = sum(scene["placed"] or 0 for scene in scenes)
    total = sum(scene["total"] or 0 for scene in scenes)
    first = scenes[0]
    return {
        "name": name,
        **{key: first[key] for key in ("family", "friction", "known", "perception", "control")},
        "shake_s": first["shake"],
        "scenes": len(scenes),
        "faults": sum(scene["outcome"] == FAULT for scene in scenes),
        "attempts": sum(bool(pick["tried"]) for pick in picks),
        "picks": len(picks),
        "successes": wins,
        **_rate("", wins, len(picks)),
        "placed": placed,
        "objects": total,
        **_rate("cleared_", min(placed, total), total),
        **_times("perceive", picks),
        **_times("plan", picks),
        "seconds_per_pick": _rounded(_mean(_figures(picks, "seconds")), 2),
        "wall_seconds_per_pick": _rounded(_mean(_figures(picks, "wall_seconds")), 2),
        "touched_before": sum(pick["touched_before"] or 0 for pick in picks),
        "pushing_picks": sum(bool(pick["pushed"]) for pick in picks),
        "touched_pushing": sum(pick["touched_pushing"] or 0 for pick in picks),
        "outcomes": dict(Counter(ended(pick) for pick in picks).most_common()),
    }


def _rate(prefix: str, wins: int, tries: int) -> dict[str, float | None]:
    low, high = wilson_interval(wins, tries)
    share = _rounded(100 * wins / tries) if tries else None
    return {
        f"{prefix}pct" if prefix else "success_pct": share,
        f"{prefix}ci_low_pct": _rounded(100 * low),
        f"{prefix}ci_high_pct": _rounded(100 * high),
    }


def _times(stage: str, picks: Sequence[Record]) -> dict[str, float | None]:
    times = _figures(picks, f"{stage}_ms")
    middle, late = np.percentile(times, [50, 90]) if times else (None, None)
    return {f"{stage}_ms": _rounded(middle), f"{stage}_p90_ms": _rounded(late)}


def _figures(picks: Sequence[Record], column: str) -> list[float]:
    return [pick[column] for pick in picks if pick[column] is not None]


def _mean(figures: Sequence[float]) -> float | None:
    return sum(figures) / len(figures) if figures else None


def _rounded(figure: float | None, digits: int = DIGITS) -> float | None:
    return None if figure is None else round(float(figure), digits)


def _badness(scene: Record, failed: Sequence[Record]) -> tuple[bool, float, int]:
    share = (scene["placed"] or 0) / (scene["total"] or 1)
    return scene["outcome"] != FAULT, share, -len(failed)


def _told(scene: Record, failed: Sequence[Record]) -> dict[str, Any]:
    why = scene["stopped"] or ""
    if failed:
        first = failed[0]
        why = f"{ended(first)}: {first['reason']}" if first["reason"] else ended(first)
        why = f"{first['object']} {why}" if first["object"] else why
    return {
        "name": scene["row"],
        "seed": scene["seed"],
        "placed": scene["placed"],
        "objects": scene["total"],
        "failed": len(failed),
        "why": why,
        "command": again(scene),
    }


def _word(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
