"""Summaries of stored rows: rates with confidence intervals, counts, and the worst scenes."""

from __future__ import annotations

from collections import Counter
from shlex import quote
from typing import TYPE_CHECKING, Any

import numpy as np

from ...bench.shares import wilson_interval
from .row_store import FAULT, PICK, SCENE
from .unattempted import TOO_WIDE

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from .jobs import SceneJob

Record = dict[str, Any]
"""A row of the store: values by column."""

DIGITS = 1
"""Decimals of percentages and milliseconds."""
PLACED, MISPLACED = "placed", "misplaced"
"""Outcomes of a pick that the robot reports as placed. The object of a PLACED one is in the tray,
that of a MISPLACED one is not."""
NO_PROTOTYPE = (None, "", "None")
"""Values of the column `prototype` for a refusal or a fault."""
DEMO_CONDITIONS = {
    "friction": 1.0,
    "shake": 0.0,
    "load_step": 1.0,
    "perception": "default",
    "control": "default",
    "split": "all",
    "density": 0.0,
}
"""Conditions of the demo. A command names only the values that differ."""
FILES = {
    "objects_dir": "objects",
    "robot": "robot",
    "hand_frame": "hand-frame",
    "arm": "arm",
    "hand": "hand",
    "mount": "mount",
}
"""Columns of files, and their option names."""
RERUN_FOLDER = "out/again"
"""Parent of the output folders of repeated scenes."""
FAILURES = 2
"""Number of successive failed picks that ends a scene. The demo has a larger default."""


def summary_rows(
    records: Sequence[Record], planned: Sequence[SceneJob] = ()
) -> list[dict[str, Any]]:
    """Summarise each condition, in the order of the first scenes.

    Parameters
    ----------
    records
        Rows of the finished scenes.
    planned
        All scenes. A condition without a finished scene has no row.

    Returns
    -------
    list of dict
        `scenes`: finished scenes; `missing`: planned scenes that are not finished; `attempts`:
        grasps begun; `picks`: attempts plus objects that were refused, unreachable or not found,
        ambiguous scenes, and scenes that broke; `success_pct`: successful share of `picks`;
        `cleared_pct`: share of the objects that are in the tray; both with the 95 % Wilson
        interval; `perceive_ms` and `plan_ms`: medians over picks, with the 90th percentile;
        `seconds_per_pick`: mean simulated time; `picks_per_hour`: successful picks per hour of
        simulated time and computing time, with failures and ways home; `touched_before`: bodies
        touched by mistake before a grasp, summed over picks; `pushing_picks`: picks that were
        allowed to push neighbours aside; `touched_pushing`: neighbours that these touched;
        `displacement_mm`: median motion of the object from its first contact to the hold, with the
        90th percentile; `lifted`: objects that the hand alone held after the lift; `kept_pct`:
        share of these that it did not lose; `squeeze`: median force on them over the least one that
        holds by friction; `hold_brier` and `score_brier`: Brier scores of the predicted hold and of
        the grasp's score; `too_wide`: number of objects by name that are wider than the gripper
        opens; `holdable_pct` and `holdable_cleared_pct`: both rates without these. None without
        data.
    """
    wanted = Counter(job.row for job in planned)
    rows = [_summary(name, own) for name, own in by_row(records).items()]
    return [{**row, "missing": max(0, wanted[row["name"]] - row["scenes"])} for row in rows]


def by_row(records: Iterable[Record]) -> dict[str, list[Record]]:
    """Group records by the name of their condition."""
    rows: dict[str, list[Record]] = {}
    for record in records:
        rows.setdefault(record["row"], []).append(record)
    return rows


def outcome_counts(records: Sequence[Record]) -> dict[str, Counter[str]]:
    """Count the outcomes of the picks of each condition."""
    return {
        name: Counter(true_outcome(record) for record in own if record["record"] == PICK)
        for name, own in by_row(records).items()
    }


def true_outcome(pick: Record) -> str:
    """Return the outcome of a pick: as reported, unless the object is not in the tray."""
    return MISPLACED if pick["outcome"] == PLACED and not pick["success"] else pick["outcome"]


def prototype_rows(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Return the success rates by prototype, separately with camera and with known poses."""
    rows = []
    picks = [r for r in records if r["record"] == PICK and r["prototype"] not in NO_PROTOTYPE]
    for known in (False, True):
        own = [pick for pick in picks if bool(pick["known"]) == known]
        for prototype, count in Counter(pick["prototype"] for pick in own).most_common():
            wins = sum(pick["success"] for pick in own if pick["prototype"] == prototype)
            name = f"{prototype}, known" if known else prototype
            rows.append({"name": name, **rates("", wins, count), "picks": count, "successes": wins})
    return rows


def worst_scenes(records: Sequence[Record], max_count: int) -> list[dict[str, Any]]:
    """List scenes with a failed pick or a remaining object, the worst first.

    Scenes that broke come first, then scenes by rising cleared share, then by falling number of
    failed picks.

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
    found.sort(key=lambda item: _sort_key(*item))
    return [_scene_row(scene, failed) for scene, failed in found[:max_count]]


def rerun_command(record: Record) -> str:
    """Return the command that repeats a scene.

    This is a demo if its conditions, objects and camera are those of the demo, else an evaluation.
    """
    purpose = record.get("purpose") or "lift"
    extra = "" if purpose == "lift" else f" --purpose {purpose}"
    if not record["known"] and not record.get("objects_dir") and not _differing(record):
        return (
            f"eyehand demo --scene {record['family']} --seed {record['seed']} "
            f"--objects {record['objects']} --failures {FAILURES}{extra}{_files(record)} "
            f"--out {RERUN_FOLDER}/{record['key']}"
        )
    words = ["eyehand evaluate grasp", "--scenes 1", f"--seed {record['seed']}"]
    words.append(f"--family {record['family']}")
    options = {name: name.replace("_", "-") for name in _differing(record)}
    words += [f"--{option} {_value_text(record[name])}" for name, option in options.items()]
    words.append(f"{'--no-camera' if record['known'] else '--no-known'}{extra}")
    if record["family"] != "single":
        words.append(f"--count {record['objects']}")
    return f"{' '.join(words)}{_files(record)} --out {RERUN_FOLDER}/{record['key']}"


def _differing(record: Record) -> list[str]:
    return [name for name, value in DEMO_CONDITIONS.items() if record[name] not in (value, None)]


def _files(record: Record) -> str:
    return "".join(
        f" --{option} {quote(record[column])}"
        for column, option in FILES.items()
        if record.get(column)
    )


def _summary(name: str, records: Sequence[Record]) -> dict[str, Any]:
    scenes = [record for record in records if record["record"] == SCENE]
    picks = [record for record in records if record["record"] == PICK]
    wins = sum(bool(pick["success"]) for pick in picks)
    placed = sum(scene["placed"] or 0 for scene in scenes)
    total = sum(scene["total"] or 0 for scene in scenes)
    work_seconds = sum(_figures(scenes, "work_seconds"))
    wide = Counter(pick["object"].rpartition("_")[0] for pick in picks if _is_too_wide(pick))
    first = scenes[0]
    return {
        "name": name,
        **{key: first[key] for key in ("family", "friction", "known", "perception", "control")},
        "shake_s": first["shake"],
        "load_step": first["load_step"],
        "scenes": len(scenes),
        "faults": sum(scene["outcome"] == FAULT for scene in scenes),
        "attempts": sum(bool(pick["tried"]) for pick in picks),
        "picks": len(picks),
        "successes": wins,
        **rates("", wins, len(picks)),
        "placed": placed,
        "objects": total,
        **rates("cleared_", min(placed, total), total),
        **_times("perceive", picks),
        **_times("plan", picks),
        "seconds_per_pick": _rounded(_mean(_figures(picks, "seconds")), 2),
        "picks_per_hour": _rounded(3600 * wins / work_seconds, 0) if work_seconds else None,
        "wall_seconds_per_pick": _rounded(_mean(_figures(picks, "wall_seconds")), 2),
        "touched_before": sum(pick["touched_before"] or 0 for pick in picks),
        "pushing_picks": sum(bool(pick["pushed"]) for pick in picks),
        "touched_pushing": sum(pick["touched_pushing"] or 0 for pick in picks),
        **_displacements(picks),
        **_held(picks),
        "hold_brier": _brier(picks, "hold"),
        "score_brier": _brier(picks, "score"),
        "outcomes": dict(Counter(true_outcome(pick) for pick in picks).most_common()),
        "too_wide": dict(sorted(wide.items())),
        **rates("holdable_", wins, len(picks) - wide.total()),
        **rates("holdable_cleared_", min(placed, total - wide.total()), total - wide.total()),
    }


def _is_too_wide(pick: Record) -> bool:
    return pick["outcome"] == TOO_WIDE


def rates(prefix: str, wins: int, tries: int) -> dict[str, float | None]:
    """Return a rate and its 95 % Wilson interval, %: ``PREFIXpct`` and ``PREFIXci_low_pct``.

    Without a prefix, the rate is ``success_pct``.
    """
    low, high = wilson_interval(wins, tries)
    share = _rounded(100 * wins / tries) if tries else None
    return {
        f"{prefix}pct" if prefix else "success_pct": share,
        f"{prefix}ci_low_pct": _rounded(100 * low),
        f"{prefix}ci_high_pct": _rounded(100 * high),
    }


def _times(stage: str, picks: Sequence[Record]) -> dict[str, float | None]:
    times = _figures(picks, f"{stage}_ms")
    median, p90 = np.percentile(times, [50, 90]) if times else (None, None)
    return {f"{stage}_ms": _rounded(median), f"{stage}_p90_ms": _rounded(p90)}


def _displacements(picks: Sequence[Record]) -> dict[str, float | None]:
    """Return median and 90th percentile of the displacements from first contact to hold, mm."""
    metres = _figures(picks, "displacement")
    median, p90 = 1e3 * np.percentile(metres, [50, 90]) if metres else (None, None)
    return {"displacement_mm": _rounded(median), "displacement_p90_mm": _rounded(p90)}


def _held(picks: Sequence[Record]) -> dict[str, Any]:
    """Return how many lifted objects were kept, and how hard the hand squeezed them."""
    lifted = [pick for pick in picks if pick.get("lifted")]
    kept = sum(bool(pick["kept"]) for pick in lifted)
    squeezes = _figures(lifted, "squeeze")
    return {
        "lifted": len(lifted),
        "kept": kept,
        **rates("kept_", kept, len(lifted)),
        "squeeze": _rounded(float(np.median(squeezes)), 2) if squeezes else None,
    }


def _brier(picks: Sequence[Record], column: str) -> float | None:
    """Return the mean squared error of a column that predicts success (Brier 1950)."""
    known = [pick for pick in picks if pick.get(column) is not None]
    errors = [(pick[column] - bool(pick["success"])) ** 2 for pick in known]
    return _rounded(_mean(errors), 3)


def _figures(picks: Sequence[Record], column: str) -> list[float]:
    return [pick[column] for pick in picks if pick.get(column) is not None]


def _mean(figures: Sequence[float]) -> float | None:
    return sum(figures) / len(figures) if figures else None


def _rounded(figure: float | None, digits: int = DIGITS) -> float | None:
    return None if figure is None else round(float(figure), digits)


def _sort_key(scene: Record, failed: Sequence[Record]) -> tuple[bool, float, int]:
    share = (scene["placed"] or 0) / (scene["total"] or 1)
    return scene["outcome"] != FAULT, share, -len(failed)


def _scene_row(scene: Record, failed: Sequence[Record]) -> dict[str, Any]:
    why = scene["stopped"] or ""
    if failed:
        first = failed[0]
        why = (
            f"{true_outcome(first)}: {first['reason']}" if first["reason"] else true_outcome(first)
        )
        why = f"{first['object']} {why}" if first["object"] else why
    return {
        "name": scene["row"],
        "seed": scene["seed"],
        "placed": scene["placed"],
        "objects": scene["total"],
        "failed": len(failed),
        "why": why,
        "command": rerun_command(scene),
    }


def _value_text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
