"""Describe the gripper of an MJCF or URDF file as a `ParallelHand`."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..parallel_hand import HandBox, HandJoint, ParallelHand, ToolPose
from .jaw_boxes import camera_boxes, finger_boxes, palm_boxes, tool_origin
from .jaw_force import closing_force
from .jaw_motion import MAX_DRIVES, JawMotion, jaw_motion
from .jaw_postures import JawPostures, jaw_postures
from .links import Links, couplings, find_branches, find_palm, root_body
from .pad_area import between_jaws, opposed_pads
from .pad_turn import middle_shift, motion_remarks
from .pinch import pinch_motion
from .posing import Posing, find_drives
from .read_model import read_model

MIN_GAP = 6e-3
"""Least distance between the pads at which the space between them is measured, m."""
CURVED = 0.01
"""Share of a joint's range by which a straight line may differ from its positions."""
MIN_SPAN = 0.01
"""Least motion of a joint whose curve is listed, m or rad."""
BETWEEN = 9
"""Positions that are listed for a joint that does not move linearly with the opening."""


@dataclass(frozen=True)
class FileChoices:
    """What a file may leave open.

    Raises
    ------
    InputError
        If a range or force is out of order.
    """

    palm: str | None = None
    """Body on which the jaws move; None to find it."""
    tcp: str | None = None
    """Site or body at the fingertips, or an axis of the palm's body such as ``+x``; None to find
    the direction."""
    joint_range: tuple[float, float] | None = None
    """Range of joints that have none, m or rad."""
    force: tuple[float, float] | None = None
    """Minimum and maximum closing force of each jaw, N; None to take that of the motor."""
    pinch: tuple[str, str] | None = None
    """Bodies of the two fingers of a hand that are used as jaws; None to try all pairs of a hand
    with many motors."""
    package_dirs: tuple[Path, ...] = ()
    """Folders with ROS packages."""
    name: str | None = None
    """Name of the hand; None for that of the file."""

    def __post_init__(self) -> None:
        for option, pair in (("--range", self.joint_range), ("--force", self.force)):
            if pair is not None and not (
                all(math.isfinite(value) for value in pair) and pair[0] < pair[1]
            ):
                raise InputError(
                    f"{option} must be two finite numbers, the less first, "
                    f"got {pair[0]:g} {pair[1]:g}"
                )


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class DescribedHand:
    """A gripper read from a file."""

    hand: ParallelHand
    """Its description."""
    remarks: tuple[str, ...]
    """What was assumed, one line each."""
    opened: NDArray[np.float64]
    """Triangles of the open gripper in the tool frame, (T, 3, 3), m."""
    closed: NDArray[np.float64]
    """The same closed."""
    postures: JawPostures
    """How its joints move the jaws."""


def describe_hand(path: Path | str, choices: FileChoices | None = None) -> DescribedHand:
    """Describe the gripper in an MJCF or URDF file, alone or on an arm.

    Jaws are found by joints that move together, and by branches. All shapes of a finger count:
    those that collide, or those for display where nothing collides.

    Parameters
    ----------
    path
        The file.
    choices
        What the file may leave open; None for nothing.

    Raises
    ------
    InputError
        If the file is invalid, holds no gripper, or leaves something open. The message names the
        option that decides it.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    choices = choices or FileChoices()
    path = Path(path)
    model, remarks = read_model(path, choices.package_dirs)
    links = Links(model)
    try:
        palm = find_palm(links, choices.palm)
        branches = find_branches(links, palm)
        joints = links.joints(link for branch in branches for link in branch)
        drives = find_drives(links, joints, choices.joint_range)
        if choices.pinch is not None or len(drives.joints) > MAX_DRIVES:
            motion, names = pinch_motion(links, palm, branches, choices.pinch)
            return _described(path, motion, choices, remarks, pinch=names)
        motion = jaw_motion(Posing(links, joints, drives), palm, branches, choices.tcp)
        return _described(path, motion, choices, remarks)
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith("--") else f"{path}: {text}") from None
    except (ValueError, IndexError, ZeroDivisionError) as error:
        # Degenerate shapes leave nothing to measure: no point, no area, no motion.
        raise InputError(f"{path}: the gripper cannot be measured: {error}") from None


def _described(
    path: Path,
    motion: JawMotion,
    choices: FileChoices,
    assumed: tuple[str, ...],
    *,
    pinch: str = "",
) -> DescribedHand:
    gaps = np.maximum(motion.gaps, 0.0)
    pad_low, pad_high, pad_bottom = opposed_pads(motion)
    origin = tool_origin(motion, 0.5 * (pad_low + pad_high))
    remarks = [*assumed]
    force = choices.force
    if force is None:
        force, remark = closing_force(motion, pinch=bool(pinch))
        remarks.append(remark)
    if pinch:
        remarks.append(
            f"a hand of several fingers: {pinch} are used as two jaws, the other fingers are bent"
        )
    shift = middle_shift(motion)
    remarks += motion_remarks(motion, shift)
    remarks += motion.shapes.posing.short_motors(motion.path[0])
    postures = jaw_postures(motion, origin)
    palm = _hand_boxes(palm_boxes(motion, origin))
    depth = _depth(motion, pad_low, pad_high, palm)
    _check_depth(depth, pinch)
    hand = ParallelHand(
        name=choices.name or re.sub(r"[^\w-]+", "_", path.stem) or "hand",
        stroke=_rounded(gaps[0]),
        min_opening=_rounded(gaps[-1]) if gaps[-1] > 5e-4 else 0.0,
        finger_boxes=_hand_boxes(finger_boxes(motion, origin)),
        finger_depth=_rounded(depth),
        pad_width=_rounded(pad_high - pad_low),
        # Behind the depth of the fingers nothing reaches the pads.
        pad_height=_rounded(min(pad_bottom, depth)),
        palm_boxes=palm,
        camera_boxes=_hand_boxes(camera_boxes(motion, origin)),
        force=force,
        mount_distance=_rounded(_mount_distance(motion, origin)),
        tip_advance=_rounded(float(motion.tips[-1] - motion.tips[0])),
        kind="fingers" if pinch else "parallel",
        pre_shape=f"pinch of {pinch}" if pinch else "",
        middle_shift=(_rounded(shift[0]), _rounded(shift[1])),
        tool=_tool_pose(postures),
        joints=_joints(motion, everything=bool(pinch)),
        source=f"{path.name}, read by eyehand hand describe",
        notes="; ".join(remarks),
    )
    return DescribedHand(
        hand,
        tuple(remarks),
        _shown(motion, 0, origin),
        _shown(motion, -1, origin),
        postures,
    )


def _depth(motion: JawMotion, low: float, high: float, palm: Sequence[HandBox]) -> float:
    """Return the least distance over the stroke from the tips to what lies between the jaws, m."""
    depths = []
    for posture in range(0, len(motion.path), 5):
        if posture and motion.gaps[posture] < max(MIN_GAP, 0.25 * motion.gaps[0]):
            continue
        front = between_jaws(motion, posture, low, high)
        depths.append(float(motion.tips[posture]) - max(front, _finger_base(motion, posture)))
    reach = min(depths)
    in_front = [
        box.high[2]
        for box in palm
        if box.low[0] < 0.4 * motion.gaps[0] and box.high[0] > -0.4 * motion.gaps[0]
    ]
    # The boxes of a linkage are those of all postures, and the origin is at the farthest tips.
    free = -max(in_front, default=-np.inf) - float(np.ptp(motion.tips))
    return min(reach, free) if free > 0 else reach


def _check_depth(depth: float, pinch: str) -> None:
    if depth <= 0.0 and pinch:
        raise InputError(
            f"the other fingers reach as far as {pinch}, so that nothing fits between these two "
            "alone: more than two jaws around one point cannot be described"
        )
    if depth <= 0.0:
        raise InputError(
            f"the fingers end {-1e3 * depth:.0f} mm behind the palm along the approach: --tcp must "
            "name a point at the fingertips, or the axis along them"
        )


def _finger_base(motion: JawMotion, posture: int) -> float:
    motion.posed(posture)
    return float(motion.of_links(motion.pads[0])[:, :, 2].min())


def _tool_pose(postures: JawPostures) -> ToolPose:
    """Return the pose of the tool frame in the palm's body, rounded."""
    pose = postures.T_body_tool
    w, x, y, z = (
        round(float(value), 6) + 0.0
        for value in pose.rotation.as_quat(canonical=True, scalar_first=True)
    )
    px, py, pz = pose.translation
    return ToolPose(postures.body, (_rounded(px), _rounded(py), _rounded(pz)), (w, x, y, z))


def _mount_distance(motion: JawMotion, origin: NDArray[np.float64]) -> float:
    """Return the distance along z from the gripper's first frame to the tool frame, m."""
    shapes = motion.shapes
    model, data = shapes.posing.model, shapes.posing.data
    root = root_body(shapes.links, shapes.palm)
    motion.posed(0)
    turn, place = shapes.base_pose()
    # A file without an arm puts the mounting face at its own origin.
    alone = int(model.body_parentid[root]) == 0 or root == 0
    start = np.zeros(3) if alone else data.xpos[root]
    return float(origin[2] - ((start - place) @ turn) @ motion.axes[:, 2])


def _joints(motion: JawMotion, *, everything: bool) -> tuple[HandJoint, ...]:
    """Return the joints of the gripper that a driver commands, with their positions.

    They are the driven joints and those that mimic them, or all joints of a hand of fingers.
    """
    model = motion.shapes.posing.model
    links = motion.shapes.links
    drives = motion.shapes.posing.drives.joints
    coupled = {
        int(joint)
        for e in range(model.neq)
        if int(model.eq_type[e]) == 2
        for joint in (model.eq_obj1id[e], model.eq_obj2id[e])
    }
    openings = np.maximum(motion.gaps, 0.0)
    order = np.argsort(openings, kind="stable")
    groups = couplings(links)
    found = []
    for joint in links.joints(motion.shapes.link_geoms):
        if joint not in drives and joint not in coupled:
            continue
        positions = motion.path[:, model.jnt_qposadr[joint]]
        opened, closed = float(positions[0]), float(positions[-1])
        if abs(opened - closed) < 1e-4 and not everything:
            continue
        # Positions at opening 0 are extrapolated for jaws that do not close.
        rest = openings[-1] / max(openings[0] - openings[-1], 1e-9)
        group = next((one for one in groups if joint in one), {joint})
        rest = min([rest, *(_free_share(motion, member) for member in group)])
        closed_at_zero = closed + rest * (closed - opened)
        line = closed_at_zero + openings / openings[0] * (opened - closed_at_zero)
        between: tuple[float, ...] = ()
        if np.abs(line - positions).max() > CURVED * max(float(np.ptp(positions)), MIN_SPAN):
            asked = np.linspace(0.0, openings[0], BETWEEN + 2)[1:-1]
            values = np.interp(asked, openings[order], positions[order])
            between = tuple(round(float(value), 5) for value in values)
        name = model.joint(joint).name or f"joint {joint}"
        found.append(
            HandJoint(name, round(opened, 5), round(float(closed_at_zero), 5) + 0.0, between)
        )
    return tuple(found)


def _free_share(motion: JawMotion, joint: int) -> float:
    """Return how far a joint can close beyond the closed posture, as a share of its motion.

    Coupled joints go as far as the first one at a limit.
    """
    model = motion.shapes.posing.model
    opened, closed = motion.path[[0, -1], model.jnt_qposadr[joint]]
    if not model.jnt_limited[joint] or opened == closed:
        return np.inf
    low, high = model.jnt_range[joint]
    end = high if closed > opened else low
    return max(0.0, float((end - closed) / (closed - opened)))


def _shown(motion: JawMotion, posture: int, origin: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the triangles of the gripper in the tool frame at a posture, (T, 3, 3), m."""
    motion.posed(posture)
    links = [link for side in motion.jaws.sides for link in side]
    middle = np.array([motion.faces[posture].mean(), *origin[1:]])
    return np.concatenate([motion.fixed(), motion.of_links(links)]) - middle


def _hand_boxes(
    boxes: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]],
) -> tuple[HandBox, ...]:
    return tuple(
        HandBox(
            (_rounded(low[0]), _rounded(low[1]), _rounded(low[2])),
            (_rounded(high[0]), _rounded(high[1]), _rounded(high[2])),
        )
        for low, high in boxes
    )


def _rounded(value: float) -> float:
    """Return a length rounded to 0.1 mm."""
    return round(float(value), 4) + 0.0
