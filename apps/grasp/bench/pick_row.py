"""A pick of a trial in plain values."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PickRow:
    """A pick in plain values, scored against the ground truth."""

    pick: int
    """Index of the pick, from 0."""
    object: str
    """True name of the target object."""
    kind: str
    """Kind of the fitted solid."""
    prototype: str
    """Grasp prototype."""
    approach: str
    """Approach side of the palm."""
    rows: int
    """Number of task rows that the approach controlled."""
    outcome: str
    """Outcome as reported by the robot."""
    reason: str
    """Reason of a failure."""
    success: bool
    """Whether the robot reports success and the object is in the tray."""
    perceive_ms: float
    """Duration of perception, ms."""
    plan_ms: float
    """Duration of grasp selection and planning, ms."""
    seconds: float
    """Simulated time of the pick, s."""
    wall_seconds: float
    """Wall time of the pick, s."""
    touched_before: int
    """Number of other bodies that the robot touched before the grasp by mistake. Neighbours that a
    grasp may push aside are counted in `touched_pushing` instead."""
    pads: int
    """Number of pads in contact while the object was held."""
    curl: float
    """Bending angle of the fingers around the object, rad."""
    pushed: bool = False
    """Whether the grasp was allowed to push neighbours aside, as the last resort."""
    touched_pushing: int = 0
    """Number of neighbours that a pushing grasp touched before it closed."""
    displacement: float | None = None
    """Motion of the object from its first contact to the hold, m; None if it was not held."""
    score: float | None = None
    """Score of the grasp."""
    hold: float | None = None
    """Probability that the grasp holds by contact mechanics; None for a gripper with jaws."""
    lifted: bool = False
    """Whether the hand alone held the object after the lift."""
    kept: bool = False
    """Whether a lifted object left the hand nowhere but where it was released."""
    squeeze: float | None = None
    """Force on the pads after the lift, over the least one that holds the load by friction."""
