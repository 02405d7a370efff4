"""Follow a line that bends: from the whole imprint, ahead of what the pad does (section 4.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .image import TactileImage


@dataclass(frozen=True)
class LineFit:
    """The line's imprint as a parabola in a frame that is turned to it; false without a line."""

    angle: float
    """Direction of that frame's u-axis in the sensor's xy-plane, rad."""
    offset: float
    """Way w across, at u = 0, m; w is u turned by +90°."""
    slope: float
    """dw/du at u = 0."""
    bend: float
    """Half of d²w/du², 1/m."""
    ahead: float
    """How far the imprint reaches along +u from the pad's middle, m."""
    behind: float
    """How far along -u, m."""
    touched: int
    """Tactels used; 0 where there is no line."""

    def __bool__(self) -> bool:
        return self.touched > 0

    def at(self, u: float) -> tuple[float, float, float]:
        """Give the way across (m), the direction (rad, sensor frame) and curvature (1/m) at u."""
        slope = self.slope + 2.0 * self.bend * u
        curvature = 2.0 * self.bend / (1.0 + slope * slope) ** 1.5
        w = self.offset + self.slope * u + self.bend * u * u
        return w, self.angle + float(np.arctan(slope)), curvature


@dataclass(frozen=True)
class CableOptions:
    """How a line is followed.

    Raises
    ------
    InputError
        If a value is out of its range.
    """

    threshold: float = 20.0
    """Pressure from which a tactel is part of the imprint, Pa, just above the noise."""
    heading: float = np.pi / 2
    """Direction of travel along the line in the sensor's frame, rad; +y as in the chapter."""
    speed: float = 0.05
    """Speed along the line, m/s: twice as fast doubles the path error or more."""
    offset_gain: float = 16.0
    """How fast an offset across is taken away, 1/s."""
    angle_gain: float = 10.0
    """How fast a wrong heading is taken away, 1/s."""
    lead: float = 0.02
    """Time by which motion follows the reading, s: arm lag plus waiting. The line is looked at
    where the pad will then be."""
    reach: float = 0.025
    """Way along the line, to either side of the middle, whose imprint is fitted, m: longer is
    calmer, shorter follows lines whose curvature changes."""
    bend_window: int = 3
    """Readings over which the curvature is averaged: it is the noisiest of the three."""
    min_tactels: int = 8
    """Tactels that make a line."""
    steep: float = 0.8
    """Heading error beyond which the pad turns and does not go on, rad."""
    end_reach: float = 0.006
    """How far the imprint must reach ahead of the middle, m: else the line ends."""
    slide_speed: float = 0.1
    """Fastest motion across, m/s."""
    turn_speed: float = 2.0
    """Fastest turning, rad/s."""

    def __post_init__(self) -> None:
        if self.min_tactels < 4 or self.bend_window < 1:
            raise InputError(
                "a line needs min_tactels >= 4 tactels and bend_window >= 1, got "
                f"{self.min_tactels} and {self.bend_window}"
            )
        for name in ("threshold", "speed", "offset_gain", "angle_gain", "lead", "steep", "reach"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"{name} must be finite and >= 0, got {getattr(self, name)}")


def course(
    image: TactileImage,
    orientation: float,
    threshold: float,
    min_tactels: int = 8,
    reach: float = 0.025,
) -> LineFit:
    """Fit a parabola to the imprint of a line.

    Least squares of all tactels, weighted by their pressure: across a row that is the same as
    fitting the rows' centroids. The whole pad's centre of pressure would lie inside the bend.

    Parameters
    ----------
    image
        Pressures.
    orientation
        Rough direction in which to go along the line, rad: of the moments, turned to the side of
        the heading.
    threshold
        Pressure from which a tactel counts, Pa.
    min_tactels
        Tactels that a line needs.
    reach
        Way to either side of the middle that counts, m; less towards its ends.

    Returns
    -------
    LineFit
        False if too few tactels are touched, or all in one place.
    """
    out = np.zeros(6)
    touched = fit_course(
        image.pressures,
        image.array.positions,
        float(orientation),
        float(threshold),
        float(reach),
        out,
    )
    if touched < min_tactels or not np.isfinite(out[0]):
        return LineFit(orientation, 0.0, 0.0, 0.0, 0.0, 0.0, 0)
    offset, slope, bend, ahead, behind = out[:5].tolist()
    return LineFit(orientation, offset, slope, bend, ahead, behind, int(touched))


class CableFollower:
    """Give the outer motion that follows a line; the servo only presses (switches ``PRESS``).

    Offset and heading are taken where the pad will be when it moves, and the curvature there is
    fed forward as a turning speed, so that a bend makes no lasting error.

    Parameters
    ----------
    options
        Speed and gains.
    """

    def __init__(self, options: CableOptions | None = None) -> None:
        self.options = options or CableOptions()
        self.reset()

    def reset(self) -> None:
        """Forget the line."""
        self._twist = np.zeros(3)
        self._bends: list[float] = []
        self.course = LineFit(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0)
        """The imprint as of the last step."""

    @property
    def at_end(self) -> bool:
        """Whether the line ends before the pad's middle, or is not felt."""
        return not self.course or self.course.ahead < self.options.end_reach

    def step(self, image: TactileImage, orientation: float) -> NDArray[np.float64]:
        """Give the outer motion of this cycle.

        Parameters
        ----------
        image
            Pressures.
        orientation
            Long axis of the imprint, rad, modulo π (``ContactFeatures.orientation``).

        Returns
        -------
        ndarray
            (6,), [v; ω] in the sensor's frame; zero without a line.
        """
        o = self.options
        # A line has no direction; the way on is the one that is nearer to the heading.
        rough = o.heading + _half_turn(orientation - o.heading)
        self.course = course(image, rough, o.threshold, o.min_tactels, o.reach)
        if not self.course:
            self._twist[:] = 0.0
            self._bends.clear()
            return np.zeros(6)
        if len(self._bends) >= o.bend_window:
            self._bends.pop(0)
        self._bends.append(self.course.bend)
        self._twist = self._follow()
        return np.array([self._twist[0], self._twist[1], 0.0, 0.0, 0.0, self._twist[2]])

    def _follow(self):
        """Velocity (vx, vy, turning) from where the pad and the line will be after the lead."""
        o, line = self.options, self.course
        x, y, turned = self._twist * o.lead
        c, s = np.cos(line.angle), np.sin(line.angle)
        u, w = c * x + s * y, -s * x + c * y
        across, direction, _ = line.at(u)
        bend = float(np.mean(self._bends))
        curvature = 2.0 * bend / (1.0 + (line.slope + 2.0 * bend * u) ** 2) ** 1.5
        # Distance to the line is across its direction there, not across the frame's axis.
        error = (across - w) * np.cos(direction - line.angle)
        heading_error = direction - (o.heading + turned)
        speed = o.speed if abs(heading_error) < o.steep else 0.0
        sideways = np.clip(o.offset_gain * error, -o.slide_speed, o.slide_speed)
        cd, sd = np.cos(direction - turned), np.sin(direction - turned)
        turn = speed * curvature + o.angle_gain * heading_error
        return np.array(
            [
                speed * cd - sideways * sd,
                speed * sd + sideways * cd,
                np.clip(turn, -o.turn_speed, o.turn_speed),
            ]
        )


@njit(cache=True)
def fit_course(pressures, positions, angle, threshold, reach, out):
    """Fill ``out`` with offset, slope, bend, reach ahead and behind; give the tactels used."""
    c, s = np.cos(angle), np.sin(angle)
    touched = 0
    ahead, behind = -np.inf, -np.inf
    moments = np.zeros(5)
    right = np.zeros(3)
    for k in range(pressures.shape[0]):
        weight = pressures[k] - threshold
        if weight <= 0.0:
            continue
        u = c * positions[k, 0] + s * positions[k, 1]
        w = -s * positions[k, 0] + c * positions[k, 1]
        ahead, behind = max(ahead, u), max(behind, -u)
        near = 1.0 - (u / reach) ** 2
        if near <= 0.0:
            continue
        touched += 1
        power = weight * near * near
        for n in range(5):
            moments[n] += power
            if n < 3:
                right[n] += power * w
            power *= u
    if touched > 0:
        _solve(moments, right, out)
        out[3] = ahead
        out[4] = behind
    return touched


@njit(cache=True)
def _solve(m, right, out):
    """Normal equations of a parabola, by Cramer's rule; NaN where they have no solution."""
    a, b, c, d, e = m[0], m[1], m[2], m[3], m[4]
    first = c * e - d * d
    second = c * d - b * e
    third = b * d - c * c
    whole = a * first + b * second + c * third
    # Against the product of the diagonal: below this the tactels are all in two rows or one.
    if abs(whole) <= 1e-6 * a * c * e:
        out[0] = np.nan
        return
    x, y, z = right[0], right[1], right[2]
    out[0] = (first * x + second * y + third * z) / whole
    out[1] = (second * x + (a * e - c * c) * y + (b * c - a * d) * z) / whole
    out[2] = (third * x + (b * c - a * d) * y + (a * c - b * b) * z) / whole


def _half_turn(angle: float) -> float:
    """Angle modulo π, in (-π/2, π/2]."""
    return float(angle - np.pi * np.ceil(angle / np.pi - 0.5))
