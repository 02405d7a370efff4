"""Every choice of the guide that seeks by touch, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eyehand.errors import InputError


@dataclass(frozen=True)
class ContourOptions:
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
    """Confidence of the orientation from which a narrow imprint is a ridge."""
    cycles: int = 5
    """Cycles in a row that a line, or its end, must be felt."""
    ridge_width: float = 0.02
    """Width of an imprint up to which it is a ridge and not a face's edge, m."""
    inset: float = 0.008
    """How far inside the face the pad's middle is kept while following, m: nearer to the rim the
    imprint is smaller, farther from it the pad feels less of what lies ahead."""
    side_gain: float = 4.0
    """How fast a wrong distance to the line is taken away, 1/s."""
    reach: float = 0.02
    """Way along an edge whose rim steers the pad, m: longer is calmer, shorter follows bends."""
    edge_rms: float = 0.0007
    """Largest distance of a straight edge's rim from its line, rms, m."""
    edge_span: float = 0.015
    """Least length of rim that is an edge, m."""
    corner: float = 0.7
    """Least angle by which the next edge turns at a corner, rad: less is a bend."""
    close: float = 0.004
    """Distance from where following began that is back there, m."""
    leave: float = 0.02
    """Way along a new line, after a corner or an end, in which no other is looked for, m."""
    spots: int = 16
    """Spots after which the guide is done."""
    travel: float = 1.2
    """Longest way in all, m."""
    seconds: float = 60.0
    """Longest time in all, s."""
    lost_seconds: float = 3.0
    """Longest time without contact, s: a search may bring it back."""
    blocked_seconds: float = 1.0
    """Longest time in which the pad moves at less than a quarter of the speed, s."""

    def __post_init__(self) -> None:
        if not 0 < self.line_confidence <= 1:
            raise InputError(f"line_confidence must be in (0, 1], got {self.line_confidence}")
        for name in ("speed", "weave_length", "seconds", "travel", "reach"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"{name} must be finite and > 0, got {getattr(self, name)}")
        if self.cycles < 1 or self.spots < 1:
            raise InputError(f"cycles and spots must be >= 1, got {self.cycles}, {self.spots}")
