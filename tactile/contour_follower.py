"""An outer motion computed from touch: it seeks ridges and edges, and follows them all round."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from .area_slope import AreaSlope
from .contour_options import ContourOptions
from .rim import RimEdge, corner_of, find_rim, fit_edge, line_tip, longest_edge

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .features import ContactFeatures
    from .image import TactileImage
    from .rim import Rim

ContourState = Literal["seek", "follow", "ended"]
"""seek: over the surface, to where the imprint shrinks; follow: along a line; ended: rest."""

ContourPointKind = Literal["ridge", "edge", "corner", "inner_corner", "end"]
"""ridge: a narrow line; edge: where a face ends; corner: where an edge does; inner_corner: where
the next edge turns outwards; end: a ridge's."""

ContourOutcome = Literal["done", "round", "nothing_found", "lost", "blocked", "out_of_time"]
"""done: as many spots as asked for, or both ends of a ridge; round: back where following began;
nothing_found: the travel was used up in seeking; lost: no contact for too long; blocked: the pad
did not move as asked, say at the end of the arm's reach; out_of_time: the travel was used up in
following, or the time."""


@dataclass(frozen=True)
class ContourPoint:
    """Something worth knowing, where it was noticed."""

    kind: ContourPointKind
    """What it is."""
    place: NDArray[np.float64]
    """Where, (3,), m, in the sensor's frame of that cycle."""
    direction: float
    """Direction along the line there, rad, in the sensor's frame."""


@dataclass(frozen=True, slots=True)
class ContourStep:
    """What to do in this cycle, and what was noticed."""

    twist: NDArray[np.float64]
    """Outer motion [v; ω], (6,), in the sensor's frame."""
    state: ContourState
    """Where the guide is."""
    spot: ContourPoint | None
    """Set in the one cycle in which something was noticed."""
    outcome: ContourOutcome | None
    """Set once the state is ``ended``."""


class ContourFollower:
    """Seek, follow, turn at corners, and stop; the servo presses meanwhile (switches ``PRESS``).

    At constant pressure a small imprint is a curved place: so it seeks where the imprint shrinks.
    A narrow imprint is a ridge, followed to both ends. Otherwise the pressure falls where the face
    ends: that rim is kept beside the pad's middle, and where a second straight piece of it lies
    ahead, turned inwards or outwards by whatever angle, the two meet in a corner. The pad must not
    turn meanwhile.

    Parameters
    ----------
    options
        Speeds, thresholds, bounds.
    """

    def __init__(self, options: ContourOptions | None = None) -> None:
        self.options = options or ContourOptions()
        o = self.options
        self.state: ContourState = "seek"
        self.outcome: ContourOutcome | None = None
        self.found = 0
        """Spots so far."""
        self._heading = o.heading
        self._out = np.array([math.cos(o.heading), math.sin(o.heading)])
        self._along = np.array([-self._out[1], self._out[0]])
        self._edge: RimEdge | None = None
        self._next: RimEdge | None = None
        self._slope = AreaSlope(o.weave_length)
        self._place = np.zeros(2)
        self._began = self._began_out = self._edge_seen = np.zeros(2)
        self._first: NDArray[np.float64] | None = None
        self._asked = np.zeros(2)
        self._way = self._followed = self._round = 0.0
        self._time = self._lost_for = self._blocked_for = 0.0
        self._in_a_row = self._ends = 0
        self._narrow = False

    def step(
        self,
        features: ContactFeatures,
        image: TactileImage,
        dt: float,
        measured: NDArray[np.float64] | None = None,
    ) -> ContourStep:
        """Give the outer motion of this cycle.

        Parameters
        ----------
        features
            What the pad feels.
        image
            What they were read from, of a flat pad with an even grid.
        dt
            Time since the last cycle, s.
        measured
            Twist that the sensor moved with since then, (6,); if left out, what was asked for.
        """
        o = self.options
        self._time += dt
        self._move(self._asked if measured is None else measured[:2], dt)
        self._lost_for = 0.0 if features else self._lost_for + dt
        if self.outcome is None:
            if self._lost_for > o.lost_seconds:
                self._end("lost")
            elif self._blocked_for > o.blocked_seconds:
                self._end("blocked")
            elif self._time > o.seconds:
                self._end("out_of_time")
            elif self._way > o.travel:
                self._end("nothing_found" if self.found == 0 else "out_of_time")
        if self.state == "ended" or not features:
            self._asked = np.zeros(2)
            return ContourStep(np.zeros(6), self.state, None, self.outcome)
        rim = find_rim(image)
        if self.state == "seek":
            spot = self._seek(features, rim, dt)
        elif self._narrow:
            spot = self._follow_ridge(features, image)
        else:
            spot = self._follow(rim)
        if spot is not None:
            self.found += 1
            if self.outcome is None and self.found >= o.spots:
                self._end("done")
        twist = np.zeros(6)
        if self.state != "ended":
            twist[:2] = self._velocity(features)
        self._asked = twist[:2]
        return ContourStep(twist, self.state, spot, self.outcome)

    def _move(self, velocity: NDArray[np.float64], dt: float) -> None:
        step = float(np.hypot(*velocity)) * dt
        self._place = self._place + velocity * dt
        self._way += step
        self._followed += step
        self._round += step
        self._slope.move(velocity * dt)
        held = self._asked.any() and step < LEAST_MOVED * self.options.speed * dt
        self._blocked_for = self._blocked_for + dt if held else 0.0

    # Seeking ---------------------------------------------------------------------------------

    def _seek(self, features, rim: Rim, dt) -> ContourPoint | None:
        o = self.options
        slope = self._slope.update(features.area)
        if slope is not None:
            want = math.atan2(-slope[1], -slope[0])
            gap = (want - self._heading + math.pi) % (2.0 * math.pi) - math.pi
            self._heading += max(-o.steer * dt, min(o.steer * dt, gap))
        heading = np.array([math.cos(self._heading), math.sin(self._heading)])
        narrow = features.confidence >= o.line_confidence and _width(features) <= o.ridge_width
        edge = None if narrow else self._straight(longest_edge(rim))
        if not self._holds(narrow or edge is not None):
            return None
        self._narrow, self._edge, self._edge_seen = narrow, edge, self._place
        if edge is None:
            axis = np.array([math.cos(features.orientation), math.sin(features.orientation)])
            self._out = np.array([-axis[1], axis[0]])
        else:
            self._out = edge.outward
            axis = np.array([-self._out[1], self._out[0]])
        onwards = float(axis @ heading) >= 0
        if edge is not None and not edge.ends[0] <= 0.0 <= edge.ends[1]:
            # Only a piece to one side is felt: the other way may lead back over the face.
            onwards = edge.ends[0] > 0.0
        self._along = axis if onwards else -axis
        self._start_line()
        # It may have been noticed at its very end.
        self._followed = self.options.leave
        place = self._beside(features) * self._out if edge is None else edge.nearest
        self._round = 0.0
        return ContourPoint(
            "ridge" if narrow else "edge", np.append(place, 0.0), _angle(self._along)
        )

    def _straight(self, edge: RimEdge | None) -> RimEdge | None:
        o = self.options
        return edge if edge and edge.span >= o.edge_span and edge.rms <= o.edge_rms else None

    # Following -------------------------------------------------------------------------------

    def _follow(self, rim: Rim) -> ContourPoint | None:
        o = self.options
        edge = fit_edge(self._same_line(rim), self._out, o.reach)
        if edge is not None:
            side = _cross(self._along, self._out)
            self._edge, self._edge_seen = edge, self._place
            self._out = edge.outward
            self._along = side * np.array([self._out[1], -self._out[0]])
            foot = self._place + edge.nearest
            if self._round <= o.leave:
                self._began, self._began_out = foot, self._out
            elif self._round > 4 * o.leave and self._back(foot):
                self._end("round")
                return None
        self._next = self._edge_ahead(rim) if self._followed >= o.leave else None
        following = self._next
        turned_in = following is not None and float(following.outward @ self._along) > 0
        there = following is not None and (
            following.offset <= o.inset if turned_in else following.offset >= o.inset
        )
        return self._turn_at(following) if self._holds(there) and following else None

    def _same_line(self, rim: Rim) -> Rim:
        """Leave out what faces the same way elsewhere, as an angle's other arm does."""
        if self._edge is None:
            return rim
        out = self._edge.outward
        offset = self._edge.offset - float((self._place - self._edge_seen) @ out)
        return rim.some(np.abs(rim.points @ out - offset) < SAME_LINE)

    def _back(self, foot) -> bool:
        """Whether following began here; where two edges meet, on the same one."""
        same = float(self._out @ self._began_out) > math.cos(self.options.corner)
        return same and math.dist(foot, self._began) < self.options.close

    def _edge_ahead(self, rim: Rim) -> RimEdge | None:
        """The face's next edge: turned inwards beyond a corner, or outwards."""
        o, edge = self.options, self._edge
        if edge is None:
            return None
        beside = rim.points @ edge.outward - edge.offset
        turned = rim.outward @ self._along
        facing = rim.outward @ edge.outward < math.cos(o.corner)
        ahead = rim.points @ self._along > -o.inset
        inwards = facing & (turned > LEAST_TURN) & (beside < -OFF_EDGE) & ahead
        outwards = facing & (turned < -LEAST_TURN) & (beside > OFF_EDGE)
        chosen = inwards if np.count_nonzero(inwards) >= np.count_nonzero(outwards) else outwards
        return self._straight(longest_edge(rim.some(chosen)))

    def _turn_at(self, following: RimEdge) -> ContourPoint | None:
        edge = self._edge
        if edge is None:
            return None
        place, direction = corner_of(edge, following), _angle(self._along)
        there = self._place + place
        if self._first is None:
            self._first = there
        elif self._round > 4 * self.options.leave and math.dist(there, self._first) < SAME_LINE:
            self._end("round")
            return None
        kind = "corner" if float(following.outward @ self._along) > 0 else "inner_corner"
        side = _cross(self._along, self._out)
        self._edge, self._edge_seen, self._out = following, self._place, following.outward
        self._along = side * np.array([self._out[1], -self._out[0]])
        self._start_line()
        return ContourPoint(kind, np.append(place, 0.0), direction)

    def _follow_ridge(self, features, image: TactileImage) -> ContourPoint | None:
        o = self.options
        if features.confidence >= o.line_confidence:
            axis = np.array([math.cos(features.orientation), math.sin(features.orientation)])
            axis = axis if float(axis @ self._along) >= 0 else -axis
            # A line that bends turns slowly; what jumps is another axis of a short imprint.
            if float(axis @ self._along) > math.cos(math.radians(30.0)):
                self._along, self._out = axis, np.array([-axis[1], axis[0]])
        tip = line_tip(image, self._along)
        if not self._holds(self._followed > o.leave and tip < o.inset):
            return None
        place = tip * self._along + self._beside(features) * self._out
        direction = _angle(self._along)
        self._along, self._ends = -self._along, self._ends + 1
        self._start_line()
        if self._ends == 2:
            self._end("done")
        return ContourPoint("end", np.append(place, 0.0), direction)

    def _start_line(self) -> None:
        self.state = "follow"
        self._followed = 0.0
        self._in_a_row = 0

    def _beside(self, features) -> float:
        """Distance from the pad's middle to the line, towards where the face ends, m."""
        if self._edge is None:
            return float(features.centre[:2] @ self._out)
        return self._edge.offset

    def _velocity(self, features):
        o = self.options
        if self.state == "seek":
            swing = o.weave * math.sin(2.0 * math.pi * self._way / o.weave_length)
            angle = self._heading + swing
            return o.speed * np.array([math.cos(angle), math.sin(angle)])
        inset = 0.0 if self._narrow else o.inset
        side = min(max(o.side_gain * (self._beside(features) - inset), -o.speed), o.speed)
        return o.speed * self._along + side * self._out

    def _holds(self, now: bool) -> bool:
        self._in_a_row = self._in_a_row + 1 if now else 0
        return self._in_a_row >= self.options.cycles

    def _end(self, outcome: ContourOutcome) -> None:
        self.outcome, self.state = outcome, "ended"


OFF_EDGE = 0.003
"""Distance from an edge at which rim is of another, m: foam rounds corners by as much."""
LEAST_TURN = 0.2
"""How far the next edge must face along the way or against it, a cosine: the face's far side
does not."""
SAME_LINE = 0.008
"""Distance from the edge within which rim is still the same edge's, and from the first corner
within which one is the same, m: of a bend, rim within the reach is as far off."""
LEAST_MOVED = 0.25
"""Share of the speed below which the pad counts as held."""


def _width(features: ContactFeatures) -> float:
    """Width, m, of the rectangle with that area and confidence.

    Its second moments are L²/12 and W²/12, so W/L = sqrt((1 - c)/(1 + c)).
    """
    ratio = math.sqrt(max(1.0 - features.confidence, 1e-6) / (1.0 + features.confidence))
    return math.sqrt(features.area * ratio)


def _cross(a, b) -> float:
    """1 if b is to the left of a, else -1."""
    return 1.0 if a[0] * b[1] - a[1] * b[0] >= 0 else -1.0


def _angle(direction) -> float:
    return math.atan2(direction[1], direction[0])
