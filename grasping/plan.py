"""What the hand is asked to do: a prototype, a pre-shape, and the rows the approach controls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .prototypes import Approach, Prototype

Row = Literal[
    "distance_to_point",
    "distance_to_axis",
    "position",
    "point_on_plane",
    "look_at",
    "axis_alignment",
    "orientation",
]
"""Approach tasks by name, as the control basis calls them."""


@dataclass(frozen=True)
class ApproachTask:
    """One task of the approach, in the scene's frame; priority is its place in the plan."""

    name: Row
    """Which task."""
    rows: int
    """Degrees of freedom it takes."""
    point: NDArray[np.float64]
    """Reference point, (3,), m."""
    axis: NDArray[np.float64]
    """Unit direction, (3,): the axis itself, the plane's normal, the hand's goal axis, or the
    palm's preferred direction for `look_at`."""
    target: float
    """Target value: a distance in m or an angle in rad."""
    says: str
    """What the task asks, for people."""


@dataclass(frozen=True)
class Score:
    """How well a prototype suits, from 0 to 1, with its terms."""

    total: float
    """Product of the terms."""
    terms: dict[str, float]
    """Each term, 0-1."""


@dataclass(frozen=True)
class GraspPlan:
    """The chosen grasp, or the refusal (false in a condition) with its reason."""

    prototype: Prototype | None
    """Chosen prototype; None when refused."""
    approach: Approach | None
    """Where the palm comes from."""
    opening: float
    """Pre-shape: distance of fingertips and thumb, m."""
    closing: NDArray[np.float64]
    """Unit direction along which the hand closes, (3,)."""
    palm: NDArray[np.float64]
    """Unit direction in which the palm faces and arrives, (3,); a preference where the tasks
    leave it free."""
    tasks: tuple[ApproachTask, ...]
    """Approach tasks by priority."""
    score: Score
    """Score of the chosen prototype."""
    rejected: dict[str, str]
    """Why each other prototype lost."""
    mass: tuple[float, float, float]
    """Least, likely and largest mass, kg."""
    reason: str
    """Why this prototype, or why none."""

    def __bool__(self) -> bool:
        return self.prototype is not None

    @property
    def rows(self) -> int:
        """Degrees of freedom that the approach tasks take; a full pose takes 6."""
        return sum(task.rows for task in self.tasks)
