"""`eyehand grasp`: rank the grasps of a parallel gripper in a depth frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from eyehand.errors import InputError
from eyehand.grasping import JawOptions, ParallelHand, generic_jaw, load_hand, plan_grasps
from eyehand.grasping.hands import built_in_hands

from .console import json_text, print_json, say, show
from .frame_stream import FrameStream
from .grasp.jaw_frame import GraspedFrame, grasp_frame
from .grasp.jaw_table import doubt_note, frame_json, grasp_rows, grasp_table, object_notes
from .output_files import make_folder, write_picture, write_text
from .perceived_frame import check_usable, load_kernels, support_line

MAX_CALIBRATION_ERROR = 50.0
"""Maximum of --calibration-error, mm."""
MAX_DEPTH_ERROR = 20.0
"""Maximum of --depth-error, %."""
MIN_ERROR = 0.05
"""Least value of both above 0. Smaller ones are in m, or shares."""
SUFFIXES = {"--yaml": (".yaml", ".yml"), "--picture": (".png",), "--page": (".html", ".htm")}

MIN_SIZE_MM, MAX_SIZE_MM = 1.0, 1000.0
GENERIC = "generic"
WIDE_HAND = "2f140"
"""A hand that grasps the balls of `load_kernels`. Planning for it loads all kernels of planning."""


def grasp_command(
    frame: Path | None = None,
    /,
    *,
    jaw: Annotated[JawChoice | None, Parameter(name="*", group="Gripper")] = None,
    calibration_error: float = 3.0,
    friction: float = 0.6,
    depth_error: float = 3.0,
    guarded: bool = False,
    inclined: bool = False,
    top: int = 10,
    table_height: float | None = None,
    stream: FrameStream | None = None,
    out: Path | None = None,
    yaml: Path | None = None,
    picture: Path | None = None,
    page: Path | None = None,
    json: bool = False,
) -> int:
    """Perceive a depth frame and rank the grasps of a parallel gripper by their success.

    The exit code is 0 if a safe grasp is offered, else 1.

    Parameters
    ----------
    frame
        Depth frame (.png in mm with a camera file, .npz, organised .pcd or .ply), or a recording
        (.mcap) of an OAK camera or of ROS 2.
    jaw
        The gripper.
    calibration_error
        Standard deviation of the gripper's position relative to the image, mm.
    friction
        Coulomb friction coefficient of pads and objects.
    depth_error
        Standard deviation of the scale of the depth, % of the distance: 0.5 for a camera that was
        calibrated. With --table-height it is at most 0.5.
    guarded
        The arm stops at the first contact of the hand, and closes there.
    inclined
        The table is inclined. Otherwise no grasp is safe on a table that tilts by more than 3°.
    top
        Number of grasps that are reported.
    table_height
        Height of the table in the world, m. Scale and tilt of the depth are corrected from it.
    stream
        The frame's camera and masks, or a live camera.
    out
        Output folder for grasps.json, grasps.yaml and grasps.png; frames of a stream go to numbered
        folders inside.
    yaml
        Write the safe grasps to this .yaml file, in the field layout of ROS moveit_msgs/Grasp.
    picture
        Draw the best grasps into this .png file: in the image and in 3D.
    page
        Write a self-contained .html page with a 3D view.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    stream = stream or FrameStream()
    stream.check(frame)
    hand = (jaw or JawChoice()).load()
    options = replace(
        _options(calibration_error, friction, depth_error), guarded=guarded, inclined=inclined
    )
    if top < 1:
        raise InputError(f"--top must be >= 1, got {top}")
    if table_height is not None and not math.isfinite(table_height):
        raise InputError(f"--table-height must be finite, got {table_height}")
    outputs = {"--yaml": yaml, "--picture": picture, "--page": page}
    _check_outputs(outputs, several=stream.has_several(frame))
    rows, reports, offered = [], [], True

    def prepare() -> None:
        plan_grasps(load_kernels(), load_hand(WIDE_HAND), options)

    for name, source, depth_frame in stream.open(frame, prepare):
        found = grasp_frame(
            depth_frame, hand, options, source=source, top=top, table_height=table_height
        )
        if name is None:
            check_usable(found.scene.warnings, source)
        frame_rows, report = grasp_rows(found, name), frame_json(found, name)
        if out is not None:
            _write_folder(out if name is None else out / name, found, frame_rows, report)
        _write(found, yaml, picture, page)
        _report(found, json_wanted=json)
        rows += frame_rows
        reports.append(report)
        offered &= any(grasp.safe for grasp in found.grasps)
    if json:
        print_json("grasp", None, rows, hand=hand.name, frames=reports)
    return 0 if offered else 1


def _options(calibration_error: float, friction: float, depth_error: float) -> JawOptions:
    for name, value, unit, most in (
        ("--calibration-error", calibration_error, "mm", MAX_CALIBRATION_ERROR),
        ("--depth-error", depth_error, "%", MAX_DEPTH_ERROR),
    ):
        if value != 0.0 and not MIN_ERROR <= value <= most:
            raise InputError(f"{name} must be 0, or {MIN_ERROR} to {most:g} {unit}, got {value:g}")
    return JawOptions(
        friction=friction,
        calibration_error=1e-3 * calibration_error,
        depth_error=1e-2 * depth_error,
    )


def _check_outputs(outputs: dict[str, Path | None], *, several: bool) -> None:
    """Check the names of the files and create their folders."""
    for option, path in outputs.items():
        if path is None:
            continue
        if several:
            raise InputError(f"{option} needs one frame: add --frames 1")
        if path.suffix.lower() not in SUFFIXES[option]:
            raise InputError(f"{option} must name a {SUFFIXES[option][0]} file, got {path}")
        if path.exists() and not path.is_file():
            raise InputError(f"{option} must name a file, but {path} is a folder, FIFO or device")
        make_folder(path.parent)


def _write_folder(
    folder: Path, found: GraspedFrame, rows: list[dict[str, Any]], report: dict[str, Any]
) -> None:
    make_folder(folder)
    text = json_text("grasp", None, rows, hand=found.hand.name, frames=[report])
    write_text(folder / "grasps.json", text + "\n")
    _write(found, folder / "grasps.yaml", folder / "grasps.png", None)


def _write(found: GraspedFrame, yaml: Path | None, picture: Path | None, page: Path | None) -> None:
    if yaml is not None:
        from .grasp.moveit_yaml import grasps_yaml

        write_text(yaml, grasps_yaml(found))
        say(f"grasps written to {yaml}")
    if picture is not None:
        from .grasp.jaw_picture import grasps_picture

        write_picture(picture, grasps_picture(found))
        say(f"picture written to {picture}")
    if page is not None:
        from .grasp.jaw_page import page_html

        write_text(page, page_html(found))
        say(f"page written to {page}")


def _report(found: GraspedFrame, *, json_wanted: bool) -> None:
    """Print the table and the remarks, or why there is no grasp."""
    if found.hand.pre_shape:
        say(f"{found.hand.name}: {found.hand.pre_shape}; its description lists the joint positions")
    if any(found.hand.middle_shift):
        say(f"{found.hand.name}: one jaw moves, so the arm must go to hand.closed_pose of a grasp")
    if found.grasps:
        show(grasp_table(found), json_wanted=json_wanted)
        for note in (doubt_note(found), *object_notes(found)):
            if note:
                say(note)
        if not any(grasp.safe for grasp in found.grasps):
            say("no grasp is safe: the last column of the table says why")
    else:
        say(f"eyehand: {found.source}: no grasp is offered: {found.grasps.reason}")
    correction = found.correction
    if correction is not None:
        say(
            f"depth scaled by {correction.scale:.4f}: the table was "
            f"{1e3 * correction.height_error:+.1f} mm off, tilted by "
            f"{math.degrees(correction.tilt):.1f}°"
        )
        if correction.warning:
            say(f"warning: {correction.warning}")
    if line := support_line(found.scene):
        say(line)
    for warning in found.scene.warnings:
        say(f"warning: {warning.message}")


@dataclass(frozen=True)
class JawChoice:
    """Options that choose the gripper."""

    hand: str | None = None
    """Gripper: panda, 2f85, 2f140, hande, wsg50, allegro, shadow, or the JSON file of its
    description, which eyehand hand describe writes."""
    stroke: float | None = None
    """Generic gripper: maximum distance between the pads, mm."""
    finger_depth: float | None = None
    """Generic gripper: distance of the fingertips from the palm, mm."""
    finger_width: float | None = None
    """Generic gripper: width of a finger across the closing direction, mm."""
    joint_prefix: str = ""
    """Text before the names of the gripper's joints in the postures, as in a ROS description:
    panda_ makes panda_finger_joint1."""

    def load(self) -> ParallelHand:
        """Return the description of the gripper.

        Raises
        ------
        InputError
            If no gripper is chosen, or it is unknown, or a size is out of range.
        """
        hand = self._chosen()
        joints = tuple(replace(joint, name=self.joint_prefix + joint.name) for joint in hand.joints)
        return replace(hand, joints=joints) if self.joint_prefix else hand

    def _chosen(self) -> ParallelHand:
        sizes = {
            name: value
            for name in ("stroke", "finger_depth", "finger_width")
            if (value := getattr(self, name)) is not None
        }
        options = ", ".join(f"--{name.replace('_', '-')}" for name in sizes)
        if self.hand is None and not sizes:
            raise InputError(
                f"give the gripper: --hand NAME ({', '.join(built_in_hands())}), --hand FILE.json, "
                "or --stroke MM for a generic one"
            )
        if not sizes:
            assert self.hand is not None
            return load_hand(self.hand)
        if self.hand not in (None, GENERIC):
            raise InputError(
                f"give either --hand {self.hand} or {options}: sizes are for a generic gripper"
            )
        for name, value in sizes.items():
            option = f"--{name.replace('_', '-')}"
            if not (math.isfinite(value) and 0.0 < value < MAX_SIZE_MM):
                raise InputError(f"{option} must be above 0 and below 1000 mm, got {value:g}")
            if value < MIN_SIZE_MM:
                raise InputError(
                    f"{option} is in mm, got {value:g} mm. Is this in metres? Then write "
                    f"{1e3 * value:g}"
                )
        return generic_jaw(**{name: 1e-3 * value for name, value in sizes.items()})
