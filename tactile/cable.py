"""Compute the twist that follows a cable, from a parabola through its imprint (section 4.4)."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from eyehand.errors import InputError

from .image import TactileImage

OFFSET_GAIN = 16.0
"""Maximum gain of the offset across the line, 1/s."""
ANGLE_GAIN = 10.0
"""Maximum gain of the heading error, 1/s."""
STABLE_PRODUCT = 0.5
"""Maximum product of a gain and the lead time. A loop with this delay oscillates from 1.6 on."""
IMPRINT_PRESSURE = 20.0
"""Pressure above which a tactel belongs to the imprint, Pa; just above the noise."""
FIT_REACH = 0.025
"""Distance along the line from the pad's middle up to which the imprint is fitted, m. A longer one
reduces noise, a shorter one follows lines with changing curvature."""
BEND_WINDOW = 3
"""Number of averaged readings of the curvature, the noisiest of the three parameters."""
MIN_SHARE = 0.25
"""Minimum pressure of a tactel of the imprint as a share of the highest one. After the cable has
left a tactel, foam with hysteresis still reads 10 to 20 %."""
MIN_TACTELS = 8
"""Minimum number of tactels of a line."""
MAX_HEADING_ERROR = 0.8
"""Heading error above which the pad turns without moving on, rad."""
MIN_AHEAD = 0.006
"""Length of the imprint ahead of the pad's middle below which the line ends, m."""
MAX_SIDE_SPEED = 0.1
"""Speed limit across the line, m/s."""
MAX_TURN_SPEED = 2.0
"""Speed limit of turning, rad/s."""


@dataclass(frozen=True)
class LineFit:
    """The imprint of a line as a parabola w(u); false if there is no line.

    The u-axis is a given direction in the sensor's xy-plane, and the w-axis is 90° to its left.
    """

    angle: float
    """Direction of the u-axis, rad."""
    offset: float = 0.0
    """w at u = 0, m."""
    slope: float = 0.0
    """dw/du at u = 0."""
    bend: float = 0.0
    """Half of d²w/du², 1/m."""
    ahead: float = 0.0
    """Length of the imprint along +u from the pad's middle, m."""
    behind: float = 0.0
    """Length of the imprint along -u, m."""
    tactels: int = 0
    """Number of fitted tactels; 0 without a line."""

    def __bool__(self) -> bool:
        return self.tactels > 0

    def at(self, u: float) -> tuple[float, float]:
        """Return the offset w (m) and the direction (rad, sensor frame) of the line at u (m)."""
        slope = self.slope + 2.0 * self.bend * u
        w = self.offset + self.slope * u + self.bend * u * u
        return w, self.angle + float(np.arctan(slope))


@dataclass(frozen=True)
class CableOptions:
    """Speed of a cable follower, and properties of the pad and the arm.

    Raises
    ------
    InputError
        If a value is not finite, or a value other than `heading` is negative.
    """

    speed: float = 0.05
    """Speed along the line, m/s. Twice the speed at least doubles the path error."""
    heading: float = np.pi / 2
    """Direction of travel along the line in the sensor's frame, rad; default +y, as in Haschke's
    chapter."""
    lead: float = 0.02
    """Delay from reading to motion, s: arm lag plus latency. The line is evaluated where the pad
    will be after it."""

    def __post_init__(self) -> None:
        for name in ("speed", "lead"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"{name} must be finite and >= 0, got {getattr(self, name)}")
        if not np.isfinite(self.heading):
            raise InputError(f"heading must be finite, got {self.heading}")


def fit_line(
    image: TactileImage, orientation: float, threshold: float, reach: float = FIT_REACH
) -> LineFit:
    """Fit a parabola to the imprint of a line.

    It is a least squares fit of all tactels, weighted by pressure. Across a row, that equals a fit
    of the rows' centroids. The centre of pressure of the whole pad would lie inside the bend.

    Parameters
    ----------
    image
        Pressures.
    orientation
        Approximate direction of travel along the line, rad.
    threshold
        Pressure above which a tactel belongs to the imprint, Pa; at least `MIN_SHARE` of the
        highest pressure.
    reach
        Distance along the line from the pad's middle at which the weight falls to zero, m.

    Returns
    -------
    LineFit
        False if too few tactels are touched, or all at the same u.
    """
    out = np.zeros(5)
    tactels = fit_parabola(
        image.pressures,
        image.array.positions,
        float(orientation),
        float(threshold),
        float(reach),
        out,
    )
    if tactels < MIN_TACTELS or not np.isfinite(out[0]):
        return LineFit(orientation)
    offset, slope, bend, ahead, behind = out.tolist()
    return LineFit(orientation, offset, slope, bend, ahead, behind, int(tactels))


class CableFollower:
    """Compute the external twist that follows a line; the servo presses (selection `PRESS`).

    Offset and heading are evaluated where the pad will be when it moves. The curvature there is
    fed forward to the turning speed, so that a bend causes no steady-state error.

    Parameters
    ----------
    options
        Speed, and properties of the pad and the arm.
    """

    def __init__(self, options: CableOptions | None = None) -> None:
        self.options = options or CableOptions()
        self.reset()

    def reset(self) -> None:
        """Clear the line."""
        self._velocity = np.zeros(3)
        self._bends: deque[float] = deque(maxlen=BEND_WINDOW)
        self.line = LineFit(0.0)
        """The fitted imprint of the last step."""

    @property
    def at_end(self) -> bool:
        """Whether the line ends near the pad's middle, or is not detected."""
        return not self.line or self.line.ahead < MIN_AHEAD

    def step(self, image: TactileImage, orientation: float) -> NDArray[np.float64]:
        """Compute the external twist of this cycle.

        Parameters
        ----------
        image
            Pressures.
        orientation
            Long axis of the imprint, rad, modulo π (``ContactFeatures.orientation``).

        Returns
        -------
        ndarray
            (6,), [v; ω] in the sensor's frame, m/s and rad/s; zero without a line.
        """
        o = self.options
        # A line has two directions. The direction of travel is the one nearer to the heading.
        direction = o.heading + _wrap_line_angle(orientation - o.heading)
        self.line = fit_line(image, direction, IMPRINT_PRESSURE)
        if not self.line:
            self._velocity[:] = 0.0
            self._bends.clear()
            return np.zeros(6)
        self._bends.append(self.line.bend)
        self._velocity = self._follow()
        return np.array([self._velocity[0], self._velocity[1], 0.0, 0.0, 0.0, self._velocity[2]])

    def _follow(self) -> NDArray[np.float64]:
        """Compute the velocity (vx, vy, ωz) from pad and line after the lead time."""
        o, line = self.options, self.line
        x, y, turned = self._velocity * o.lead
        c, s = np.cos(line.angle), np.sin(line.angle)
        u, w = c * x + s * y, -s * x + c * y
        offset, direction = line.at(u)
        bend = float(np.mean(self._bends))
        curvature = 2.0 * bend / (1.0 + (line.slope + 2.0 * bend * u) ** 2) ** 1.5
        # The distance to the line is across its direction at u, not across the u-axis.
        error = (offset - w) * np.cos(direction - line.angle)
        heading_error = direction - (o.heading + turned)
        speed = o.speed if abs(heading_error) < MAX_HEADING_ERROR else 0.0
        stable = STABLE_PRODUCT / max(o.lead, 1e-3)
        sideways = np.clip(min(OFFSET_GAIN, stable) * error, -MAX_SIDE_SPEED, MAX_SIDE_SPEED)
        cd, sd = np.cos(direction - turned), np.sin(direction - turned)
        turn = speed * curvature + min(ANGLE_GAIN, stable) * heading_error
        return np.array(
            [
                speed * cd - sideways * sd,
                speed * sd + sideways * cd,
                np.clip(turn, -MAX_TURN_SPEED, MAX_TURN_SPEED),
            ]
        )


@njit(cache=True)
def fit_parabola(pressures, positions, angle, threshold, reach, out):
    """Fill `out` (5,) with offset, slope, bend, and the lengths ahead and behind.

    Returns
    -------
    int
        Number of fitted tactels.
    """
    c, s = np.cos(angle), np.sin(angle)
    touched = 0
    threshold = max(threshold, MIN_SHARE * pressures.max())
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
    """Solve the normal equations of a parabola by Cramer's rule; NaN if they are singular."""
    a, b, c, d, e = m[0], m[1], m[2], m[3], m[4]
    first = c * e - d * d
    second = c * d - b * e
    third = b * d - c * c
    determinant = a * first + b * second + c * third
    # Below this share of the diagonal's product, all tactels are in one or two rows.
    if abs(determinant) <= 1e-6 * a * c * e:
        out[0] = np.nan
        return
    x, y, z = right[0], right[1], right[2]
    out[0] = (first * x + second * y + third * z) / determinant
    out[1] = (second * x + (a * e - c * c) * y + (b * c - a * d) * z) / determinant
    out[2] = (third * x + (b * c - a * d) * y + (a * c - b * b) * z) / determinant


def _wrap_line_angle(angle: float) -> float:
    """Return the angle modulo π, in (-π/2, π/2]."""
    return float(angle - np.pi * np.ceil(angle / np.pi - 0.5))
