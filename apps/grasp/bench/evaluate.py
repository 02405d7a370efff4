"""`eyehand evaluate`: unknown objects grasped in simulated scenes, with what perception loses."""

from __future__ import annotations

from contextlib import closing
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
from .conditions import FAMILIES, asked_conditions, source_digest, usual_conditions
from .jobs import Family, RunTrial, SceneJob, run_grasp_trial, scene_jobs
from .local_runs import run_here
from .rates_chart import rates_picture
from .report import write_report
from .row_store import FAULT, SCENE, RowStore, open_rows
from .run_inputs import (
    check_room,
    check_scenes,
    checked_dials,
    chosen_machines,
    own_folder,
    run_options,
    trial_extras,
)
from .summary import summary_rows
from .summary_table import grasp_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from .run_inputs import Machines
    from .summary import Record

OUT = Path("out/evaluate_grasp")
"""Each run that is given no folder has its own in this one."""
QUICK_SCENES, QUICK_OBJECTS = 2, 2
REPORT_FILE, CHART_FILE = "report.html", "evaluate.png"

Several = Parameter(consume_multiple=True, negative="")


def evaluate_grasp(
    *,
    scenes: int = 20,
    seed: int = 0,
    family: Annotated[list[Family] | None, Several] = None,
    friction: Annotated[list[float] | None, Several] = None,
    shake: Annotated[list[float] | None, Several] = None,
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
) -> int:
    """Clear simulated tables of unknown objects, and tell how often that goes well.

    Without --family, --friction and --shake: single objects, packed and piled ones, each beside the
    same with known poses, and packed ones with friction 0.6 and a 2 s shake. A scene ends when it
    is clear or after two failures in a row. Rows are kept as scenes end: the same command goes on
    with a run that was stopped. Writes rows/*.parquet, evaluate.png, evaluate.csv, report.html.

    Parameters
    ----------
    scenes
        Scenes of each row.
    seed
        Seed of the first; scene k follows from seed + k alone.
    family
        How objects stand: single, packed, pile; several go.
    friction
        Coulomb coefficients of the hand's pads, each with each family.
    shake
        Times that the hand shakes after each lift, s, each with each of those.
    known
        Run each row with known poses too.
    camera
        Run each row with the camera.
    count
        Objects of a packed or piled scene, 1 to 15.
    purpose
        What objects are lifted for.
    perception
        Dial of perception: default, fast, fine.
    control
        Dial of control: default, slow, fast, planner.
    objects
        Folder of meshes (.obj, .stl) or URDFs to take objects from, instead of solids.
    robot
        MJCF of another arm with a hand; robot.hand.json beside robot.xml tells the fingers of a
        hand whose motors move joints.
    hand_frame
        Its site in the palm.
    jobs
        Processes side by side; default: as many as there are cores.
    cluster
        Address of a Dask scheduler whose workers take the scenes, tcp://host:8786.
    quick
        Two scenes of two objects: a first look.
    fresh
        Throw away the rows of earlier runs in the output folder.
    out
        Output folder; default: one in out/evaluate for each set of options.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    check_scenes(scenes, seed, count)
    if not (known or camera):
        raise InputError("--no-known with --no-camera leaves nothing to run")
    if quick:
        scenes, count = min(scenes, QUICK_SCENES), min(count, QUICK_OBJECTS)
    machines = chosen_machines(jobs, cluster)
    dials = checked_dials(perception, control)
    more = trial_extras(purpose, objects, robot, hand_frame)
    if family is friction is shake is None and dials == ("default", "default"):
        conditions = usual_conditions(camera=camera, known=known)
    else:
        conditions = asked_conditions(
            family or FAMILIES, friction or [1.0], shake or [0.0], dials, camera=camera, known=known
        )
    check_room(objects, conditions, range(seed, seed + scenes), count)
    planned = scene_jobs(conditions, range(seed, seed + scenes), count, more)
    options = run_options(conditions, seed, count, more)
    out = out or own_folder(OUT, conditions, options)
    store = open_rows(out, options, fresh=fresh)
    run_scenes(planned, store, machines, run_grasp_trial)
    records = finished_rows(store, planned)
    rows = summary_rows(records, planned)
    title = f"{counted(scenes, 'scene')} of each row, {seed_span(seed, scenes)}"
    show(grasp_table(rows, title), json_wanted=json)
    say(machines.told)
    made = Provenance("simulated arm and hand, one noisy depth view", seed, scenes, "scene")
    told = [
        title,
        f"eyehand {metadata.version('eyehand')}, {machine_line()}",
        machines.told,
        f"code {source_digest()}; rows: {store.folder}",
    ]
    _publish(rows, records, rates_picture(rows, made), out, told)
    say(f"report: {out / REPORT_FILE}; rows: {store.folder}")
    if json:
        print_json(
            "evaluate_grasp",
            seed,
            rows,
            scenes=scenes,
            options=options,
            machine=machine_line(),
            timing=machines.told,
            out=str(out),
        )
    return exit_code(records, planned)


def run_scenes(
    planned: Sequence[SceneJob], store: RowStore, machines: Machines, run: RunTrial
) -> None:
    """Run the scenes that are not done yet, and keep each as it ends.

    One that the machine gave no outcome for (its process was killed, it took far too long) is told
    and not kept: the next run tries it again.

    Raises
    ------
    InputError
        If there is no cluster at the address.
    DeviceError
        If the cluster goes away, or the disk fails.
    """
    done = store.finished()
    left = [job for job in planned if job.key not in done]
    if not left:
        return
    if machines.cluster:
        results = run_on_cluster(left, run, machines.cluster)
    else:
        results = run_here(left, run, processes=machines.jobs)
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
                    say(f"{name} broke: {outcome.fault}")
    except KeyboardInterrupt:
        kept = len(planned) - len(left) + ended
        say(f"{kept} of {len(planned)} scenes are kept; the same command goes on with the others")
        raise


def finished_rows(store: RowStore, planned: Sequence[SceneJob]) -> list[Record]:
    """Rows of the scenes that are done, and a word on those that are not.

    Raises
    ------
    DeviceError
        If none is done.
    """
    missing = len({job.key for job in planned} - store.finished())
    if missing == len(planned):
        raise DeviceError(f"none of {missing} scenes has an outcome; the same command tries again")
    if missing:
        say(f"{missing} of {len(planned)} scenes are missing; the same command tries them again")
    return store.read(planned)


def exit_code(records: Sequence[Record], planned: Sequence[SceneJob]) -> int:
    """0 when the figures tell of grasping: all scenes ran, and not every one of them broke."""
    scenes = [record for record in records if record["record"] == SCENE]
    broke = [scene for scene in scenes if scene["outcome"] == FAULT]
    if len(broke) == len(scenes):
        say(f"every scene broke, the first by {broke[0]['reason']}")
        return 1
    return int(len(scenes) < len(planned))


def _publish(
    rows: Sequence[dict[str, Any]],
    records: Sequence[dict[str, Any]],
    picture: Figure,
    out: Path,
    told: Sequence[str],
) -> None:
    flat = [{key: value for key, value in row.items() if key != "outcomes"} for row in rows]
    write_chart(picture, out / CHART_FILE, flat)
    write_report(out / REPORT_FILE, rows, records, (out / CHART_FILE).read_bytes(), told)
