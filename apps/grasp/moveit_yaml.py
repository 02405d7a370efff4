"""Write grasps in the field layout of ROS `moveit_msgs/Grasp`, as YAML."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from eyehand.grasping import Grasp, ParallelHand

    from .jaw_frame import GraspedFrame

MIN_SHARE = 0.5
"""Minimum length of approach and retreat as a share of the desired one."""
CLOSING_SECONDS = 1.0
"""Time of a posture of the fingers, s."""
NO_STAMP = {"sec": 0, "nanosec": 0}
DECIMALS = 6


def grasps_yaml(found: GraspedFrame) -> str:
    """Return the best safe grasps, at most `found.top`, as a YAML list of `moveit_msgs/Grasp`.

    Quaternions are x, y, z, w here, because ROS orders them so.
    """
    ranked = [(rank, grasp) for rank, grasp in enumerate(found.grasps, 1) if grasp.safe]
    safe = ranked[: found.top]
    hand = found.hand
    comments = [
        f"moveit_msgs/Grasp[] of {hand.name}, the most probable first. Quaternions: x, y, z, w.",
        "grasp_pose is the tool frame: z along the approach, x along the closing direction,",
        "origin midway between the closed fingertips, "
        f"{hand.mount_distance:g} m from the mounting face.",
    ]
    comments += [
        f"max_contact_force is the largest closing force of {hand.name}, N.",
        "joint_names are those of the file of the gripper: see the guide for other names.",
    ]
    if len(safe) < len(found.grasps):
        comments.append(
            f"{len(safe)} of {len(ranked)} safe grasps; {len(found.grasps)} were found in all."
        )
    if not hand.joints:
        comments.append("The description of the hand names no joints, so the postures are empty.")
    grasps = [grasp_message(grasp, rank, found) for rank, grasp in safe]
    body = "\n".join(_lines(grasps)) if grasps else "[]"
    return "".join(f"# {' '.join(line.split())}\n" for line in comments) + body + "\n"


def grasp_message(grasp: Grasp, rank: int, found: GraspedFrame) -> dict[str, Any]:
    """Return a grasp as a message."""
    hand, frame_id = found.hand, found.scene.reference_frame
    place = grasp.T_scene_tcp.translation
    pose = hand.closed_pose(grasp.T_scene_tcp, grasp.width)
    return {
        "id": f"grasp {rank}, object {grasp.object_label}",
        "pre_grasp_posture": _posture(hand, grasp.width, frame_id),
        "grasp_posture": _posture(hand, hand.min_opening, frame_id),
        "grasp_pose": {"header": _header(frame_id), "pose": _pose(pose)},
        "grasp_quality": _number(grasp.success),
        "pre_grasp_approach": _translation(place - grasp.pre_grasp.translation, frame_id),
        "post_grasp_retreat": _translation(grasp.retreat.translation - place, frame_id),
        "post_place_retreat": _translation(grasp.pre_grasp.translation - place, frame_id),
        "max_contact_force": _number(hand.force[1]),
        "allowed_touch_objects": [],
    }


def _posture(hand: ParallelHand, opening: float, frame_id: str) -> dict[str, Any]:
    """Return a `trajectory_msgs/JointTrajectory` of one point."""
    seconds = int(CLOSING_SECONDS)
    point = {
        "positions": [_number(value) for value in hand.joint_positions(opening)],
        "velocities": [],
        "accelerations": [],
        "effort": [],
        "time_from_start": {"sec": seconds, "nanosec": int(1e9 * (CLOSING_SECONDS - seconds))},
    }
    return {
        "header": _header(frame_id),
        "joint_names": [joint.name for joint in hand.joints],
        "points": [point] if hand.joints else [],
    }


def _header(frame_id: str) -> dict[str, Any]:
    return {"stamp": NO_STAMP, "frame_id": frame_id}


def _pose(pose: RigidTransform) -> dict[str, Any]:
    return {
        "position": _named("xyz", pose.translation),
        "orientation": _named("xyzw", pose.rotation.as_quat()),
    }


def _translation(shift: NDArray[np.float64], frame_id: str) -> dict[str, Any]:
    """Return a `moveit_msgs/GripperTranslation`."""
    length = float(np.linalg.norm(shift))
    return {
        "direction": {"header": _header(frame_id), "vector": _named("xyz", shift / length)},
        "desired_distance": _number(length),
        "min_distance": _number(MIN_SHARE * length),
    }


def _named(names: str, values: NDArray[np.float64]) -> dict[str, float]:
    return {name: _number(value) for name, value in zip(names, values, strict=True)}


def _number(value: float) -> float:
    return round(float(value), DECIMALS)


def _lines(value: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the lines of a YAML list of mappings."""
    lines = []
    for item in value:
        inner = _mapping(item, "  ")
        lines += [f"- {inner[0].lstrip()}", *inner[1:]]
    return lines


def _mapping(mapping: Mapping[str, Any], indent: str) -> list[str]:
    """Return the lines of a YAML mapping. Texts, numbers and small values take one line."""
    lines = []
    for key, value in mapping.items():
        if isinstance(value, dict) and any(isinstance(v, dict | list) for v in value.values()):
            lines += [f"{indent}{key}:", *_mapping(value, indent + "  ")]
        elif isinstance(value, list) and any(isinstance(v, dict) for v in value):
            lines += [f"{indent}{key}:", *(f"{indent}{line}" for line in _lines(value))]
        elif isinstance(value, dict):
            inside = ", ".join(f"{name}: {_text(v)}" for name, v in value.items())
            lines.append(f"{indent}{key}: {{{inside}}}")
        else:
            lines.append(f"{indent}{key}: {_text(value)}")
    return lines


def _text(value: Any) -> str:
    """Return a value of one line. YAML 1.1 reads 4e-06 as a text, so numbers have no exponent."""
    if isinstance(value, float):
        return np.format_float_positional(value, trim="0")
    if isinstance(value, list):
        return f"[{', '.join(_text(item) for item in value)}]"
    return json.dumps(value)
