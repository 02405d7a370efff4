"""`eyehand demo`: a simulated robot clears a table of unknown objects, with report and film."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from eyehand.data_synth.render import gl_fault
from eyehand.errors import InputError
from eyehand.grasping import GraspPurpose
from eyehand.perception import read_frame

from .console import print_json, say, show
from .grasp.robot_choice import RobotChoice
from .perceived_frame import perceive_and_plan
from .ros_markers import check_mcap_name, scene_writer
from .run_folder import claim_folder

if TYPE_CHECKING:
    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import Cell, ClearOptions

    from .grasp.bench.trial import GraspTrial
    from .grasp.demo_record import DemoRecord
    from .grasp.film import Film

DEFAULT_PORT = 8080
"""Port of the live page unless it is taken."""
FILM_FILE, PICTURE_FILE = "demo.mp4", "demo.webp"
"""File names of the film and of the moving picture."""


def demo(
    *,
    seed: int = 0,
    objects: int | Path | None = None,
    scene: Annotated[str, Parameter(name=("--scene", "--family"))] = "packed",
    purpose: GraspPurpose = "lift",
    failures: int | None = None,
    robot: Annotated[RobotChoice | None, Parameter(name="*", group="Robot")] = None,
    sensor: Literal["exact", "ideal", "good", "real", "harsh"] = "exact",
    video: bool = True,
    beside: Path | None = None,
    mcap: Path | None = None,
    view: bool = False,
    port: int = DEFAULT_PORT,
    out: Path = Path("out/demo"),
    json: bool = False,
) -> int:
    """Clear a table of unknown objects with a simulated robot that sees one noisy depth view.

    The command prints a line after every pick, and a table at the end. It writes report.html, a
    page without external files, and demo.mp4, a short film. `eyehand perceive` shows perception
    alone, on your own frame.

    Parameters
    ----------
    seed
        Seed of the scene and of the camera's noise.
    objects
        Number of objects, 1 to 15 (default 5), or a folder of your own meshes (.obj, .stl) or
        URDFs. At most 5 objects are drawn from a folder, by the seed.
    scene
        Arrangement of the objects (packed, pile or single), or a ground_truth.json written by
        `eyehand synth` (or its folder).
    purpose
        What the objects are grasped for.
    failures
        Number of failed picks in a row that ends the demo (default 6; `evaluate grasp` uses 2).
    robot
        The simulated robot.
    sensor
        Sensor model of the hand's pads. `real` has noise, hysteresis, creep, shear and 8 ms wait.
    video
        Record the film.
    beside
        A depth frame. Also write demo.webp, a moving picture for web pages: the segments and solids
        of this frame beside the film.
    mcap
        Also record robot, scenes and grasps to this .mcap file with messages of ROS 2. Foxglove
        shows it.
    view
        Show the demo live in the browser, with pause, single steps and speed. Ctrl-C ends it. No
        film is recorded.
    port
        With --view: port of the page. If it is taken, the next free port is used.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    if failures is not None and failures < 1:
        raise InputError(f"--failures must be >= 1, got {failures}")
    if beside is not None and (view or not video):
        raise InputError("--beside needs the film: no --view or --no-video")
    if mcap is not None and view:
        raise InputError("--mcap records a finished demo: no --view")
    check_mcap_name(mcap)
    from eyehand.grasping import ClearOptions, ParallelHand

    from .grasp.bench.trial import GraspTrial, trial_cell
    from .grasp.demo_run import FAILURES
    from .grasp.demo_scene import demo_scene
    from .grasp.warm_up import warm_up_grasping

    table = demo_scene(scene, seed, objects)
    trial = GraspTrial(
        family=table.family,
        seed=seed,
        objects=len(table.objects),
        purpose=purpose,
        objects_dir=table.folder,
        sensor="" if sensor == "exact" else sensor,
        **(robot or RobotChoice()).trial_fields(),
    )
    ending = ClearOptions(failures=failures or FAILURES)
    # Building the cell and reading the frame validate input. The first file is written later.
    built = trial_cell(table.objects, trial)
    pictured = None if beside is None else perceive_and_plan(read_frame(beside))
    claim_folder(out)
    say("loading kernels ...")
    warm_up_grasping(jaws=isinstance(built[0].robot.hand, ParallelHand))
    say(f"clearing a table: {table.source} ...")
    if view:
        return _live(table.source, trial, built, ending, port, out, json)
    record = _recorded(
        table.source, trial, built, ending, film=out / FILM_FILE if video else None, mcap=mcap
    )
    if record.film is not None and pictured is not None:
        from .moving_picture import write_moving_picture

        write_moving_picture(out / PICTURE_FILE, record.film, pictured)
        say(f"moving picture: {out / PICTURE_FILE}")
    else:
        _remove_old(out / PICTURE_FILE)
    write_results(record, out, json)
    return 0


def _recorded(
    source: str,
    trial: GraspTrial,
    built: tuple[Cell, SimRobot],
    ending: ClearOptions,
    *,
    film: Path | None,
    mcap: Path | None,
) -> DemoRecord:
    """Run the demo, and write its film and its recording where a path is given."""
    from .grasp.demo_run import MakeObserver, run_demo
    from .grasp.robot_recording import RobotRecording

    shown = None if film is None else _film(film)
    with shown or nullcontext(), scene_writer(mcap) as writer:
        joined: list[MakeObserver] = [] if shown is None else [shown.join]
        if writer is not None:
            joined.append(RobotRecording(writer).join)
        record = run_demo(source, trial, built, joined, ending)
    if shown is None:
        return record
    return replace(record, film=shown.path, film_cpu_seconds=shown.cpu_seconds)


def write_results(record: DemoRecord, out: Path, json: bool) -> None:
    """Write the report and print the table.

    Parameters
    ----------
    record
        The finished demo.
    out
        Folder of the report. The film of an earlier run is removed from it unless this run has one.
    json
        Print one JSON object on stdout.

    Raises
    ------
    InputError
        If a file cannot be written or removed.
    """
    from .grasp.demo_report import write_report
    from .grasp.demo_table import demo_rows, demo_table

    page = out / "report.html"
    write_report(page, record)
    if record.film is None:
        _remove_old(out / FILM_FILE)
        _remove_old(out / PICTURE_FILE)
    show(demo_table(record), json_wanted=json)
    files = [str(page)] if record.film is None else [str(page), str(record.film)]
    say(f"open {' and '.join(files)}")
    if json:
        result, film_cpu = record.result, record.film_cpu_seconds
        print_json(
            "demo",
            result.trial.seed,
            demo_rows(record),
            source=record.source,
            objects=result.total,
            placed=result.placed,
            cleared_pct=round(100 * result.placed / max(result.total, 1), 1),
            looks=len(record.captures),
            left=list(record.report.remaining),
            stopped=record.report.stop_reason,
            cpu_s=round(result.cpu_seconds, 2),
            film_cpu_s=None if film_cpu is None else round(film_cpu, 2),
            report=str(page),
            video=None if record.film is None else str(record.film),
        )


def _film(path: Path) -> Film | None:
    """Open the film, or return None if OpenGL is not available."""
    from .grasp.film import Film

    fault = gl_fault()
    if fault:
        say(f"no film, because OpenGL is not available ({fault})")
        return None
    return Film(path)


def _remove_old(path: Path) -> None:
    """Remove a file of an earlier run."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"cannot remove {path} of an earlier run: {error.strerror}") from error


def _live(
    source: str,
    trial: GraspTrial,
    built: tuple[Cell, SimRobot],
    ending: ClearOptions,
    port: int,
    out: Path,
    json: bool,
) -> int:
    """Run the demo with a live page until Ctrl-C."""
    from .grasp.demo_run import run_demo
    from .grasp.live_page import LivePage

    with LivePage(port) as live:
        say(f"live page at {live.address}; Ctrl-C ends it")
        try:
            write_results(run_demo(source, trial, built, [live.join], ending), out, json)
            live.finish()
            live.wait()
        except KeyboardInterrupt:
            say("ended")
    return 0
