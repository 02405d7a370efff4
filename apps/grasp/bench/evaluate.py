"""`eyehand evaluate grasp`: measure the success of grasping unknown objects in simulation."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from eyehand.apps.console import counted, say, seed_span, show
from eyehand.errors import InputError

from ...bench.chart_style import Provenance, write_chart
from ...bench.machine import machine_line
from ..robot_choice import RobotChoice
from .conditions import EXACT, FAMILIES, default_conditions, requested_conditions, source_digest
from .jobs import Family, run_grasp_trial
from .protocol_settings import QUICK_ROUNDS, ProtocolSettings, checked_objects
from .rates_chart import rates_chart
from .report import write_report
from .run_inputs import (
    Machines,
    check_objects_fit,
    checked_dials,
    checked_machines,
    checked_scenes,
    trial_extras,
    with_objects,
)
from .stored_run import FinishedRun, RunPlan, exit_code, flat_rows, print_run_json, run_plan
from .summary_table import grasp_table

OUT = Path("out/evaluate_grasp")
"""Parent of the default output folders."""
REPORT_FILE, CHART_FILE = "report.html", "evaluate.png"


def evaluate_grasp(
    *,
    scenes: int = 20,
    seed: int = 0,
    family: list[Family] | None = None,
    friction: list[float] | None = None,
    shake: list[float] | None = None,
    load_step: list[float] | None = None,
    sensor: list[str] | None = None,
    known: bool = True,
    camera: bool = True,
    count: int = 5,
    purpose: Literal["lift", "move", "hand-over", "use"] = "lift",
    perception: str = "default",
    control: str = "default",
    objects: Path | None = None,
    robot: Annotated[RobotChoice | None, Parameter(name="*", group="Robot")] = None,
    jobs: int | None = None,
    cluster: str = "",
    quick: bool = False,
    fresh: bool = False,
    out: Path | None = None,
    json: bool = False,
    protocol: Literal["own", "clutter-removal"] = "own",
    rounds: int = 20,
    noise: list[Literal["none", "dex"]] | None = None,
    known_table: bool = False,
    learned_table: bool = False,
    safe_only: bool = False,
    misplaced: tuple[float, float] = (0.0, 0.0),
    split: Literal["all", "development", "held-out"] = "all",
    density: float | None = None,
) -> int:
    """Clear simulated tables of unknown objects and measure the success rate.

    By default, the rows are single, packed and piled objects, each also with known poses, and
    packed objects with friction 0.6 and a 2 s shake. With --family, --friction, --shake,
    --load-step, --sensor, --perception or --control, the rows are all combinations of the values. A
    scene ends when it is clear, after two successive failures, or when the robot stops because of a
    fault or an ambiguous scene. Finished scenes are stored: the same command continues a stopped
    run. Writes rows/*.json, evaluate.png, evaluate.csv and report.html.

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
    load_step
        Loads on the lifted object while the hand checks and shakes it, as multiples of its weight.
    sensor
        Sensor models of the hand's pads: exact, ideal, good, real, harsh. It needs fingers.
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
        Simulated robot of the own protocol. The clutter-removal protocol has a floating gripper:
        --hand is then a built-in name or a .json file (default: panda).
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
        uses --rounds, --seed, --family (packed, pile), --count, --objects, --jobs and the options
        below.
    rounds
        Rounds of each row of the protocol.
    noise
        Noise of the protocol's depth image: none, dex.
    known_table
        Correct scale and tilt of the protocol's image from the known height of the table.
    learned_table
        Scale the images of a round to the mean height of the table in them. It is not known.
    safe_only
        Execute only grasps that the planner calls safe. A round ends when there is none.
    misplaced
        Error of the hand's place, mm, and of its orientation, degrees, in a random direction for
        each grasp.
    split
        Objects of the folder: all, or one half by their names. Settings are chosen on the
        development half.
    density
        Density of all objects of the folder, kg/m³; default: the masses of their files.
    """
    if protocol == "clutter-removal":
        return _run_protocol(
            ProtocolSettings(
                families=tuple(family or ("packed", "pile")),
                noises=tuple(noise or ("none", "dex")),
                rounds=min(rounds, QUICK_ROUNDS) if quick else rounds,
                seed=seed,
                objects=checked_objects(objects),
                hand=(robot or RobotChoice()).hand or "panda",
                known_table=known_table,
                learned_table=learned_table,
                safe_only=safe_only,
                misplaced=misplaced,
                split=split,
                count=count,
                density=density,
                jobs=jobs,
            ),
            json=json,
        )
    seeds, count = checked_scenes(scenes, seed, count, quick=quick)
    if not (known or camera):
        raise InputError("--no-known and --no-camera exclude each other: remove one of them")
    machines = checked_machines(jobs, cluster)
    dials = checked_dials(perception, control)
    extras = trial_extras(purpose, objects, robot)
    chosen = [one for one in (family, friction, shake, load_step, sensor) if one is not None]
    if not chosen and dials == ("default", "default"):
        conditions = default_conditions(camera=camera, known=known)
    else:
        conditions = requested_conditions(
            family or FAMILIES,
            friction or [1.0],
            shake or [0.0],
            load_step or [1.0],
            sensor or [EXACT],
            dials,
            camera=camera,
            known=known,
        )
    conditions = with_objects(conditions, objects, split, density)
    check_objects_fit(objects, conditions, seeds, count)
    plan = RunPlan.of(conditions, seeds, count, extras, out, OUT)
    done = run_plan(plan, machines, run_grasp_trial, fresh=fresh)
    title = f"{counted(len(seeds), 'scene')} of each row, {seed_span(seed, len(seeds))}"
    show(grasp_table(done.summaries, title), json_wanted=json)
    say(machines.timing_note)
    _write_report(plan, done, machines, title)
    if json:
        print_run_json("evaluate_grasp", plan, done, machines)
    return exit_code(done.records, plan.scene_jobs)


def _run_protocol(settings: ProtocolSettings, *, json: bool) -> int:
    # The protocol loads the planner's kernels, which other evaluations do not need.
    from .protocol import evaluate_protocol

    return evaluate_protocol(settings, json=json)


def _write_report(plan: RunPlan, done: FinishedRun, machines: Machines, title: str) -> None:
    """Write chart and report of a run into its folder."""
    source = "simulated arm and hand, one noisy depth view"
    provenance = Provenance(source, plan.seeds[0], len(plan.seeds), "scene")
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
