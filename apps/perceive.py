"""`eyehand perceive`: describe a depth frame, a recording or a live camera."""

from __future__ import annotations

from pathlib import Path

from eyehand.errors import InputError
from eyehand.grasping import GraspOptions, GraspPurpose

from .console import print_json, say, show
from .frame_stream import FrameStream
from .output_files import write_perceived_frame
from .perceived_frame import (
    PerceivedFrame,
    check_usable,
    load_kernels,
    perceive_and_plan,
    plan_scene,
    support_line,
)
from .ros_markers import check_mcap_name, scene_writer, write_scene
from .run_folder import claim_folder
from .scene_table import scene_rows, scene_table

PERIOD_S = 0.1
"""Time between the frames in a file of --mcap, s. Frames of files carry no time."""


def perceive_command(
    frame: Path | None = None,
    /,
    *,
    stream: FrameStream | None = None,
    mcap: Path | None = None,
    purpose: GraspPurpose = "lift",
    out: Path = Path("out/perceive"),
    json: bool = False,
) -> int:
    """Segment a depth frame, fit a solid to each object, and propose a grasp for each.

    The command writes scene.json, labels.png and overlay.png and prints a table. The grasps are
    those of the demo's hand, three fingers and a thumb. `eyehand grasp` ranks grasps of your
    gripper.

    Parameters
    ----------
    frame
        Depth frame (.png in mm with a camera file, .npz, organised .pcd or .ply), or a recording
        (.mcap) of an OAK camera or of ROS 2.
    stream
        The frame's camera and masks, or a live camera.
    mcap
        Also write depth, solids and grasps to this .mcap file with messages of ROS 2. Foxglove and
        RViz show it.
    purpose
        What the grasp is for.
    out
        Output folder; frames of a stream go to numbered folders inside.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    stream = stream or FrameStream()
    stream.check(frame)
    if mcap is not None and mcap.resolve() in [
        one.resolve() for one in (frame, stream.record) if one
    ]:
        raise InputError(f"--mcap must name another file than the recording, got {mcap}")
    check_mcap_name(mcap)
    rows = []
    count = 0

    def prepare() -> None:
        # Only now: an input that cannot be read leaves no empty folder.
        claim_folder(out)
        plan_scene(load_kernels())

    with scene_writer(mcap) as recording:
        for name, source, depth_frame in stream.open(frame, prepare):
            found = perceive_and_plan(depth_frame, GraspOptions(purpose=purpose))
            if name is None:
                check_usable(found.scene.warnings, source)
            _write(out if name is None else out / name, found, source, json_wanted=json)
            if recording is not None:
                write_scene(recording, found.frame, found.scene, found.plans, count * PERIOD_S)
            rows += scene_rows(found, name)
            count += 1
    if json:
        print_json("perceive", None, rows, frames=count, out=str(out))
    return 0


def _write(folder: Path, found: PerceivedFrame, source: str, *, json_wanted: bool) -> None:
    """Write the files of a frame and print its table."""
    write_perceived_frame(folder, found, source)
    show(scene_table(found, source), json_wanted=json_wanted)
    if line := support_line(found.scene):
        say(line)
    for warning in found.scene.warnings:
        say(f"warning: {warning.message}")
    say(f"pictures and scene.json in {folder}")
