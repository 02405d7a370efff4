"""What the hand is asked to do: a prototype, a pre-shape, and the rows the approach controls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .grasp_geometry import Grip
    from .palm_placement import GraspDepths
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
    """Target value: a distance in m or an angle in rad; of an interval its lower bound."""
    says: str
    """What the task asks, for people."""
    high: float | None = None
    """Upper bound of an interval, inf for none; None for a plain target. An interval takes a row
    only at a bound, and counts as 0 rows."""
    recedes: float = 0.0
    """By how much the target (and an interval's upper bound) grows per m that the hand stands
    back."""
    ahead: float | None = None
    """Distance before the palm of the hand's point that is meant, m, which then recedes in place of
    the target; None: the palm itself."""
    hand_axis: Literal["x", "y", "z"] = "z"
    """Axis of the hand that an alignment turns onto ``axis``."""
    palm: NDArray[np.float64] | None = None
    """Of an orientation: where the palm faces, (3,); ``axis`` is where the thumb is."""


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
    grip: Grip | None = None
    """Where and how the hand takes hold, as far as the object alone tells; None when refused."""
    standoff: float = 0.0
    """Distance of the palm from the object's centre at the grasp, along ``palm``, m."""
    depth: float = 0.0
    """Distance of the palm from the object's near face at the grasp, m."""
    depths: GraspDepths | None = None
    """Options by which the palm was placed; the usual ones when None."""

    pushes: int = 0
    """Label of the neighbour that the fingers push aside on purpose; 0 for none."""

    may_push: bool = False
    """Whether hand and arm may touch neighbours on the way, and go where nobody saw."""

    def __bool__(self) -> bool:
        return self.prototype is not None

    @property
    def name(self) -> str:
        """Approach and prototype, for people: ``top precision``; ``no grasp`` when refused."""
        return f"{self.approach} {self.prototype}" if self.prototype else "no grasp"

    @property
    def kind(self) -> str:
        """Solid that the object was taken for; ``unknown`` when there is none."""
        return self.grip.kind if self.grip else "unknown"

    @property
    def rows(self) -> int:
        """Degrees of freedom that the approach tasks take; a full pose takes 6."""
        return sum(task.rows for task in self.tasks)
