"""The command and the report of a contour follower for one cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ContourState = Literal["seek", "follow", "ended"]
"""State of the follower.

- seek: move over the surface in the direction in which the imprint shrinks.
- follow: move along a ridge or an edge.
- ended: no motion.
"""

ContourPointKind = Literal["ridge", "edge", "corner", "inner_corner", "end"]
"""Kind of a contour point.

- ridge: a narrow line.
- edge: the border of a face.
- corner: a convex corner of a face.
- inner_corner: a concave corner of a face.
- end: the end of a ridge.
"""

ContourOutcome = Literal["done", "closed", "nothing_found", "lost", "blocked", "limit_reached"]
"""Reason why the follower ended.

- done: enough points, or both ends of a ridge.
- closed: back at the start of the contour.
- nothing_found: the distance limit was reached while seeking.
- lost: no contact for too long.
- blocked: the pad does not move as commanded, for example at the limit of the arm's workspace.
- limit_reached: the time limit was reached, or the distance limit while following.
"""


@dataclass(frozen=True)
class ContourPoint:
    """A detected point of the contour."""

    kind: ContourPointKind
    """Kind of the point."""
    position: NDArray[np.float64]
    """(3,), m, in the sensor's frame of that cycle."""
    direction: float
    """Direction of the line, rad, in the sensor's frame."""


@dataclass(frozen=True, slots=True)
class ContourStep:
    """The command of one cycle and the point that was detected."""

    twist: NDArray[np.float64]
    """External twist [v; ω] for the servo, (6,), m/s and rad/s, in the sensor's frame."""
    state: ContourState
    """The state of the follower."""
    point: ContourPoint | None
    """The point that was detected in this cycle; None without one."""
    outcome: ContourOutcome | None
    """Reason of the end; None until the state is `ended`."""
