"""`eyehand hand describe`: describe the gripper of an MJCF or URDF file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.grasping.hands import DescribedHand, FileChoices, describe_hand, hand_json, write_hand

from .console import print_text, say
from .frame_masks import Numbers
from .grasp.jaw_shapes import CORNERS
from .grasp.painted_view import PaintedView
from .output_files import make_folder, write_picture

SUFFIXES = {"--output": ".json", "--picture": ".png"}
PAIR = 2

PANEL = (520, 640)
"""Height and width of each of four views, px."""
FRONT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Axes of the view along y: x to the right, the approach downwards."""
PAPER, INK = (246, 247, 249), (34, 38, 43)
BODY, FINGER, PALM, CAMERA = (178, 184, 194), (0, 130, 95), (86, 120, 190), (213, 94, 0)
"""Colours of the gripper, and of the edges of boxes around fingers, palm and camera."""
AXES = ((200, 30, 30), (20, 140, 20), (30, 60, 210))
"""Colours of the axes x, y and z of the tool frame."""
AXIS_SHARE = 0.14
"""Length of a drawn axis as a share of the gripper's size."""
MARGIN = 1.25
"""Size of a view over that of the gripper: it leaves room for the title."""
FONT = cv2.FONT_HERSHEY_DUPLEX


def hand_describe(
    file: Path,
    /,
    *,
    output: Path | None = None,
    picture: Path | None = None,
    name: str | None = None,
    palm: str | None = None,
    tcp: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    pinch: list[str] | None = None,
    joint_range: Annotated[Numbers, Parameter(name="--range")] = None,
    force: Numbers = None,
    package_dir: Annotated[list[Path] | None, Parameter(consume_multiple=False)] = None,
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
        write_hand(hand, output)
    if picture is not None:
        write_picture(picture, hand_picture(found))
        say(f"picture written to {picture}")
    say(
        f"{hand.name}: opens {1e3 * hand.min_opening:.1f} to {1e3 * hand.stroke:.1f} mm, pads "
        f"{1e3 * hand.pad_width:.1f} x {1e3 * hand.pad_height:.1f} mm, finger depth "
        f"{1e3 * hand.finger_depth:.1f} mm, {hand.force[0]:g} to {hand.force[1]:g} N on each jaw, "
        f"tool frame {1e3 * hand.mount_distance:.1f} mm from the mount"
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


def hand_picture(found: DescribedHand) -> NDArray[np.uint8]:
    """Draw the open and the closed gripper from the front and obliquely, (H, W, 3) uint8 RGB."""
    hand = found.hand
    points = np.concatenate([found.opened, found.closed]).reshape(-1, 3)
    axes_end = AXIS_SHARE * np.ptp(points, axis=0).max() * np.ones(3)
    points = np.vstack([points, axes_end])
    low, high = points.min(axis=0), points.max(axis=0)
    rows = []
    for title, axes in (("from the front", FRONT), ("obliquely", _oblique())):
        row = []
        for word, triangles, opening in (
            ("open", found.opened, hand.stroke),
            ("closed", found.closed, hand.min_opening),
        ):
            corners = low + CORNERS * (high - low)
            flat = corners @ axes.T
            half = 0.5 * MARGIN * max(np.ptp(flat[:, 0]), np.ptp(flat[:, 1]) * PANEL[1] / PANEL[0])
            view = PaintedView(axes, 0.5 * (low + high), float(half), PANEL)
            _draw(view, found, triangles, opening, float(np.max(high - low)))
            picture = view.painted(PAPER)
            text = f"{hand.name} {word}, {1e3 * opening:.1f} mm, {title}"
            cv2.putText(picture, text, (12, 26), FONT, 0.6, INK, 1, cv2.LINE_AA)
            row.append(picture)
        rows.append(np.hstack(row))
    legend = np.full((40, rows[0].shape[1], 3), 255, np.uint8)
    x = 12
    for text, colour in (
        ("edges: boxes of the fingers", FINGER),
        ("of palm and linkage", PALM),
        *((("of a camera", CAMERA),) if hand.camera_boxes else ()),
        ("x: closing", AXES[0]),
        ("y", AXES[1]),
        ("z: approach", AXES[2]),
    ):
        cv2.putText(legend, text, (x, 26), FONT, 0.55, colour, 1, cv2.LINE_AA)
        x += cv2.getTextSize(text, FONT, 0.55, 1)[0][0] + 36
    return np.vstack([*rows, legend])


def _oblique() -> NDArray[np.float64]:
    """Return the axes of an oblique view with the approach downwards."""
    towards = np.array([0.55, 0.7, -0.45])
    towards /= np.linalg.norm(towards)
    right = np.cross([0.0, 0.0, -1.0], towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])


def _draw(
    view: PaintedView,
    found: DescribedHand,
    triangles: NDArray[np.float64],
    opening: float,
    size: float,
) -> None:
    hand = found.hand
    # Files wind triangles either way. Both sides are drawn.
    vertices = np.concatenate([triangles, triangles[:, ::-1]])
    view.add_mesh(vertices.reshape(-1, 3), np.arange(3 * len(vertices)).reshape(-1, 3), BODY)
    lift = 2.0 * size * view.axes[2]
    for boxes, colour in (
        (hand.jaw_boxes(opening), FINGER),
        (np.array([[box.low, box.high] for box in hand.palm_boxes]).reshape(-1, 2, 3), PALM),
        (np.array([[box.low, box.high] for box in hand.camera_boxes]).reshape(-1, 2, 3), CAMERA),
    ):
        for low, high in boxes:
            # Moved towards the viewer, so that the shapes do not hide the edges.
            view.add_wire(low + CORNERS * (high - low) + lift, colour, 1)
    for axis, colour in enumerate(AXES):
        end = np.zeros(3)
        end[axis] = AXIS_SHARE * size
        view.add_line(np.array([[0.0, 0.0, 0.0], end]) + 1.5 * lift, colour, 3)
