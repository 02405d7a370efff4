"""What a contour follower commands and reports in one cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ContourState = Literal["seek", "follow", "ended"]
"""seek: move over the surface to where the imprint shrinks; follow: move along a ridge or an edge;
ended: no motion."""

ContourPointKind = Literal["ridge", "edge", "corner", "inner_corner", "end"]
"""ridge: a narrow line; edge: the end of a face; corner: the end of an edge; inner_corner: a corner
where the next edge turns outwards; end: the end of a ridge."""

ContourOutcome = Literal["done", "round", "nothing_found", "lost", "blocked", "out_of_time"]
"""done: enough points, or both ends of a ridge; round: back at the start of the contour;
nothing_found: the distance limit was reached while seeking; lost: no contact for too long; blocked:
the pad does not move as commanded, for example at the end of the arm's reach; out_of_time: the
distance limit was reached while following, or the time limit."""


@dataclass(frozen=True)
class ContourPoint:
    """A point of the contour, where the follower detected it."""

    kind: ContourPointKind
    """What it is."""
    position: NDArray[np.float64]
    """(3,), m, in the sensor's frame of that cycle."""
    direction: float
    """Direction along the line, rad, in the sensor's frame."""


@dataclass(frozen=True, slots=True)
class ContourStep:
    """The command of one cycle, and what was detected."""

    twist: NDArray[np.float64]
    """Outer motion [v; ω], (6,), m/s and rad/s, in the sensor's frame."""
    state: ContourState
    """The state of the follower."""
    point: ContourPoint | None
    """Set in the one cycle in which a point was detected."""
    outcome: ContourOutcome | None
    """Set once the state is `ended`."""
