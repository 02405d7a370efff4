"""The approach of a plan as tasks of the control basis, for the hand at any distance of the way."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

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
)
from eyehand.errors import InputError

from .approach_tasks import approach_tasks
from .palm_placement import GraspDepths, stance

if TYPE_CHECKING:
    from eyehand.control.tasks import Task

    from .hand_model import HandModel
    from .plan import ApproachTask, GraspPlan

HAND_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
"""Axes of the hand's frame: from fingers to thumb, along the row of fingers, out of the palm."""


def control_tasks(
    plan: GraspPlan, hand: HandModel, back: float = 0.0, depths: GraspDepths | None = None
) -> tuple[Task, ...]:
    """Give the tasks that bring the hand to a grasp, or some way back from it.

    Parameters
    ----------
    plan
        The grasp.
    hand
        Its reach decides how deep it goes.
    back
        Distance from the grasp against the palm's direction, m, at least 0.
    depths
        Where the object is to be in the hand; as it was chosen for when None.

    Returns
    -------
    tuple of Task
        Highest priority first; tasks of the hand's frame, its origin the middle of the palm, z out
        of it. For any ``back`` they are the same tasks with other goals.

    Raises
    ------
    InputError
        If the plan is a refusal, or ``back`` is below 0.
    """
    if plan.prototype is None or plan.grip is None:
        raise InputError(f"a refused grasp has no approach: {plan.reason}")
    if not 0.0 <= back < np.inf:
        raise InputError(f"back must be a finite distance >= 0 m, got {back}")
    # Touch may have moved the plan's tasks to where the object turned out to be.
    centre = plan.tasks[0].point if plan.tasks else plan.grip.centre
    rise = plan.grip.rise + float((centre - plan.grip.centre) @ plan.grip.up)
    grip = replace(plan.grip, centre=centre, rise=rise)
    place = stance(grip, plan.prototype, plan.opening, hand, depths or plan.depths)
    return tuple(control_task(task, back) for task in approach_tasks(grip, place))


def control_task(task: ApproachTask, back: float = 0.0) -> Task:
    """Give one approach task as a task, for the hand so far back from the grasp, m."""
    away = task.recedes * back
    name = task.says
    match task.name:
        case "distance_to_point":
            return DistanceToPoint(task.point, task.target + away, name=name)
        case "look_at":
            return LookAt(task.point, task.target, name=name)
        case "distance_to_axis":
            ahead = np.array([0.0, 0.0, 0.0 if task.ahead is None else task.ahead + away])
            return DistanceToAxis(task.point, task.axis, task.target, ahead, name=name)
        case "axis_alignment":
            return AxisAlignment(np.array(HAND_AXES[task.hand_axis]), task.axis, name=name)
        case "position":
            return Position(task.point - (task.target + away) * task.axis, name=name)
        case "orientation":
            assert task.palm is not None
            thumb, palm = task.axis, task.palm
            goal = np.column_stack([thumb, np.cross(palm, thumb), palm])
            return Orientation(goal, name=name)
        case "point_on_plane":
            zero = float(task.axis @ task.point) + away
            plane = PointOnPlane(task.axis, zero + task.target, name=name)
            if task.high is None:
                return plane
            return Interval(plane, zero + task.target, zero + task.high)
    raise InputError(f"unknown approach task {task.name!r}")
