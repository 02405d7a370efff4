"""The planned grasp: prototype, pre-shape, and the tasks of the approach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .grasp_geometry import GraspGeometry
    from .palm_placement import TipDepth
    from .prototypes import Approach, Prototype

ApproachTaskName = Literal[
    "distance_to_point",
    "distance_to_axis",
    "position",
    "point_on_plane",
    "look_at",
    "axis_alignment",
    "orientation",
]
"""Names of the approach tasks, equal to those of the control tasks."""


@dataclass(frozen=True)
class ApproachTask:
    """One task of the approach, in the scene's frame; its place in the plan is its priority."""

    name: ApproachTaskName
    """Name of the control task."""
    rows: int
    """Degrees of freedom that the task controls."""
    point: NDArray[np.float64]
    """Reference point, (3,), m."""
    axis: NDArray[np.float64]
    """Unit direction, (3,): the axis, the plane's normal, the goal of the hand axis, or the
    preferred direction of the palm for `look_at`."""
    target: float
    """Target value in m or rad; the lower bound of an interval."""
    description: str
    """Description of the task for reports."""
    upper: float | None = None
    """Upper bound of an interval; inf for none. None means that the task is not an interval. An
    interval controls a degree of freedom only at a bound, and counts 0 rows."""
    retreat_slope: float = 0.0
    """Increase of the target, and of the upper bound, per metre of retreat."""
    palm_offset: float | None = None
    """Distance of the controlled point in front of the palm, m. It increases with the retreat
    instead of the target. None controls the palm itself."""
    hand_axis: Literal["x", "y", "z"] = "z"
    """Axis of the hand that an alignment turns to ``axis``."""
    palm: NDArray[np.float64] | None = None
    """Goal of the palm's direction for an orientation, (3,); ``axis`` is the thumb's direction."""


@dataclass(frozen=True)
class Score:
    """Score of a grasp."""

    total: float
    """Product of the terms, in [0, 1]."""
    terms: dict[str, float]
    """Terms by name, each in [0, 1]."""


@dataclass(frozen=True)
class GraspPlan:
    """A planned grasp, or a refusal with its reason (false in a condition)."""

    prototype: Prototype | None
    """Prototype; None for a refusal."""
    approach: Approach | None
    """Direction from which the palm approaches; None for a refusal."""
    opening: float
    """Distance of fingertips and thumb in the pre-shape, m."""
    closing: NDArray[np.float64]
    """Unit direction of closing from the fingers to the thumb, (3,)."""
    palm: NDArray[np.float64]
    """Unit direction that the palm faces, (3,); a preference where the tasks leave it free."""
    tasks: tuple[ApproachTask, ...]
    """Approach tasks, the highest priority first."""
    score: Score
    """Score of the grasp."""
    rejected: dict[str, str]
    """Reason why each other kind of grasp was rejected."""
    mass: tuple[float, float, float]
    """Minimum, likely and maximum mass of the object, kg."""
    reason: str
    """Summary of the grasp, or the reason of the refusal."""
    geometry: GraspGeometry | None = None
    """Directions and sizes of the grasp; None for a refusal."""
    standoff: float = 0.0
    """Distance of the palm from the object's centre at the grasp, along ``palm``, m."""
    palm_gap: float = 0.0
    """Distance of the palm from the object's near face at the grasp, m."""
    lever: float = 0.0
    """Horizontal distance of the centre of mass from the closing axis of jaws, m."""
    gripped_width: float | None = None
    """Expected distance of jaws in the grip, m; at a rim that of the wall. None for fingers."""
    tip_depth: TipDepth | None = None
    """Wanted depth of the fingertips; None for the default."""
    pushed_label: int = 0
    """Label of the neighbour that the fingers push aside; 0 for none."""
    may_push: bool = False
    """Whether hand and arm may touch neighbours and enter occluded space."""
    fingers: int = 0
    """Number of fingers without the thumb whose pads touch the solid."""

    def __bool__(self) -> bool:
        return self.prototype is not None

    @property
    def name(self) -> str:
        """Approach and prototype, for example ``top precision``; ``no grasp`` for a refusal."""
        return f"{self.approach} {self.prototype}" if self.prototype else "no grasp"

    @property
    def kind(self) -> str:
        """Kind of the fitted solid; ``unknown`` for a refusal."""
        return self.geometry.kind if self.geometry else "unknown"

    @property
    def rows(self) -> int:
        """Degrees of freedom that the approach controls; a full pose has 6."""
        return sum(task.rows for task in self.tasks)
