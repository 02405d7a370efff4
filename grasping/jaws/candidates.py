"""Candidate poses of the jaws around a solid: closing axes, approaches, depths and offsets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from ..hands import ParallelHand
    from .options import JawOptions

ROUND_EXPONENT = 0.5
"""A section with a larger exponent is round enough to be gripped between its axes."""
ROUND_RATIO = 0.6
"""Minimum ratio of the semi-axes of such a section. A flat ellipse turns between the pads."""
ROUND_STEPS = 12
"""Closing axes over half a turn around a round section."""
MAX_UPRIGHT = 0.8
"""Maximum cosine between the closing axis and the vertical. A finger cannot reach below an object
that stands on the support."""
SAME_AXIS = np.cos(np.radians(15.0))
"""Cosine from which two closing axes count as the same."""
MIN_LEVEL = 0.5
"""Minimum sine between an axis of a solid and the vertical, for a level axis across it."""
SHIFTS = (0.0, -0.45, 0.45)
"""Offsets from the middle across closing axis and approach, as shares of the half length."""
MIN_SHIFTED = 0.012
"""Minimum offset, m. Smaller ones are no other grasp."""
PALM_GAP = 0.003
"""Minimum gap between the object and what lies between the fingers behind it, m."""
DEPTH_STEP = 0.008
"""Minimum difference between two depths, m."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Poses of the tool frame as arrays; the same place in each array is one candidate."""

    rotation: NDArray[np.float64]
    """Rotations, (n, 3, 3), columns x, y, z of the tool frame."""
    tip: NDArray[np.float64]
    """Origins of the tool frame, (n, 3), m."""
    object: NDArray[np.int64]
    """Index of the object, (n,)."""
    reach: NDArray[np.float64]
    """Distance from the origin along the closing axis up to which the object's surface lies between
    the pads, (n,), m: infinite, or that of a wall that is gripped at its rim."""

    def __len__(self) -> int:
        return len(self.tip)

    def take(self, index: NDArray | slice) -> Candidates:
        """Return a part of the candidates."""
        return Candidates(
            self.rotation[index], self.tip[index], self.object[index], self.reach[index]
        )

    def at(self, tip: NDArray[np.float64]) -> Candidates:
        """Return the candidates with other origins (n, 3), m."""
        return replace(self, tip=tip)

    @classmethod
    def join(cls, parts: list[Candidates]) -> Candidates:
        """Return all candidates of several sets."""
        if not parts:
            return cls(np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros(0))
        return cls(
            np.concatenate([part.rotation for part in parts]),
            np.concatenate([part.tip for part in parts]),
            np.concatenate([part.object for part in parts]),
            np.concatenate([part.reach for part in parts]),
        )


def solid_candidates(
    solid: Superquadric,
    number: int,
    hand: ParallelHand,
    up: NDArray[np.float64],
    options: JawOptions,
) -> Candidates:
    """List the poses from which the jaws may close around a solid.

    Parameters
    ----------
    solid
        The solid, in the scene's frame.
    number
        Index of its object.
    hand
        The hand.
    up
        Unit direction up, (3,).
    options
        Options; `max_tilt` bounds the approaches.
    """
    closing = closing_axes(solid, up)
    closing = closing[2.0 * _half(solid, closing) <= hand.stroke]
    if len(closing) == 0:
        return Candidates.join([])
    axes, approaches = _approaches(closing, up, options)
    y = np.cross(approaches, axes)
    depths = _depths(_half(solid, approaches), hand)
    sides = _half(solid, y)[:, None] * np.array(SHIFTS)
    sides[:, 1:][np.abs(sides[:, 1:]) < MIN_SHIFTED] = np.nan
    # All combinations of a depth and an offset, (poses, 3, 3).
    tips = (
        solid.centre
        + depths[:, :, None, None] * approaches[:, None, None]
        + sides[:, None, :, None] * y[:, None, None]
    )
    pose, depth, side = np.nonzero(np.isfinite(tips).all(axis=3))
    rotation = np.stack([axes, y, approaches], axis=2)
    return Candidates(
        np.ascontiguousarray(rotation[pose]),
        tips[pose, depth, side],
        np.full(len(pose), number, dtype=np.int64),
        np.full(len(pose), np.inf),
    )


def narrowest_width(solids: Sequence[Superquadric], up: NDArray[np.float64]) -> float:
    """Return the smallest width of solids along their closing axes, m; infinite without an axis."""
    widths = [2.0 * _half(solid, closing_axes(solid, up)) for solid in solids]
    return float(np.concatenate(widths).min(initial=np.inf))


def closing_axes(solid: Superquadric, up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit closing axes of a solid, (k, 3): its axes, and those of round sections.

    Axes that are nearly vertical are left out. A solid whose axes are tilted also has the level
    axes across them: a low object allows only those, because a finger needs room below a tilted
    one.
    """
    frame = solid.rotation
    e1, e2 = solid.exponents
    a = solid.semi_axes
    axes = [frame[:, 0], frame[:, 1], frame[:, 2]]
    for first, second, exponent in ((0, 1, e2), (1, 2, e1), (2, 0, e1)):
        ratio = min(a[first], a[second]) / max(a[first], a[second])
        if exponent >= ROUND_EXPONENT and ratio >= ROUND_RATIO:
            angles = np.arange(1, ROUND_STEPS) * np.pi / ROUND_STEPS
            angles = angles[np.abs(angles - np.pi / 2) > 1e-6]
            axes += [
                np.cos(angle) * frame[:, first] + np.sin(angle) * frame[:, second]
                for angle in angles
            ]
    level = np.cross(up, frame.T)
    sine = np.linalg.norm(level, axis=1)
    for axis, length in zip(level, sine, strict=True):
        if length >= MIN_LEVEL and np.abs(axes @ axis).max() < SAME_AXIS * length:
            axes.append(axis / length)
    found = np.array(axes)
    return found[np.abs(found @ up) <= MAX_UPRIGHT]


def _approaches(
    closing: NDArray[np.float64], up: NDArray[np.float64], options: JawOptions
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return pairs of a closing axis and an approach across it, (m, 3) each."""
    first = (closing @ up)[:, None] * closing - up
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(closing, first)
    angle = np.arange(options.approaches) * 2.0 * np.pi / options.approaches
    found = (
        np.cos(angle)[None, :, None] * first[:, None]
        + np.sin(angle)[None, :, None] * second[:, None]
    )
    axes = np.broadcast_to(closing[:, None], found.shape)
    allowed = -found @ up >= np.cos(options.max_tilt) - 1e-9
    return axes[allowed], found[allowed]


def _depths(half: NDArray[np.float64], hand: ParallelHand) -> NDArray[np.float64]:
    """Return depths (m, 4) of the fingertips beyond the centre of a solid, m; NaN for none.

    The pads are centred on it, the fingertips reach its far side, the pads just cover its near
    side, or the object reaches the palm.

    Parameters
    ----------
    half
        Half of the solid's extent along each approach, (m,), m.
    hand
        The hand.
    """
    deepest = hand.finger_depth - PALM_GAP - half
    wanted = np.stack(
        [
            np.minimum(deepest, 0.5 * hand.pad_height),
            np.minimum(deepest, half),
            np.minimum(deepest, hand.pad_height - half),
            deepest,
        ],
        axis=1,
    )
    for k in (1, 2, 3):
        near = np.nanmin(np.abs(wanted[:, :k] - wanted[:, k : k + 1]), axis=1) < DEPTH_STEP
        wanted[near, k] = np.nan
    return wanted


def _half(solid: Superquadric, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return half of the solid's extent along directions (m, 3), (m,), m."""
    if not any(solid.taper):
        return solid.support(directions) - directions @ solid.centre
    both = solid.support(np.concatenate([directions, -directions]))
    return 0.5 * both.reshape(2, -1).sum(axis=0)
