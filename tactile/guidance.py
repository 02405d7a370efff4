"""An outer motion computed from touch: it seeks ridges and edges, and follows them to corners."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from eyehand.errors import InputError

from .area_slope import AreaSlope

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .features import ContactFeatures

GuideState = Literal["seek", "follow", "ended"]
"""seek: over the surface, to where the imprint shrinks; follow: along a line; ended: rest."""

SpotKind = Literal["ridge", "edge", "corner", "end"]
"""ridge: a narrow line; edge: where a face ends; corner: where an edge does; end: a ridge's."""

GuideOutcome = Literal["done", "nothing_found", "lost", "out_of_time"]
"""done: as many spots as asked for, or both ends of a ridge; nothing_found: the travel was used up
in seeking; lost: no contact for too long; out_of_time: the travel was used up in following, or
the time."""


@dataclass(frozen=True)
class Spot:
    """Something worth knowing, where it was noticed."""

    kind: SpotKind
    """What it is."""
    place: NDArray[np.float64]
    """Where, (3,), m, in the sensor's frame of that cycle."""
    direction: float
    """Direction along the line there, rad, in the sensor's frame."""


@dataclass(frozen=True, slots=True)
class Guidance:
    """What to do in this cycle, and what was noticed."""

    twist: NDArray[np.float64]
    """Outer motion [v; ω], (6,), in the sensor's frame."""
    state: GuideState
    """Where the guide is."""
    spot: Spot | None
    """Set in the one cycle in which something was noticed."""
    outcome: GuideOutcome | None
    """Set once the state is ``ended``."""


@dataclass(frozen=True)
class GuideOptions:
    """How the guide moves and when it stops.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    heading: float = 0.0
    """Direction of the first move over the surface, rad, in the sensor's frame."""
    speed: float = 0.03
    """Speed over the surface, m/s: slower places spots better."""
    weave: float = 0.6
    """Largest angle by which the way swings to feel where the imprint shrinks, rad; 0 goes
    straight."""
    weave_length: float = 0.05
    """Way of one such swing, m."""
    steer: float = 1.5
    """How fast the heading turns to where the imprint shrinks, rad/s."""
    line_confidence: float = 0.5
    """Confidence of the orientation from which an imprint is a line: half a face under a square
    pad has 0.6."""
    cycles: int = 5
    """Cycles in a row that a line, or its end, must be felt."""
    ridge_width: float = 0.02
    """Width of an imprint up to which it is a ridge and not a face's edge, m."""
    inset: float = 0.006
    """How far inside the imprint the pad's middle is kept while following, m."""
    side_gain: float = 4.0
    """How fast a wrong distance to the line is taken away, 1/s."""
    leave: float = 0.01
    """Way along a new line in which no end is looked for, m."""
    pad_half_size: float = 0.04
    """Half the pad's side, m: a face that ends under the pad reaches to its border elsewhere."""
    spots: int = 8
    """Spots after which the guide is done."""
    travel: float = 1.0
    """Longest way in all, m."""
    seconds: float = 60.0
    """Longest time in all, s."""
    lost_seconds: float = 3.0
    """Longest time without contact, s: a search may bring it back."""

    def __post_init__(self) -> None:
        if not 0 < self.line_confidence <= 1:
            raise InputError(f"line_confidence must be in (0, 1], got {self.line_confidence}")
        for name in ("speed", "weave_length", "seconds", "travel", "pad_half_size"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"{name} must be finite and > 0, got {getattr(self, name)}")
        if self.cycles < 1 or self.spots < 1:
            raise InputError(f"cycles and spots must be >= 1, got {self.cycles}, {self.spots}")


class TouchGuide:
    """Seek, follow, turn at corners, and stop; the servo presses meanwhile (switches ``PRESS``).

    At constant pressure a small imprint is a curved place: so it seeks where the imprint shrinks.
    A long one is a ridge, or a face that ends under the pad. Length and width follow from area and
    confidence as those of a rectangle. A wide one reaches from the face's edge to the pad's border,
    so the centre of pressure tells where the edge is; it is kept under the pad's middle. That holds
    best while the line runs along one of the pad's axes: let the servo turn the pad, or begin so.

    Parameters
    ----------
    options
        Speeds, thresholds, bounds.
    """

    def __init__(self, options: GuideOptions | None = None) -> None:
        self.options = options or GuideOptions()
        o = self.options
        self.state: GuideState = "seek"
        self.outcome: GuideOutcome | None = None
        self.found = 0
        """Spots so far."""
        self._heading = o.heading
        self._out = np.array([math.cos(o.heading), math.sin(o.heading)])
        self._along = np.array([-self._out[1], self._out[0]])
        self._slope = AreaSlope(o.weave_length)
        self._way = self._followed = self._time = self._lost_for = 0.0
        self._in_a_row = self._ends = 0
        self._width = 0.0

    def step(self, features: ContactFeatures, dt: float) -> Guidance:
        """Give the outer motion of this cycle.

        Parameters
        ----------
        features
            What the pad feels.
        dt
            Time since the last cycle, s.
        """
        o = self.options
        self._time += dt
        self._lost_for = 0.0 if features else self._lost_for + dt
        if self.outcome is None:
            if self._lost_for > o.lost_seconds:
                self._end("lost")
            elif self._time > o.seconds:
                self._end("out_of_time")
            elif self._way > o.travel:
                self._end("nothing_found" if self.state == "seek" else "out_of_time")
        if self.state == "ended" or not features:
            return Guidance(np.zeros(6), self.state, None, self.outcome)
        spot = self._seek(features, dt) if self.state == "seek" else self._follow(features)
        if spot is not None:
            self.found += 1
            if self.outcome is None and self.found >= o.spots:
                self._end("done")
        twist = np.zeros(6)
        if self.state != "ended":
            twist[:2] = self._velocity(features)
            self._way += o.speed * dt
            self._followed += o.speed * dt
            self._slope.move(twist[:2] * dt)
        return Guidance(twist, self.state, spot, self.outcome)

    # Seeking ---------------------------------------------------------------------------------

    def _seek(self, features, dt) -> Spot | None:
        o = self.options
        slope = self._slope.update(features.area)
        if slope is not None:
            want = math.atan2(-slope[1], -slope[0])
            gap = (want - self._heading + math.pi) % (2.0 * math.pi) - math.pi
            self._heading += max(-o.steer * dt, min(o.steer * dt, gap))
        if not self._holds(features.confidence >= o.line_confidence):
            return None
        axis = np.array([math.cos(features.orientation), math.sin(features.orientation)])
        across = np.array([-axis[1], axis[0]])
        heading = np.array([math.cos(self._heading), math.sin(self._heading)])
        # The face ends on the side where the imprint is not, and where the way led.
        side = -float(features.centre[:2] @ across) + 1e-3 * float(heading @ across)
        self._out = across if side >= 0 else -across
        self._along = axis if float(axis @ heading) >= 0 else -axis
        _, self._width = _sides(features)
        self._start_line()
        kind = "ridge" if self._narrow else "edge"
        return Spot(kind, self._point(0.0, self._rim(features)), _angle(self._along))

    # Following -------------------------------------------------------------------------------

    def _follow(self, features) -> Spot | None:
        o = self.options
        if features.confidence >= o.line_confidence:
            axis = np.array([math.cos(features.orientation), math.sin(features.orientation)])
            axis = axis if float(axis @ self._along) >= 0 else -axis
            # A line that bends turns slowly; what jumps is another axis of a square imprint.
            if float(axis @ self._along) > math.cos(math.radians(30.0)):
                self._along = axis
                across = np.array([-axis[1], axis[0]])
                self._out = across if float(across @ self._out) >= 0 else -across
            _, self._width = _sides(features)
        over = self._followed > o.leave and self._reach(features) < o.inset
        return self._turn_at(features) if self._holds(over) else None

    def _turn_at(self, features) -> Spot:
        """Where the line ends: go on along the face's next edge, or back along a ridge."""
        place = self._point(self._reach(features), self._rim(features))
        direction = _angle(self._along)
        narrow = self._narrow
        if narrow:
            self._along, self._ends = -self._along, self._ends + 1
        else:
            self._along, self._out = -self._out, self._along
        self._start_line()
        if narrow and self._ends == 2:
            self._end("done")
        return Spot("end" if narrow else "corner", place, direction)

    def _start_line(self) -> None:
        self.state = "follow"
        self._followed = 0.0
        self._in_a_row = 0

    def _reach(self, features) -> float:
        """How far the imprint reaches along the line from the pad's middle, m."""
        middle = float(features.centre[:2] @ self._along)
        back = self.options.pad_half_size
        if not self._narrow:
            return 2.0 * middle + back
        # A ridge comes from the pad's border, unless it is shorter than that.
        back /= max(abs(self._along[0]), abs(self._along[1]))
        short = 0.5 * features.area / max(self._width, 1e-6)
        return min(2.0 * middle + back, middle + short)

    def _rim(self, features) -> float:
        """How far it reaches across; of a ridge, where its middle is."""
        middle = float(features.centre[:2] @ self._out)
        return middle if self._narrow else 2.0 * middle + self.options.pad_half_size

    @property
    def _narrow(self) -> bool:
        return self._width <= self.options.ridge_width

    def _velocity(self, features):
        o = self.options
        if self.state == "seek":
            swing = o.weave * math.sin(2.0 * math.pi * self._way / o.weave_length)
            angle = self._heading + swing
            return o.speed * np.array([math.cos(angle), math.sin(angle)])
        inset = 0.0 if self._narrow else o.inset
        side = min(max(o.side_gain * (self._rim(features) - inset), -o.speed), o.speed)
        return o.speed * self._along + side * self._out

    def _holds(self, now: bool) -> bool:
        self._in_a_row = self._in_a_row + 1 if now else 0
        return self._in_a_row >= self.options.cycles

    def _point(self, along: float, out: float):
        return np.append(along * self._along + out * self._out, 0.0)

    def _end(self, outcome: GuideOutcome) -> None:
        self.outcome, self.state = outcome, "ended"


def _sides(features: ContactFeatures) -> tuple[float, float]:
    """Length and width, m, of the rectangle with that area and confidence.

    Its second moments are L²/12 and W²/12, so W/L = sqrt((1 - c)/(1 + c)).
    """
    ratio = math.sqrt(max(1.0 - features.confidence, 1e-6) / (1.0 + features.confidence))
    return math.sqrt(features.area / ratio), math.sqrt(features.area * ratio)


def _angle(direction) -> float:
    return math.atan2(direction[1], direction[0])
