"""`eyehand hand describe`: describe the gripper of an MJCF or URDF file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from eyehand.errors import InputError
from eyehand.grasping.hands import FileChoices, describe_hand, hand_json

from .console import print_text, say
from .frame_masks import Numbers
from .output_files import make_folder, write_picture, write_text

SUFFIXES = {"--output": ".json", "--picture": ".png"}
PAIR = 2


def hand_describe(
    file: Path,
    /,
    *,
    output: Path | None = None,
    picture: Path | None = None,
    name: str | None = None,
    palm: str | None = None,
    tcp: str | None = None,
    pinch: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    joint_range: Annotated[Numbers, Parameter(name="--range")] = None,
    force: Numbers = None,
    package_dir: Annotated[list[Path] | None, Parameter(negative="")] = None,
) -> int:
    """Describe the gripper of an MJCF or URDF file, alone or on an arm, for `eyehand grasp --hand`.

    Jaws, stroke, pads, boxes of fingers and palm, tool centre point, force and joints are found in
    the file. What the file leaves open is asked for by the name of an option.

    Parameters
    ----------
    file
        MJCF (.xml) or URDF file. Mesh paths are relative to it.
    output
        Write the description to this .json file. Without it the description goes to stdout.
    picture
        Draw the open and the closed gripper with its boxes and tool frame into this .png file.
    name
        Name of the hand; default: that of the file.
    palm
        Body on which the jaws move, where the file has several grippers.
    tcp
        Site or body at the fingertips, or an axis of the palm's body (+x, -x, +y, …), where the
        direction of the fingers is in doubt.
    pinch
        Two bodies of fingers that are used as jaws. Default for a hand of several fingers: the
        thumb and the finger with the largest stroke.
    joint_range
        Lower and upper limit of joints that have none, m or rad.
    force
        Minimum and maximum closing force of each jaw, N, in place of the motor's.
    package_dir
        Folder that holds ROS packages, for package:// paths; may be repeated. The folders of
        ROS_PACKAGE_PATH and those above the file are searched too.
    """
    for option, path in (("--output", output), ("--picture", picture)):
        if path is None:
            continue
        if path.suffix.lower() != SUFFIXES[option]:
            raise InputError(f"{option} must name a {SUFFIXES[option]} file, got {path}")
        if path.exists() and not path.is_file():
            raise InputError(f"{option} must name a file, but {path} is a folder, FIFO or device")
    choices = FileChoices(
        palm=palm,
        tcp=tcp,
        pinch=_two("--pinch", pinch),
        joint_range=_pair("--range", joint_range),
        force=_pair("--force", force),
        package_dirs=tuple(package_dir or ()),
        name=name,
    )
    found = describe_hand(file, choices)
    hand = found.hand
    for path in (output, picture):
        if path is not None:
            make_folder(path.parent)
    if output is None:
        print_text(hand_json(hand))
    else:
        write_text(output, hand_json(hand) + "\n")
    if picture is not None:
        from .grasp.hand_picture import hand_picture

        write_picture(picture, hand_picture(found))
        say(f"picture written to {picture}")
    say(
        f"{hand.name}: opens {1e3 * hand.min_opening:.1f} to {1e3 * hand.stroke:.1f} mm, pads "
        f"{1e3 * hand.pad_width:.1f} x {1e3 * hand.pad_height:.1f} mm, finger depth "
        f"{1e3 * hand.finger_depth:.1f} mm, {hand.force[0]:g} to {hand.force[1]:g} N, tool frame "
        f"{1e3 * hand.mount_distance:.1f} mm from the mount"
    )
    for remark in found.remarks:
        say(f"remark: {remark}")
    if output is not None:
        say(f"written to {output}; use it: eyehand grasp FRAME --hand {output}")
    return 0


def _pair(option: str, numbers: list[float] | None) -> tuple[float, float] | None:
    if numbers is None:
        return None
    if len(numbers) != PAIR:
        raise InputError(f"{option} needs 2 numbers, got {len(numbers)}")
    return numbers[0], numbers[1]


def _two(option: str, names: list[str] | None) -> tuple[str, str] | None:
    if names is None:
        return None
    if len(names) != PAIR:
        raise InputError(f"{option} needs 2 names of bodies, got {', '.join(names) or 'none'}")
    return names[0], names[1]
