"""Convert the approach of a plan to control tasks, at any distance of retreat."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from eyehand.control.tasks import (
    AxisAlignment,
    DistanceToAxis,
    DistanceToPoint,
    Interval,
    LookAt,
    Orientation,
    PointOnPlane,
    Position,
    Task,
)
from eyehand.errors import InputError

from .approach_tasks import approach_tasks
from .hands import HandModel, ParallelHand
from .palm_placement import place_palm
from .plan import ApproachTask, GraspPlan

HAND_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
"""Axes of the hand frame: from fingers to thumb, along the row of fingers, out of the palm."""


def control_tasks(
    plan: GraspPlan, hand: HandModel | ParallelHand, retreat: float = 0.0
) -> tuple[Task, ...]:
    """Return the control tasks of a grasp, or of a pose at a distance from it.

    The tasks refer to the hand frame, whose origin is the middle of the palm and whose z axis
    points out of it. All retreats have the same tasks with other goals.

    Parameters
    ----------
    plan
        The grasp.
    hand
        The hand; its reach determines the distance of the palm.
    retreat
        Distance from the grasp against the palm's direction, m, at least 0.

    Returns
    -------
    tuple of Task
        Tasks, the highest priority first.

    Raises
    ------
    InputError
        If the plan is a refusal, or ``retreat`` is negative or not finite.
    """
    if plan.prototype is None:
        raise InputError(f"a refused grasp has no approach: {plan.reason}")
    if not 0.0 <= retreat < np.inf:
        raise InputError(f"retreat must be a finite distance >= 0 m, got {retreat}")
    if plan.geometry is None or plan.tip_depth is None or isinstance(hand, ParallelHand):
        return tuple(control_task(task, retreat) for task in plan.tasks)
    # Touch may have shifted the plan's tasks.
    geometry = plan.geometry
    centre = plan.tasks[0].point if plan.tasks else geometry.centre
    rise = geometry.rise + float((centre - geometry.centre) @ geometry.up)
    geometry = replace(geometry, centre=centre, rise=rise)
    placement = place_palm(geometry, plan.prototype, plan.opening, hand, plan.tip_depth)
    return tuple(control_task(task, retreat) for task in approach_tasks(geometry, placement))


def control_task(task: ApproachTask, retreat: float = 0.0) -> Task:
    """Return an approach task as a control task, at a retreat in m."""
    shift = task.retreat_slope * retreat
    name = task.description
    match task.name:
        case "distance_to_point":
            return DistanceToPoint(task.point, task.target + shift, name=name)
        case "look_at":
            return LookAt(task.point, task.target, name=name)
        case "distance_to_axis":
            offset = 0.0 if task.palm_offset is None else task.palm_offset + shift
            point = np.array([0.0, 0.0, offset])
            return DistanceToAxis(task.point, task.axis, task.target, point, name=name)
        case "axis_alignment":
            return AxisAlignment(np.array(HAND_AXES[task.hand_axis]), task.axis, name=name)
        case "position":
            return Position(task.point - (task.target + shift) * task.axis, name=name)
        case "orientation":
            assert task.palm is not None
            thumb, palm = task.axis, task.palm
            goal = np.column_stack([thumb, np.cross(palm, thumb), palm])
            return Orientation(goal, name=name)
        case "point_on_plane":
            zero = float(task.axis @ task.point) + shift
            plane = PointOnPlane(task.axis, zero + task.target, name=name)
            if task.upper is None:
                return plane
            return Interval(plane, zero + task.target, zero + task.upper)
    raise InputError(f"unknown approach task {task.name!r}")
