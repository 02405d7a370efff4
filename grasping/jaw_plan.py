"""Convert a grasp of two jaws to the plan that the phases of a pick execute."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .plan import ApproachTask, GraspPlan, Score
from .prototypes import mass_range

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, Superquadric

    from .hands import ParallelHand
    from .jaws import Grasp

TOP_COSINE = np.cos(np.radians(45.0))
"""Cosine of the angle from straight down up to which an approach is from the top."""


def jaw_plans(
    hand: ParallelHand, grasp: Grasp, item: SceneObject, up: NDArray[np.float64]
) -> tuple[GraspPlan, ...]:
    """Return the plans of a grasp: the gripper as planned, and turned by half a turn.

    Both close on the same faces. The arm may reach only one of them.

    Parameters
    ----------
    hand
        The gripper.
    grasp
        Grasp of the object, in the frame of its scene.
    item
        The object.
    up
        Unit direction up, (3,).
    """
    return _plan(hand, grasp, item, up, 1.0), _plan(hand, grasp, item, up, -1.0)


def _plan(
    hand: ParallelHand, grasp: Grasp, item: SceneObject, up: NDArray[np.float64], turn: float
) -> GraspPlan:
    tip, palm, closing = grasp.position, grasp.approach, turn * grasp.closing
    # The arm moves the frame of the closed gripper.
    axes = np.column_stack([closing, np.cross(palm, closing), palm])
    tool = tip - axes @ hand.middle(grasp.width)
    solids = item.fit.parts or ((item.fit.superquadric,) if item.fit.superquadric else ())
    depth = float((palm @ tip) - (item.points @ palm).min())
    volumes = np.array([solid.volume for solid in solids])
    volume = float(volumes.sum())
    tasks = (
        ApproachTask(
            "position", 3, tool, palm, 0.0, "tool centre point at the grasp", retreat_slope=1.0
        ),
        ApproachTask(
            "orientation", 3, tool, closing, 0.0, "approach and closing direction", palm=palm
        ),
    )
    return GraspPlan(
        prototype="pincer",
        approach="top" if -palm @ up >= TOP_COSINE else "side",
        opening=grasp.width,
        closing=closing,
        palm=palm,
        tasks=tasks,
        score=Score(grasp.success, dict(grasp.terms)),
        rejected={},
        mass=mass_range(volume),
        reason=grasp.reason,
        palm_gap=-max(depth, 0.0),
        lever=_lever(tip, closing, up, solids, volumes),
        gripped_width=grasp.object_width,
    )


def _lever(
    tip: NDArray[np.float64],
    closing: NDArray[np.float64],
    up: NDArray[np.float64],
    solids: Sequence[Superquadric],
    volumes: NDArray[np.float64],
) -> float:
    """Return the horizontal distance of the centre of mass from the closing axis, m."""
    if not len(solids):
        return 0.0
    centre = volumes @ [solid.centre for solid in solids] / volumes.sum()
    return abs(float(np.cross(centre - tip, up) @ closing))
