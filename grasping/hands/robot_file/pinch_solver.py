"""Joint values that place the tips of two fingers at a distance from each other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from scipy.optimize import least_squares

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .coupled_joints import JointCouplings
    from .posing import Posing

PLACE_WEIGHT, DRIFT_WEIGHT = 300.0, 100.0
"""Weights of the distance between the tips, and of the way of their middle, 1/m."""
LEAN_WEIGHT, CROSS_WEIGHT, HOME_WEIGHT, STEP_WEIGHT = 3.0, 1.5, 0.2, 0.2
"""Weights of fingertips that lean along the closing axis, of tips that cross, of the distance of
joints from the middle of their ranges, and from the posture before, 1/rad."""
MAX_DRIFT = 0.012
"""Maximum way of the middle between the tips across the approach, m."""
MAX_PLACE_ERROR = 1.5e-3
"""Maximum error of a fingertip's place, m."""
MAX_LEAN = np.sin(np.deg2rad(35.0))
"""Sine of the maximum angle by which a fingertip leans along the closing axis."""
TIP_LENGTH = 0.02
"""Length of a fingertip that touches objects, m."""


@dataclass(frozen=True, eq=False)
class Finger:
    """A finger that pinches."""

    links: list[int]
    joints: list[int]
    tip: int
    """Outermost link with a shape."""
    centre: NDArray[np.float64]
    """Middle of the fingertip in the frame of its body, (3,), m."""
    base: NDArray[np.float64]
    """A point behind it on the fingertip's axis, (3,), m."""


@dataclass(frozen=True, eq=False)
class Pinch:
    """Two fingers whose tips are placed at a distance from each other."""

    posing: Posing
    fingers: tuple[Finger, Finger]
    posture: NDArray[np.float64]
    """Posture of the hand, (nq,); the joints of both fingers change."""
    couplings: JointCouplings
    """How joints follow each other."""
    radius: float
    """Half of the thickness of both fingertips, m."""

    @cached_property
    def joints(self) -> list[int]:
        """The joints of both fingers that follow no other one."""
        mine = self.fingers[0].joints + self.fingers[1].joints
        return [joint for joint in mine if joint in self.couplings.free]

    @cached_property
    def places(self) -> NDArray[np.int64]:
        """Places of the joints in the posture."""
        return self.posing.model.jnt_qposadr[self.joints].astype(np.int64)

    @cached_property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return least and greatest values of the joints."""
        low, high = self.posing.model.jnt_range[self.joints].T
        return low, high

    def at(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the posture of the hand at values of the free joints, (nq,)."""
        self.posture[self.places] = values
        self.couplings.complete(self.posing.model, self.posture)
        return self.posture

    def points(self, values: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Return middle and base of both fingertips at joint values, (3,) each, m."""
        self.posing.pose(self.at(values))
        data = self.posing.data
        found = []
        for finger in self.fingers:
            turn, at = data.xmat[finger.tip].reshape(3, 3), data.xpos[finger.tip]
            found += [turn @ finger.centre + at, turn @ finger.base + at]
        return found

    def residuals(self, values, gap, axis, before, middle) -> NDArray[np.float64]:
        """Return the weighted errors of joint values; see :meth:`solved`."""
        a, a0, b, b0 = self.points(values)
        apart = b - a
        along = _unit(apart) if axis is None else axis
        leans = [(a - a0) @ along / TIP_LENGTH, (b - b0) @ along / TIP_LENGTH]
        drift = np.zeros(3) if middle is None else 0.5 * (a + b) - middle
        return np.concatenate(
            [
                PLACE_WEIGHT * (apart - (gap + self.radius) * along),
                DRIFT_WEIGHT * drift,
                LEAN_WEIGHT * np.array(leans),
                CROSS_WEIGHT * ((a - a0) - (b - b0)) / TIP_LENGTH,
                HOME_WEIGHT * (values - np.mean(self.bounds, axis=0)),
                STEP_WEIGHT * (values - before),
            ]
        )

    def solved(self, gap, axis, before, middle):
        """Place the tips at a gap along an axis, both sides of a middle point.

        Returns the joint values, whether they are good, the axis and the middle. None as axis or
        middle leaves it free.
        """
        low, high = self.bounds
        found = least_squares(
            cast("Any", self.residuals),
            np.clip(before, low + 1e-4, high - 1e-4),
            bounds=(low, high),
            args=(gap, axis, before, middle),
            max_nfev=60,
        )
        a, a0, b, b0 = self.points(found.x)
        along = _unit(b - a)
        line = along if axis is None else axis
        error = np.linalg.norm(b - a - (gap + self.radius) * line)
        leans = np.abs([(a - a0) @ line, (b - b0) @ line]) / TIP_LENGTH
        way = np.zeros(3) if middle is None else 0.5 * (a + b) - middle
        # Along the approach the tips may move: that is the advance of the tips.
        drift = np.linalg.norm(np.cross(way, _unit((a - a0) + (b - b0))))
        good = error < MAX_PLACE_ERROR and leans.max() < MAX_LEAN and drift < MAX_DRIFT
        return found.x, bool(good), along, 0.5 * (a + b)


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / max(float(np.linalg.norm(vector)), 1e-9)
