"""`eyehand evaluate grasp`: measure the success of grasping unknown objects in simulation."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.apps.wording import counted, seed_span
from eyehand.errors import DeviceError, InputError

from ...bench.chart_style import Provenance, write_chart
from ...bench.machine import machine_line
from .cluster import run_on_cluster
from .conditions import FAMILIES, default_conditions, requested_conditions, source_digest
from .jobs import Family, RunTrial, SceneJob, run_grasp_trial, scene_jobs
from .local_runs import run_here
from .protocol_settings import QUICK_ROUNDS, ProtocolSettings
from .rates_chart import rates_chart
from .report import write_report
from .row_store import FAULT, SCENE, RowStore, open_rows
from .run_inputs import (
    check_objects_fit,
    checked_dials,
    checked_machines,
    checked_scenes,
    default_folder,
    run_options,
    trial_extras,
)
from .summary import summary_rows
from .summary_table import grasp_table

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from .jobs import Condition
    from .run_inputs import Machines
    from .summary import Record

OUT = Path("out/evaluate_grasp")
"""Parent of the default output folders."""
REPORT_FILE, CHART_FILE = "report.html", "evaluate.png"

Repeated = Parameter(consume_multiple=True, negative="")


def evaluate_grasp(
    *,
    scenes: int = 20,
    seed: int = 0,
    family: Annotated[list[Family] | None, Repeated] = None,
    friction: Annotated[list[float] | None, Repeated] = None,
    shake: Annotated[list[float] | None, Repeated] = None,
    known: bool = True,
    camera: bool = True,
    count: int = 5,
    purpose: Literal["lift", "move", "hand-over", "use"] = "lift",
    perception: str = "default",
    control: str = "default",
    objects: Path | None = None,
    robot: Path | None = None,
    hand_frame: str = "",
    jobs: int | None = None,
    cluster: str = "",
    quick: bool = False,
    fresh: bool = False,
    out: Path | None = None,
    json: bool = False,
    protocol: Literal["own", "clutter-removal"] = "own",
    rounds: int = 20,
    hand: str = "panda",
    noise: Annotated[list[Literal["none", "dex"]] | None, Repeated] = None,
    known_table: bool = False,
    split: Literal["all", "development", "held-out"] = "all",
) -> int:
    """Clear simulated tables of unknown objects and measure the success rate.

    By default, the rows are single, packed and piled objects, each also with known poses, and
    packed objects with friction 0.6 and a 2 s shake. With --family, --friction, --shake,
    --perception or --control, the rows are all combinations of the values. A scene ends when it is
    clear, after two successive failures, or when the robot stops because of a fault or an ambiguous
    scene. Finished scenes are stored: the same command continues a stopped run. Writes
    rows/*.parquet, evaluate.png, evaluate.csv and report.html.

    Parameters
    ----------
    scenes
        Number of scenes of each row.
    seed
        Seed of the first scene. Scene k depends on seed + k only.
    family
        Arrangements of the objects: single, packed, pile.
    friction
        Coulomb friction coefficients of the hand's pads, combined with each family.
    shake
        Durations of the shake after each lift, s, combined with family and friction.
    known
        Run each row with known poses too, except the default row with a shake.
    camera
        Run each row with perception from the camera.
    count
        Number of objects of a packed or piled scene, 1 to 15.
    purpose
        Purpose of the grasps.
    perception
        Named setting of perception: default, fast, fine.
    control
        Named setting of control: default, slow, fast, planner.
    objects
        Folder of meshes (.obj, .stl) or URDFs to draw the objects from, instead of solids.
    robot
        MJCF file of another arm with its hand. For a hand whose motors drive joints,
        robot.hand.json beside robot.xml describes the fingers.
    hand_frame
        With --robot: the site or body in the palm.
    jobs
        Number of parallel processes; default: the number of cores.
    cluster
        Address of a Dask scheduler whose workers run the scenes, tcp://host:8786.
    quick
        Run at most two scenes of each row, with at most two objects.
    fresh
        Discard the stored rows in the output folder.
    out
        Output folder; default: a folder in out/evaluate_grasp per set of options.
    json
        Print one JSON object on stdout; the table goes to stderr.
    protocol
        clutter-removal: the public protocol of VGN and GIGA, a floating gripper without an arm. It
        uses --rounds, --seed, --family (packed, pile), --objects, --jobs and the options below.
    rounds
        Rounds of each row of the protocol.
    hand
        Gripper of the protocol: a built-in name or a .json file.
    noise
        Noise of the protocol's depth image: none, dex.
    known_table
        Correct scale and tilt of the protocol's image from the known height of the table.
    split
        Objects of the protocol: all, or one half by their names.
    """
    if protocol == "clutter-removal":
        return _run_protocol(
            ProtocolSettings(
                tuple(family or ("packed", "pile")),
                tuple(noise or ("none", "dex")),
                min(rounds, QUICK_ROUNDS) if quick else rounds,
                seed,
                _checked_objects(objects),
                hand,
                known_table,
                split,
                jobs,
            ),
            json=json,
        )
    seeds, count = checked_scenes(scenes, seed, count, quick=quick)
    if not (known or camera):
        raise InputError("--no-known and --no-camera exclude each other: remove one of them")
    machines = checked_machines(jobs, cluster)
    dials = checked_dials(perception, control)
    extras = trial_extras(purpose, objects, robot, hand_frame)
    if (family, friction, shake) == (None, None, None) and dials == ("default", "default"):
        conditions = default_conditions(camera=camera, known=known)
    else:
        conditions = requested_conditions(
            family or FAMILIES, friction or [1.0], shake or [0.0], dials, camera=camera, known=known
        )
    check_objects_fit(objects, conditions, seeds, count)
    plan = RunPlan.of(conditions, seeds, count, extras, out, OUT)
    done = run_plan(plan, machines, run_grasp_trial, fresh=fresh)
    title = f"{counted(len(seeds), 'scene')} of each row, {seed_span(seed, len(seeds))}"
    show(grasp_table(done.summaries, title), json_wanted=json)
    say(machines.timing_note)
    provenance = Provenance(
        "simulated arm and hand, one noisy depth view", seed, len(seeds), "scene"
    )
    footer = [
        title,
        f"eyehand {metadata.version('eyehand')}, {machine_line()}",
        machines.timing_note,
        f"code {source_digest()}; rows: {done.store.folder}",
    ]
    chart, page = plan.out / CHART_FILE, plan.out / REPORT_FILE
    write_chart(rates_chart(done.summaries, provenance), chart, flat_rows(done.summaries))
    write_report(page, done.summaries, done.records, chart.read_bytes(), footer)
    say(f"report: {page}; rows: {done.store.folder}")
    if json:
        print_run_json("evaluate_grasp", plan, done, machines)
    return exit_code(done.records, plan.scene_jobs)


def _run_protocol(settings: ProtocolSettings, *, json: bool) -> int:
    # The protocol loads the planner's kernels, which other evaluations do not need.
    from .protocol import evaluate_protocol

    return evaluate_protocol(settings, json=json)


def _checked_objects(objects: Path | None) -> Path:
    if objects is None:
        raise InputError(
            "the clutter-removal protocol needs --objects FOLDER with meshes or URDFs, such as the "
            "folder that holds packed/ and pile/"
        )
    return objects


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
        results = run_here(left, run_trial, processes=machines.jobs)
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
