"""`eyehand evaluate`: unknown objects grasped in simulated scenes, with what perception loses."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.errors import InputError

from .chart_style import Provenance, write_chart
from .grasp_cluster import run_on_cluster
from .grasp_jobs import Condition, Family, RunTrial, SceneJob, run_grasp_trial, scene_jobs
from .grasp_picture import rates_picture
from .grasp_plan import (
    FAMILIES,
    asked_conditions,
    folder_digest,
    source_digest,
    usual_conditions,
)
from .grasp_report import write_report
from .grasp_rows import RowStore, open_rows
from .grasp_runs import run_here
from .grasp_summary import summary_rows
from .grasp_table import grasp_table
from .machine import core_count, machine_line

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

MOST_OBJECTS = 15
"""More do not fit on the table."""
QUICK_SCENES, QUICK_OBJECTS = 2, 2
REPORT_FILE, CHART_FILE = "report.html", "evaluate.png"

Several = Parameter(consume_multiple=True, negative="")


@dataclass(frozen=True)
class Machines:
    """Where scenes are run."""

    jobs: int
    """Processes here."""
    cluster: str = ""
    """Address of a scheduler that takes them instead."""


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
    task: Literal["lift", "move", "hand-over", "use"] = "lift",
    perception: str = "default",
    control: str = "default",
    objects: Path | None = None,
    robot: Path | None = None,
    hand_frame: str = "",
    jobs: int | None = None,
    cluster: str = "",
    quick: bool = False,
    fresh: bool = False,
    out: Path = Path("out/evaluate"),
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
    task
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
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if scenes < 1:
        raise InputError(f"--scenes must be >= 1, got {scenes}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    if not 1 <= count <= MOST_OBJECTS:
        raise InputError(f"--count must be from 1 to {MOST_OBJECTS}, got {count}")
    if not (known or camera):
        raise InputError("--no-known with --no-camera leaves nothing to run")
    if quick:
        scenes, count = min(scenes, QUICK_SCENES), min(count, QUICK_OBJECTS)
    machines = chosen_machines(jobs, cluster)
    dials = checked_dials(perception, control)
    more = trial_extras(task, objects, robot, hand_frame)
    if family is friction is shake is None and dials == ("default", "default"):
        conditions = usual_conditions(camera=camera, known=known)
    else:
        conditions = asked_conditions(
            family or FAMILIES, friction or [1.0], shake or [0.0], dials, camera=camera, known=known
        )
    planned = scene_jobs(conditions, range(seed, seed + scenes), count, more)
    store = open_rows(out, run_options(conditions, seed, count, more), fresh=fresh)
    run_scenes(planned, store, machines, run_grasp_trial)
    records = store.read(planned)
    rows = summary_rows(records)
    title = f"{scenes} scenes of each row, seeds {seed} to {seed + scenes - 1}"
    show(grasp_table(rows, title), json_wanted=json)
    made = Provenance("simulated arm and hand, one noisy depth view", seed, scenes, "scene")
    told = [
        title,
        f"eyehand {metadata.version('eyehand')}, {machine_line()}",
        f"code {source_digest()}; rows: {store.folder}",
    ]
    _publish(rows, records, rates_picture(rows, made), out, told)
    say(f"report: {out / REPORT_FILE}; rows: {store.folder}")
    if json:
        print_json(
            "evaluate",
            seed,
            rows,
            scenes=scenes,
            options=run_options(conditions, seed, count, more),
            machine=machine_line(),
            out=str(out),
        )
    return 0


def run_scenes(
    planned: Sequence[SceneJob], store: RowStore, machines: Machines, run: RunTrial
) -> None:
    """Run the scenes that are not done yet, and keep each as it ends.

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
                store.add(job, outcome)
                ended += 1
                if outcome.fault:
                    say(f"{job.row}, seed {job.trial['seed']} broke: {outcome.fault}")
    except KeyboardInterrupt:
        kept = len(planned) - len(left) + ended
        say(f"{kept} of {len(planned)} scenes are kept; the same command goes on with the others")
        raise


def chosen_machines(jobs: int | None, cluster: str) -> Machines:
    """Check where scenes shall run."""
    if jobs is not None and jobs < 1:
        raise InputError(f"--jobs must be >= 1, got {jobs}")
    if jobs is not None and cluster:
        raise InputError("--jobs is for processes here: leave it out with --cluster")
    return Machines(jobs or core_count(), cluster)


def checked_dials(perception: str, control: str) -> tuple[str, str]:
    """Check the names of dials."""
    from eyehand.apps.grasp.dials import CONTROL, PERCEPTION, check_dials

    check_dials("perception", PERCEPTION, [perception])
    check_dials("control", CONTROL, [control])
    return perception, control


def trial_extras(
    task: str, objects: Path | None, robot: Path | None, hand_frame: str
) -> dict[str, Any]:
    """Check what comes from files, and name it as trials do: on any machine, with its whole path.

    Raises
    ------
    InputError
        If a file is missing, a mesh does not do, or one of --robot and --hand-frame is missing.
    """
    if objects is not None:
        from eyehand.data_synth.object_folder import read_objects

        read_objects(objects)
    if robot is not None and not robot.is_file():
        raise InputError(f"--robot {robot}: there is no such file, expected an MJCF")
    if (robot is None) != (not hand_frame):
        raise InputError("--robot and --hand-frame go together: a robot, and the site in its palm")
    return {
        "task": task,
        "objects_dir": str(objects.resolve()) if objects else "",
        "robot": str(robot.resolve()) if robot else "",
        "hand_frame": hand_frame,
    }


def run_options(
    conditions: Sequence[Condition], seed: int, count: int, more: dict[str, Any]
) -> dict[str, Any]:
    """All that a folder's rows depend on, but for the number of scenes: more of them may follow."""
    files = {
        f"{name}_digest": folder_digest(Path(more[name]))
        for name in ("objects_dir", "robot")
        if more[name]
    }
    return {
        "rows": [condition.name for condition in conditions],
        "seed": seed,
        "count": count,
        **more,
        **files,
        "code": source_digest(),
    }


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
