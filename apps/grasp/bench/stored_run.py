"""Stored runs of simulated scenes: plan them, run the unfinished ones, and summarise all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from eyehand.apps.console import print_json, say, tracked
from eyehand.errors import DeviceError

from ...bench.machine import machine_line
from .cluster import run_on_cluster
from .jobs import PREPARATIONS, Condition, RunTrial, SceneJob, scene_jobs
from .local_runs import run_here
from .row_store import FAULT, SCENE, RowStore, open_rows
from .run_inputs import Machines, default_folder, run_options
from .summary import Record, summary_rows


@dataclass(frozen=True)
class RunPlan:
    """The scenes of a run and the options that identify it."""

    conditions: Sequence[Condition]
    """Conditions, one per row of the table."""
    seeds: range
    """Seeds of the scenes of each condition."""
    scene_jobs: Sequence[SceneJob]
    """All scenes."""
    options: Mapping[str, Any]
    """Everything that the stored rows depend on."""
    out: Path
    """Output folder."""

    @classmethod
    def of(
        cls,
        conditions: Sequence[Condition],
        seeds: range,
        count: int,
        extras: Mapping[str, Any],
        out: Path | None,
        parent: Path,
    ) -> RunPlan:
        """Plan the scenes.

        If `out` is None, the output folder is in `parent`, and its name identifies the options.
        """
        options = run_options(conditions, seeds.start, count, extras)
        jobs = scene_jobs(conditions, seeds, count, extras)
        return cls(
            conditions, seeds, jobs, options, out or default_folder(parent, conditions, options)
        )


@dataclass(frozen=True)
class FinishedRun:
    """The stored rows of a run and their summaries."""

    store: RowStore
    """The folder of the stored rows."""
    records: Sequence[Record]
    """Stored rows of all finished scenes."""
    summaries: list[dict[str, Any]]
    """Summary of each condition."""


def run_plan(plan: RunPlan, machines: Machines, run_trial: RunTrial, *, fresh: bool) -> FinishedRun:
    """Run the unfinished scenes of a plan with `run_trial`, and summarise all scenes.

    Raises
    ------
    InputError
        If the output folder holds rows of other options, or no cluster answers.
    DeviceError
        If no scene has an outcome, the cluster fails, or the disk fails.
    """
    store = open_rows(plan.out, plan.options, fresh=fresh)
    run_scenes(plan.scene_jobs, store, machines, run_trial)
    records = finished_rows(store, plan.scene_jobs)
    return FinishedRun(store, records, summary_rows(records, plan.scene_jobs))


def print_run_json(command: str, plan: RunPlan, done: FinishedRun, machines: Machines) -> None:
    """Print the JSON object of a run."""
    print_json(
        command,
        plan.seeds.start,
        done.summaries,
        scenes=len(plan.seeds),
        options=plan.options,
        machine=machine_line(),
        timing=machines.timing_note,
        out=str(plan.out),
    )


def flat_rows(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows without their outcome counts, for a CSV file."""
    return [{key: value for key, value in row.items() if key != "outcomes"} for row in rows]


def run_scenes(
    planned: Sequence[SceneJob], store: RowStore, machines: Machines, run_trial: RunTrial
) -> None:
    """Run the unfinished scenes with `run_trial`, and store each as it finishes.

    A scene without an outcome (its process was killed, it took too long) is reported and not
    stored. The next run tries it again.

    Raises
    ------
    InputError
        If no cluster answers at the address.
    DeviceError
        If the cluster or the disk fails.
    """
    done = store.finished()
    left = [job for job in planned if job.key not in done]
    if not left:
        return
    if machines.cluster:
        results = run_on_cluster(left, run_trial, machines.cluster)
    else:
        results = run_here(
            left, run_trial, processes=machines.jobs, prepare=PREPARATIONS.get(run_trial)
        )
    ended = 0
    try:
        with closing(results):
            for job, outcome in tracked(results, "clearing", len(left)):
                name = f"{job.row}, seed {job.trial['seed']}"
                if outcome.lost:
                    say(f"{name} has no outcome: {outcome.lost}")
                    continue
                store.add(job, outcome)
                ended += 1
                if outcome.fault:
                    say(f"{name} ended with a fault: {outcome.fault}")
    except KeyboardInterrupt:
        kept = len(planned) - len(left) + ended
        say(f"{kept} of {len(planned)} scenes are stored; run the same command to continue")
        raise


def finished_rows(store: RowStore, planned: Sequence[SceneJob]) -> list[Record]:
    """Return the rows of the finished scenes, and report the missing ones.

    Raises
    ------
    DeviceError
        If no scene is finished.
    """
    missing = len({job.key for job in planned} - store.finished())
    if missing == len(planned):
        raise DeviceError(
            f"none of {missing} scenes has an outcome; run the same command to try again"
        )
    if missing:
        say(f"{missing} of {len(planned)} scenes are missing; run the same command to try them")
    return store.read(planned)


def exit_code(records: Sequence[Record], planned: Sequence[SceneJob]) -> int:
    """Return 1 if a scene is missing or every scene ended with a fault, else 0."""
    scenes = [record for record in records if record["record"] == SCENE]
    faults = [scene for scene in scenes if scene["outcome"] == FAULT]
    if len(faults) == len(scenes):
        say(f"every scene ended with a fault, the first: {faults[0]['reason']}")
        return 1
    return int(len(scenes) < len(planned))
