"""`eyehand evaluate grasp --protocol clutter-removal`: the public protocol with the own planner."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from eyehand.apps.console import counted, print_json, say, seed_span, show, tracked
from eyehand.errors import DeviceError, InputError
from eyehand.grasping import JawOptions, load_hand

from ...bench.dials import DialSetting
from ...bench.machine import core_count, machine_line
from ...bench.shares import percent
from ..clutter_round import Changes, ClutterTrial, clutter_objects, run_clutter_round
from .jobs import SceneJob
from .local_runs import run_here
from .protocol_settings import PROTOCOL_COUNT, ProtocolSettings
from .protocol_table import PUBLISHED, calibration_table, failure_line, protocol_table
from .run_inputs import check_count
from .summary import rates

BINS = 5
"""Number of bins of the predicted probability, with equally many grasps."""


def evaluate_protocol(settings: ProtocolSettings, *, json: bool) -> int:
    """Run all rounds, print the table beside published rows, and return the exit code.

    Raises
    ------
    InputError
        If a setting is out of range or the folder has no objects.
    DeviceError
        If no round has an outcome.
    """
    jobs = protocol_jobs(settings)
    outcomes = run_rounds(jobs, settings.jobs)
    rows = summaries(jobs, outcomes)
    title = (
        f"clutter-removal protocol, {settings.hand}, {counted(settings.rounds, 'round')} of each "
        f"row, {seed_span(settings.seed, settings.rounds)}, {settings.split} objects"
    )
    show(protocol_table(rows, title), json_wanted=json)
    for row in rows:
        say(failure_line(row))
    show(
        calibration_table(_bins([one for row in rows for one in _attempts(outcomes[row["name"]])])),
        json_wanted=json,
    )
    if json:
        print_json(
            "evaluate_grasp_protocol",
            settings.seed,
            [*rows, *PUBLISHED],
            protocol="clutter-removal",
            rounds=[{"row": name, **one} for name in outcomes for one in outcomes[name]],
            hand=settings.hand,
            machine=machine_line(),
            version=metadata.version("eyehand"),
        )
    return int(sum(len(found) for found in outcomes.values()) < len(jobs))


def run_rounds(jobs: Sequence[SceneJob], processes: int | None) -> dict[str, list[dict[str, Any]]]:
    """Run rounds in parallel processes (None: one per core), and return the outcomes by row.

    Raises
    ------
    DeviceError
        If no round has an outcome.
    """
    outcomes: dict[str, list[dict[str, Any]]] = {}
    results = run_here(
        jobs, run_clutter_round, processes=processes or core_count(), prepare=prepare_planning
    )
    for job, outcome in tracked(results, "rounds", len(jobs)):
        if outcome.lost or outcome.fault:
            say(f"{job.row}, seed {job.trial['seed']}: {outcome.lost or outcome.fault}")
            continue
        outcomes.setdefault(job.row, []).append({**outcome.result, "seed": job.trial["seed"]})
    if not outcomes:
        raise DeviceError("no round has an outcome")
    return outcomes


def prepare_planning() -> None:
    """Load the kernels of a round."""
    # Physics and kernels load in the processes only.
    from ..warm_up import warm_up_grasping

    warm_up_grasping(jaws=True)


def summaries(
    jobs: Sequence[SceneJob], outcomes: Mapping[str, Sequence[Mapping[str, Any]]]
) -> list[dict[str, Any]]:
    """Return the rows of the table, in the order of the jobs."""
    trials = {job.row: job.trial for job in reversed(jobs)}
    names = dict.fromkeys(job.row for job in jobs)
    return [_summary(name, outcomes[name], trials[name]) for name in names if name in outcomes]


def protocol_jobs(
    settings: ProtocolSettings, dials: Sequence[DialSetting[JawOptions]] = ()
) -> list[SceneJob]:
    """List the rounds, seed by seed, with each setting of the planner's dials.

    Raises
    ------
    InputError
        If a setting is out of range or the folder has no objects.
    """
    if settings.known_table and settings.learned_table:
        raise InputError("--known-table and --learned-table exclude each other: remove one of them")
    if settings.rounds < 1:
        raise InputError(f"--rounds must be >= 1, got {settings.rounds}")
    if not all(0.0 <= error < math.inf for error in settings.misplaced):
        raise InputError(f"--misplaced must be finite and >= 0, got {settings.misplaced}")
    check_count(settings.count)
    load_hand(settings.hand)
    for family in settings.families:
        if family not in ("packed", "pile"):
            raise InputError(f"--family of this protocol is packed or pile, got {family!r}")
        clutter_objects(str(_folder(settings.objects, family)), settings.split, settings.density)
    planners = {f", {one.name}": dict(one.dials) for one in dials} or {"": {}}
    return [
        SceneJob(
            _row_name(settings, family, noise) + name,
            asdict(
                ClutterTrial(
                    family="packed" if family == "packed" else "pile",
                    seed=settings.seed + number,
                    objects=str(_folder(settings.objects, family)),
                    noise=noise,
                    known_table=settings.known_table,
                    learned_table=settings.learned_table,
                    safe_only=settings.safe_only,
                    hand=settings.hand,
                    split=settings.split,
                    density=settings.density,
                    count=settings.count,
                    changes=Changes(
                        1e-3 * settings.misplaced[0], math.radians(settings.misplaced[1])
                    ),
                    planner=planner,
                )
            ),
        )
        for number in range(settings.rounds)
        for family in settings.families
        for noise in settings.noises
        for name, planner in planners.items()
    ]


def _folder(objects: Path, family: str) -> Path:
    return objects / family if (objects / family).is_dir() else objects


def _row_name(settings: ProtocolSettings, family: str, noise: str) -> str:
    words = [family, "dex noise" if noise == "dex" else "no noise"]
    words += [f"{settings.count} objects"] * (settings.count != PROTOCOL_COUNT)
    words += [f"{settings.density:g} kg/m³"] if settings.density else []
    words += ["table known"] * settings.known_table + ["table learned"] * settings.learned_table
    words += ["only safe grasps"] * settings.safe_only
    if any(settings.misplaced):
        words.append("misplaced by {:g} mm and {:g}°".format(*settings.misplaced))
    return ", ".join(words)


def _summary(
    name: str, rounds: Sequence[Mapping[str, Any]], trial: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the row of one condition."""
    attempts = _attempts(rounds)
    begun = [one for one in rounds if one["attempts"]]
    light = [attempt for attempt in attempts if not attempt["heavy"]]
    wins = sum(attempt["success"] for attempt in attempts)
    placed = sum(one["placed"] for one in rounds)
    heavy = Counter(name for one in rounds for name in one["heavy"])
    light_wins = sum(attempt["success"] for attempt in light)
    light_placed = placed - heavy.total()
    causes = Counter(attempt["cause"] for attempt in attempts if attempt["cause"])
    return {
        "name": name,
        "family": trial["family"],
        "noise": trial["noise"],
        "known_table": trial["known_table"],
        "learned_table": trial["learned_table"],
        "safe_only": trial["safe_only"],
        "count": trial["count"],
        "density": trial["density"],
        "rounds": len(rounds),
        "attempts": len(attempts),
        "objects": placed,
        **rates("success_", wins, len(attempts)),
        **rates("declutter_", min(wins, placed), placed),
        **rates("light_success_", light_wins, len(light)),
        **rates("light_declutter_", min(light_wins, light_placed), light_placed),
        "heavy_objects": dict(sorted(heavy.items())),
        "nothing_offered": sum(one["ended"].startswith("no grasp") for one in rounds),
        "causes": dict(causes.most_common()),
        "causes_text": ", ".join(f"{name} {count}" for name, count in causes.most_common())
        or "none",
        "calibration": _bins(attempts),
        "perceive_ms": _median([a["perceive_ms"] for a in attempts]),
        "plan_ms": _median([a["plan_ms"] for a in attempts]),
        "first_plan_ms": _median([one["attempts"][0]["plan_ms"] for one in begun]),
        "measured_by": "eyehand",
    }


def _attempts(rounds: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    return [attempt for one in rounds for attempt in one["attempts"]]


def _bins(attempts: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return predicted and observed success in bins of equally many attempts."""
    predicted = np.array([attempt["predicted"] for attempt in attempts])
    success = np.array([attempt["success"] for attempt in attempts], dtype=np.float64)
    order = np.argsort(predicted, kind="stable")
    return [
        {
            "low_pct": percent(float(predicted[part].min())),
            "high_pct": percent(float(predicted[part].max())),
            "attempts": len(part),
            "predicted_pct": percent(float(predicted[part].mean())),
            "observed_pct": percent(float(success[part].mean())),
        }
        for part in np.array_split(order, BINS)
        if len(part)
    ]


def _median(values: Sequence[float]) -> float | None:
    return round(float(np.median(values)), 1) if values else None
