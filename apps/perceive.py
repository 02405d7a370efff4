"""`eyehand perceive`: describe a depth frame, a recording or a live camera."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from eyehand.errors import InputError
from eyehand.grasping import GraspOptions, GraspPurpose
from eyehand.perception.io import FRAME_SUFFIXES, read_frame

from .console import print_json, say, show
from .frame_masks import FrameMasks
from .output_files import write_perceived_frame
from .perceived_frame import load_kernels, perceive_and_plan
from .scene_table import scene_rows, scene_table
from .usable_frame import check_usable

if TYPE_CHECKING:
    from collections.abc import Iterator

    from eyehand.perception import DepthFrame

RECORDING_SUFFIX = ".mcap"


def perceive_command(
    frame: Path | None = None,
    /,
    *,
    camera: Path | None = None,
    masks: Annotated[FrameMasks | None, Parameter(name="*", group="Masks")] = None,
    oak: bool = False,
    record: Path | None = None,
    frames: Annotated[int | None, Parameter(name="--frames")] = None,
    purpose: GraspPurpose = "lift",
    out: Path = Path("out/perceive"),
    json: bool = False,
) -> int:
    """Segment a depth frame, fit a solid to each object, and propose a grasp for each.

    The command writes scene.json, labels.png and overlay.png and prints a table.

    Parameters
    ----------
    frame
        Depth frame (.png in mm with a camera file, .npz, organised .pcd or .ply), or a recording
        (.mcap).
    camera
        Camera file with the intrinsics; default: <frame>.json or camera.json beside the frame.
    masks
        Readings of the robot, and outside a region, that are no objects.
    oak
        Read from a connected Luxonis OAK camera instead of a file.
    record
        With --oak: also record what the camera sees to this .mcap file.
    frames
        Frames to take from a camera or a recording; default 1 from a camera, all of a recording.
    purpose
        What the grasp is for.
    out
        Output folder; frames of a stream go to numbered folders inside.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if (frame is None) == (not oak):
        raise InputError("give either a frame file or --oak")
    if record is not None and not oak:
        raise InputError("--record needs --oak")
    if frames is not None and frames < 1:
        raise InputError(f"--frames must be >= 1, got {frames}")
    rows = []
    count = 0
    for name, source, depth_frame in _frames(frame, camera, oak, record, frames):
        if count == 0:
            load_kernels()
        count += 1
        if masks is not None:
            depth_frame = masks.applied(depth_frame)
        found = perceive_and_plan(depth_frame, GraspOptions(purpose=purpose))
        if name is None:
            check_usable(found.scene.segmentation, source)
        folder = out if name is None else out / name
        write_perceived_frame(folder, found, source)
        show(scene_table(found, source), json_wanted=json)
        for warning in found.scene.warnings:
            say(f"warning: {warning.message}")
        say(f"pictures and scene.json in {folder}")
        rows += scene_rows(found, name)
    if count == 0:
        raise InputError(f"{frame} holds no frame")
    if json:
        print_json("perceive", None, rows, frames=count, out=str(out))
    return 0


def _frames(
    path: Path | None, camera: Path | None, oak: bool, record: Path | None, count: int | None
) -> Iterator[tuple[str | None, str, DepthFrame]]:
    """Yield (folder name or None, source, frame)."""
    if oak:
        from eyehand.perception.cameras import OakCamera

        stream, source, count = OakCamera(record=record), "OAK camera", count or 1
    elif path is not None and path.suffix.lower() == RECORDING_SUFFIX:
        from eyehand.perception.cameras import OakRecording

        stream, source = OakRecording(path), str(path)
    else:
        assert path is not None
        if path.suffix.lower() not in FRAME_SUFFIXES:
            raise InputError(
                f"{path}: suffix {path.suffix!r} is not a frame format, expected one of "
                f"{', '.join((*FRAME_SUFFIXES, RECORDING_SUFFIX))}"
            )
        if count not in (None, 1):
            raise InputError(f"--frames needs --oak or a recording, and {path} is one frame")
        yield None, str(path), read_frame(path, camera)
        return
    # islice does not request a frame beyond the last one, so that a live camera does not wait.
    for number, frame in enumerate(islice(stream.frames(), count)):
        yield f"{number:04d}", f"{source}, frame {number}", frame
