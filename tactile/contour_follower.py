"""Compute the external twist that finds ridges and edges by touch and follows them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .area_slope import AreaSlope
from .contour_progress import ContourOptions, ContourProgress
from .contour_step import ContourOutcome, ContourPoint, ContourState, ContourStep
from .features import ContactFeatures
from .image import TactileImage
from .rim import Rim, RimEdge, find_line_end, find_rim, fit_edge, fit_longest_edge, intersect_edges

WEAVE_ANGLE = 0.6
"""Amplitude of the sideways motion while seeking, rad. It shows where the imprint shrinks."""
WEAVE_LENGTH = 0.05
"""Distance of one such swing, m."""
STEER_RATE = 1.5
"""Angular speed with which the heading turns to where the imprint shrinks, rad/s."""
MIN_LINE_CONFIDENCE = 0.5
"""Confidence of the orientation above which a narrow imprint is a ridge."""
CONFIRM_CYCLES = 5
"""Successive cycles in which a line, or its end, must be detected."""
MAX_RIDGE_WIDTH = 0.02
"""Width of an imprint up to which it is a ridge and not a face, m."""
INSET = 0.008
"""Distance of the pad's middle to the rim while following, m, on the side of the face. Nearer to
the rim, the imprint is smaller. Farther from it, the pad feels less of what lies ahead."""
SIDE_GAIN = 4.0
"""Gain of the distance to the line, 1/s."""
EDGE_REACH = 0.02
"""Distance along an edge at which a rim point has a third of the weight, m. A longer distance
reduces noise, a shorter one follows bends."""
MAX_EDGE_RMS = 0.0007
"""Maximum rms distance of the rim from its line for a straight edge, m."""
MIN_EDGE_SPAN = 0.015
"""Minimum length of a rim that is an edge, m."""
MIN_CORNER_ANGLE = 0.7
"""Minimum angle between two edges at a corner, rad. A smaller angle is a bend."""
MAX_POINTS = 16
"""Number of contour points after which the follower is done."""
CLOSED_DISTANCE = 0.004
"""Distance to the start of the contour at which the contour is closed, m."""
LEAVE_DISTANCE = 0.02
"""Distance along a new line in which no corner or end is detected, m."""
OFF_EDGE = 0.003
"""Distance from an edge at which a rim point belongs to another edge, m. Foam rounds corners by as
much."""
MIN_TURN = 0.2
"""Minimum cosine between the next edge's normal and the direction of motion, or its opposite. It
excludes the other side of the face."""
SAME_EDGE = 0.008
"""Distance from an edge within which a rim point still belongs to it, and distance within which two
corners are the same, m. On a bend, the rim within `EDGE_REACH` is as far off."""
MAX_RIDGE_BEND = math.radians(30.0)
"""Maximum change of a ridge's direction within one cycle, rad. A larger one comes from a short
imprint."""


class ContourFollower:
    """Find a ridge or an edge by touch, follow it past corners, and stop.

    The servo controls the pressure meanwhile (selection `PRESS`). At constant pressure, a curved
    surface has a small imprint, so the follower moves to where the imprint shrinks. A narrow
    imprint is a ridge, which is followed to both ends. Otherwise the pressure falls where the face
    ends. This rim is kept beside the pad's middle. If a second straight rim lies ahead, at any
    angle, inwards or outwards, the two meet in a corner. The pad must not turn meanwhile.

    Parameters
    ----------
    options
        Start direction, speed and time limit.
    """

    def __init__(self, options: ContourOptions | None = None) -> None:
        self.options = options or ContourOptions()
        heading = self.options.heading
        self.state: ContourState = "seek"
        self.outcome: ContourOutcome | None = None
        self.found = 0
        """Number of points so far."""
        self._heading = heading
        self._out = np.array([math.cos(heading), math.sin(heading)])
        self._along = np.array([-self._out[1], self._out[0]])
        self._edge: RimEdge | None = None
        self._slope = AreaSlope(WEAVE_LENGTH)
        self._progress = ContourProgress(self.options)
        self._start = self._start_out = self._edge_position = np.zeros(2)
        self._first_corner: NDArray[np.float64] | None = None
        self._commanded = np.zeros(2)
        self._confirmed = self._ends = 0
        self._on_ridge = False

    def step(
        self,
        features: ContactFeatures,
        image: TactileImage,
        dt: float,
        measured: NDArray[np.float64] | None = None,
    ) -> ContourStep:
        """Compute the external twist of this cycle.

        Parameters
        ----------
        features
            The current contact features.
        image
            The tactile image of these features, from a flat pad with an even grid.
        dt
            Time since the last cycle, s.
        measured
            Twist of the sensor since the last cycle, (6,), m/s and rad/s; None assumes the
            commanded one.

        Raises
        ------
        InputError
            If the array is not a flat even grid.
        """
        velocity = self._commanded if measured is None else measured[:2]
        commanded = bool(self._commanded.any())
        self._progress.update(velocity, dt, commanded=commanded, touching=bool(features))
        self._slope.move(velocity * dt)
        exceeded = self._progress.exceeded_limit(self.found)
        if self.outcome is None and exceeded:
            self._end(exceeded)
        if self.state == "ended" or not features:
            self._commanded = np.zeros(2)
            return ContourStep(np.zeros(6), self.state, None, self.outcome)
        rim = find_rim(image)
        if self.state == "seek":
            point = self._seek(features, rim, dt)
        elif self._on_ridge:
            point = self._follow_ridge(features, image)
        else:
            point = self._follow_edge(rim)
        if point is not None:
            self.found += 1
            if self.outcome is None and self.found >= MAX_POINTS:
                self._end("done")
        twist = np.zeros(6)
        if self.state != "ended":
            twist[:2] = self._velocity(features)
        self._commanded = twist[:2]
        return ContourStep(twist, self.state, point, self.outcome)

    # Seeking ---------------------------------------------------------------------------------

    def _seek(self, features: ContactFeatures, rim: Rim, dt: float) -> ContourPoint | None:
        """Turn to where the imprint shrinks, and detect the first ridge or edge."""
        slope = self._slope.update(features.area)
        if slope is not None:
            goal = math.atan2(-slope[1], -slope[0])
            error = (goal - self._heading + math.pi) % (2.0 * math.pi) - math.pi
            self._heading += max(-STEER_RATE * dt, min(STEER_RATE * dt, error))
        heading = np.array([math.cos(self._heading), math.sin(self._heading)])
        narrow = (
            features.confidence >= MIN_LINE_CONFIDENCE
            and _imprint_width(features) <= MAX_RIDGE_WIDTH
        )
        edge = None if narrow else _if_straight(fit_longest_edge(rim))
        if not self._is_confirmed(narrow or edge is not None):
            return None
        self._on_ridge, self._edge, self._edge_position = narrow, edge, self._progress.position
        if edge is None:
            axis = np.array([math.cos(features.orientation), math.sin(features.orientation)])
            self._out = np.array([-axis[1], axis[0]])
        else:
            self._out = edge.outward
            axis = np.array([-self._out[1], self._out[0]])
        forwards = float(axis @ heading) >= 0
        if edge is not None and not edge.ends[0] <= 0.0 <= edge.ends[1]:
            # The pad feels the edge on one side only. The other direction may lead over the face.
            forwards = edge.ends[0] > 0.0
        self._along = axis if forwards else -axis
        self._start_line()
        # The line may have been detected at its very end.
        self._progress.line_travel = LEAVE_DISTANCE
        place = self._line_offset(features) * self._out if edge is None else edge.nearest
        self._progress.contour_travel = 0.0
        return ContourPoint("ridge" if narrow else "edge", np.append(place, 0.0), self._direction())

    # Following -------------------------------------------------------------------------------

    def _follow_edge(self, rim: Rim) -> ContourPoint | None:
        """Update the current edge, and detect a corner or the closed contour."""
        edge = fit_edge(self._current_edge_points(rim), self._out, EDGE_REACH)
        if edge is not None:
            self._set_edge(edge)
            foot = self._progress.position + edge.nearest
            if self._progress.contour_travel <= LEAVE_DISTANCE:
                self._start, self._start_out = foot, self._out
            elif self._progress.contour_travel > 4 * LEAVE_DISTANCE and self._is_at_start(foot):
                self._end("closed")
                return None
        left_corner = self._progress.line_travel >= LEAVE_DISTANCE
        next_edge = self._find_next_edge(rim) if left_corner else None
        turns_in = next_edge is not None and float(next_edge.outward @ self._along) > 0
        reached = next_edge is not None and (
            next_edge.offset <= INSET if turns_in else next_edge.offset >= INSET
        )
        return self._turn_at(next_edge) if self._is_confirmed(reached) and next_edge else None

    def _set_edge(self, edge: RimEdge) -> None:
        """Follow this edge, with the face on the same side as before."""
        side = 1.0 if _is_left(self._along, self._out) else -1.0
        self._edge, self._edge_position, self._out = edge, self._progress.position, edge.outward
        self._along = side * np.array([self._out[1], -self._out[0]])

    def _current_edge_points(self, rim: Rim) -> Rim:
        """Select the rim points near the current edge; another edge may face the same direction."""
        if self._edge is None:
            return rim
        out = self._edge.outward
        offset = self._edge.offset - float((self._progress.position - self._edge_position) @ out)
        return rim.select(np.abs(rim.points @ out - offset) < SAME_EDGE)

    def _is_at_start(self, foot: NDArray[np.float64]) -> bool:
        """Return whether the contour started here, on the same of two edges that meet."""
        same = float(self._out @ self._start_out) > math.cos(MIN_CORNER_ANGLE)
        return same and math.dist(foot, self._start) < CLOSED_DISTANCE

    def _find_next_edge(self, rim: Rim) -> RimEdge | None:
        """Find the next edge of the face, which turns inwards beyond a corner, or outwards."""
        edge = self._edge
        if edge is None:
            return None
        beside = rim.points @ edge.outward - edge.offset
        turned = rim.outward @ self._along
        facing = rim.outward @ edge.outward < math.cos(MIN_CORNER_ANGLE)
        ahead = rim.points @ self._along > -INSET
        inwards = facing & (turned > MIN_TURN) & (beside < -OFF_EDGE) & ahead
        outwards = facing & (turned < -MIN_TURN) & (beside > OFF_EDGE)
        mask = inwards if np.count_nonzero(inwards) >= np.count_nonzero(outwards) else outwards
        return _if_straight(fit_longest_edge(rim.select(mask)))

    def _turn_at(self, next_edge: RimEdge) -> ContourPoint | None:
        """Follow the next edge from the corner on, unless the contour is closed there."""
        edge = self._edge
        if edge is None:
            return None
        place, direction = intersect_edges(edge, next_edge), self._direction()
        corner = self._progress.position + place
        if self._first_corner is None:
            self._first_corner = corner
        elif (
            self._progress.contour_travel > 4 * LEAVE_DISTANCE
            and math.dist(corner, self._first_corner) < SAME_EDGE
        ):
            self._end("closed")
            return None
        kind = "corner" if float(next_edge.outward @ self._along) > 0 else "inner_corner"
        self._set_edge(next_edge)
        self._start_line()
        return ContourPoint(kind, np.append(place, 0.0), direction)

    def _follow_ridge(self, features: ContactFeatures, image: TactileImage) -> ContourPoint | None:
        """Update the direction of the ridge, and detect its end."""
        if features.confidence >= MIN_LINE_CONFIDENCE:
            axis = np.array([math.cos(features.orientation), math.sin(features.orientation)])
            axis = axis if float(axis @ self._along) >= 0 else -axis
            if float(axis @ self._along) > math.cos(MAX_RIDGE_BEND):
                self._along, self._out = axis, np.array([-axis[1], axis[0]])
        end = find_line_end(image, self._along)
        if not self._is_confirmed(self._progress.line_travel > LEAVE_DISTANCE and end < INSET):
            return None
        place = end * self._along + self._line_offset(features) * self._out
        direction = self._direction()
        self._along, self._ends = -self._along, self._ends + 1
        self._start_line()
        if self._ends == 2:
            self._end("done")
        return ContourPoint("end", np.append(place, 0.0), direction)

    def _start_line(self) -> None:
        self.state = "follow"
        self._progress.line_travel = 0.0
        self._confirmed = 0

    def _line_offset(self, features: ContactFeatures) -> float:
        """Return the distance from the pad's middle to the line, m, towards the face's end."""
        if self._edge is None:
            return float(features.centre[:2] @ self._out)
        return self._edge.offset

    def _velocity(self, features: ContactFeatures) -> NDArray[np.float64]:
        """Compute the velocity over the surface, (2,), m/s."""
        speed = self.options.speed
        if self.state == "seek":
            weave = WEAVE_ANGLE * math.sin(2.0 * math.pi * self._progress.travel / WEAVE_LENGTH)
            angle = self._heading + weave
            return speed * np.array([math.cos(angle), math.sin(angle)])
        inset = 0.0 if self._on_ridge else INSET
        side = min(max(SIDE_GAIN * (self._line_offset(features) - inset), -speed), speed)
        return speed * self._along + side * self._out

    def _is_confirmed(self, detected: bool) -> bool:
        self._confirmed = self._confirmed + 1 if detected else 0
        return self._confirmed >= CONFIRM_CYCLES

    def _direction(self) -> float:
        return math.atan2(self._along[1], self._along[0])

    def _end(self, outcome: ContourOutcome) -> None:
        self.outcome, self.state = outcome, "ended"


def _if_straight(edge: RimEdge | None) -> RimEdge | None:
    """Return the edge if it is long and straight enough."""
    return edge if edge and edge.span >= MIN_EDGE_SPAN and edge.rms <= MAX_EDGE_RMS else None


def _imprint_width(features: ContactFeatures) -> float:
    """Return the width, m, of the rectangle with the imprint's area and confidence.

    Its second moments are L²/12 and W²/12, so W/L = sqrt((1 - c)/(1 + c)).
    """
    ratio = math.sqrt(max(1.0 - features.confidence, 1e-6) / (1.0 + features.confidence))
    return math.sqrt(features.area * ratio)


def _is_left(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Return whether direction b is to the left of direction a."""
    return a[0] * b[1] - a[1] * b[0] >= 0
