"""A gripper with two jaws of simple shape, from a few lengths."""

from __future__ import annotations

from eyehand.errors import InputError

from .parallel_hand import HandBox, HandJoint, ParallelHand


def generic_jaw(
    stroke: float = 0.085,
    finger_depth: float = 0.04,
    finger_width: float = 0.02,
    *,
    finger_thickness: float = 0.012,
    force: tuple[float, float] = (0.0, 40.0),
) -> ParallelHand:
    """Return a gripper with two box-shaped fingers in front of a box-shaped palm.

    Parameters
    ----------
    stroke
        Maximum distance between the pads, m.
    finger_depth
        Distance of the fingertips from the palm, m.
    finger_width
        Width of finger and pad across the closing direction, m.
    finger_thickness
        Thickness of a finger along the closing direction, m.
    force
        Minimum and maximum closing force of each jaw, N.

    Raises
    ------
    InputError
        If a length or force is out of range.
    """
    for name, value in (("finger_width", finger_width), ("finger_thickness", finger_thickness)):
        if not 0.0 < value < 1.0:
            raise InputError(f"{name} must be 0 to 1 m, got {value}")
    half = 0.5 * finger_width
    reach = 0.5 * stroke + finger_thickness
    return ParallelHand(
        name="generic",
        stroke=stroke,
        finger_boxes=(HandBox((0.0, -half, -finger_depth), (finger_thickness, half, 0.0)),),
        finger_depth=finger_depth,
        pad_width=finger_width,
        pad_height=min(finger_depth, finger_width),
        palm_boxes=(HandBox((-reach, -0.035, -finger_depth - 0.1), (reach, 0.035, -finger_depth)),),
        force=force,
        mount_distance=finger_depth + 0.1,
        joints=tuple(
            HandJoint(f"{side}_finger_joint", 0.5 * stroke, 0.0) for side in ("left", "right")
        ),
        source="generic: box fingers, palm 70 mm wide and 100 mm long",
    )
