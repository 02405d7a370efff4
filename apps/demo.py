"""`eyehand demo`: a simulated robot clears a table of unknown objects; report and film stay."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from eyehand.data_synth.render import gl_fault
from eyehand.errors import InputError
from eyehand.grasping import GraspPurpose

from .console import print_json, say, show
from .description_files import make_folder
from .look_demo import look_demo

if TYPE_CHECKING:
    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping.cell import Cell
    from eyehand.grasping.clearing import ClearOptions

    from .grasp.bench.trial import GraspTrial
    from .grasp.demo_record import DemoRecord
    from .grasp.film import Film

DEFAULT_PORT = 8080
"""Where the live page is looked for first."""
FILM_FILE = "demo.mp4"
"""The film in the output folder."""


def demo(
    frame: Path | None = None,
    /,
    *,
    look: bool = False,
    camera: Path | None = None,
    seed: int = 0,
    objects: int | Path | None = None,
    scene: Annotated[str, Parameter(name=("--scene", "--family"))] = "packed",
    purpose: GraspPurpose = "lift",
    failures: int | None = None,
    robot: Path | None = None,
    hand_frame: str = "",
    video: bool = True,
    view: bool = False,
    port: int = DEFAULT_PORT,
    out: Path = Path("out/demo"),
    json: bool = False,
) -> int:
    """Clear a table of unknown objects with a simulated robot that sees one noisy depth view.

    Prints a row for every pick and writes report.html, one page that needs no network, and a
    short film, demo.mp4. With --look, or a frame of your own, only perception is shown, on a
    synthetic frame whose truth is known and on a real one.

    Parameters
    ----------
    frame
        A depth frame of your own to look at (implies --look).
    look
        Show only what is seen, on two single frames; nothing is grasped.
    camera
        Camera file of your frame.
    seed
        Seed of the scene and of the camera's noise.
    objects
        How many objects, 1 to 15 (default 5); or a folder of your own meshes (.obj, .stl) or URDFs
        to see picked, at most 5 of them drawn by the seed.
    scene
        How they stand: packed, pile or single; or a ground_truth.json (or its folder) as
        `eyehand synth` writes it.
    purpose
        What the grasps are for.
    failures
        Failed picks in a row after which it ends; default: 6, evaluate ends after 2.
    robot
        MJCF file of another arm with its hand; robot.hand.json beside robot.xml tells the fingers
        of a hand whose motors move joints.
    hand_frame
        With --robot: its site or body whose origin is in the palm, z out of it, x from the
        fingers to the thumb.
    video
        Make the film.
    view
        Show it live in the browser, with pause, steps and speed; ends by Ctrl-C. No film is made.
    port
        With --view: where the page is served; the next free port when it is taken.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    if failures is not None and failures < 1:
        raise InputError(f"--failures must be >= 1, got {failures}")
    if look or frame is not None:
        if isinstance(objects, Path):
            raise InputError(f"--objects must be a number with --look or a frame, got {objects}")
        from .grasp.demo_scene import USUAL_OBJECTS

        count = USUAL_OBJECTS if objects is None else objects
        return look_demo(
            frame, camera, seed=seed, objects=count, purpose=purpose, out=out, json=json
        )
    if camera is not None:
        raise InputError("--camera goes with a frame: eyehand demo FRAME --camera FILE")
    if (robot is None) != (not hand_frame):
        raise InputError("--robot FILE and --hand-frame NAME go together")
    from eyehand.grasping.clearing import ClearOptions

    from .grasp.bench.trial import GraspTrial, cell_of
    from .grasp.demo_run import FAILURES
    from .grasp.demo_scene import demo_scene
    from .grasp.ready import ready_grasping

    table = demo_scene(scene, seed, objects)
    trial = GraspTrial(
        family=table.family,
        seed=seed,
        objects=len(table.objects),
        purpose=purpose,
        objects_dir=table.folder,
        robot="" if robot is None else str(robot),
        hand_frame=hand_frame,
    )
    ending = ClearOptions(failures=failures or FAILURES)
    # Built before anything is written, as it finds what is wrong with scene and robot.
    built = cell_of(table.objects, trial)
    make_folder(out)
    ready_grasping()
    say(f"clearing a table: {table.source} ...")
    if view:
        return _live(table.source, trial, built, ending, port, out, json)
    from .grasp.demo_run import run_demo

    film = _film(out / FILM_FILE) if video else None
    with film or nullcontext():
        joined = [] if film is None else [film.join]
        record = run_demo(table.source, trial, built, joined, ending)
    if film is not None:
        record = replace(record, film=film.path, film_cpu_seconds=film.cpu_seconds)
    leave(record, out, json)
    return 0


def leave(record: DemoRecord, out: Path, json: bool) -> None:
    """Write the page, and print the table.

    Parameters
    ----------
    record
        The run.
    out
        Where the page goes; a film of an earlier run is removed there, as it would be taken for
        this one's.
    json
        Print one JSON object on stdout.

    Raises
    ------
    InputError
        If something cannot be written or removed there.
    """
    from .grasp.demo_report import write_report
    from .grasp.demo_table import demo_rows, demo_table

    page = out / "report.html"
    write_report(page, record)
    if record.film is None:
        _forget_film(out / FILM_FILE)
    show(demo_table(record), json_wanted=json)
    files = [str(page)] if record.film is None else [str(page), str(record.film)]
    say(f"look at {' and '.join(files)}")
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
            looks=len(record.looks),
            left=list(record.report.left),
            stopped=record.report.stopped,
            cpu_s=round(result.cpu_seconds, 2),
            film_cpu_s=None if film_cpu is None else round(film_cpu, 2),
            report=str(page),
            video=None if record.film is None else str(record.film),
        )


def _film(path: Path) -> Film | None:
    """Open the film where there is something to draw it with."""
    from .grasp.film import Film

    fault = gl_fault()
    if fault:
        say(f"no film: there is no OpenGL to draw it with ({fault})")
        return None
    return Film(path)


def _forget_film(path: Path) -> None:
    """Remove the film of an earlier run."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(
            f"{path}, of an earlier run, cannot be removed: {error.strerror}"
        ) from error


def _live(
    source: str,
    trial: GraspTrial,
    built: tuple[Cell, SimRobot],
    ending: ClearOptions,
    port: int,
    out: Path,
    json: bool,
) -> int:
    """Show it live until Ctrl-C, which is how it ends well."""
    from .grasp.demo_run import run_demo
    from .grasp.live_cell import LiveCell

    with LiveCell(port) as live:
        say(f"watch at {live.address}; Ctrl-C ends")
        try:
            leave(run_demo(source, trial, built, [live.join], ending), out, json)
            live.finish()
            live.wait()
        except KeyboardInterrupt:
            say("ended")
    return 0
