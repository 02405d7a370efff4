"""A hand at an object: which way it closes, where it comes from, and how large the object is so."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from .fit_uncertainty import doubt_along

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, Superquadric, SuperquadricFit, SupportPlane

    from .extents import Extents
    from .prototypes import Approach

Freedom = Literal["any_side", "turn", "around", "none"]
"""What the object's symmetry leaves free. any_side: all about a ball's centre; turn: the turn about
the palm's direction; around: the side from which the hand comes, about an upright axis."""

UPRIGHT_COSINE = 0.94
"""Cosine of the largest tilt at which an axis still counts as upright."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class Grip:
    """One way to take hold of a solid; all in the scene's frame."""

    kind: str
    """Solid it is taken for."""
    approach: Approach
    """Whether the palm comes from the side or from above."""
    freedom: Freedom
    """What stays free."""
    closing: NDArray[np.float64]
    """Unit direction (3,) from the fingers to the thumb; but one of many where the turn is free."""
    palm: NDArray[np.float64]
    """Unit direction (3,) in which the palm faces; but one of many where the side is free."""
    axis: NDArray[np.float64]
    """Unit direction (3,) of the row of fingers."""
    up: NDArray[np.float64]
    """Unit up direction (3,)."""
    centre: NDArray[np.float64]
    """Middle of the object as the hand sees it, (3,), m."""
    width: float
    """Caliper width along the closing direction, m."""
    length: float
    """Caliper width along the row of fingers, m."""
    height: float
    """Extent along up, m."""
    half_depth: float
    """Distance of the object's near face from the centre, against the palm's direction, m."""
    rise: float
    """Height of the centre above what the object stands on, m."""
    doubt: float
    """Standard deviation of the width, of unseen sides above all, m."""
    flat: bool = False
    """Whether the face before the palm is about as wide as the object."""
    cone: float = float(np.pi)
    """Largest angle of the hand's way from ``palm``, about what is free, rad."""

    @property
    def top(self) -> float:
        """Height of the object's top above what it stands on, m."""
        return self.rise + 0.5 * self.height


def grips(
    item: SceneObject, solid: Superquadric, extents: Extents, support: SupportPlane | None
) -> tuple[Grip, ...]:
    """Give every way to take hold that differs for a hand, the thumb on either side.

    Parameters
    ----------
    item
        The object; its fit tells how sure its sides are.
    solid, extents
        Its solid and measures.
    support
        Plane below; without one the object's lowest point is taken for the ground.
    """
    up, narrow = extents.up, extents.closing
    across = np.cross(up, narrow)
    ground = _ground(item, solid, support, up)
    ways: list[tuple[Approach, Freedom, NDArray[np.float64], NDArray[np.float64]]] = []
    if extents.round:
        ways.append(("top", "any_side" if solid.kind == "sphere" else "turn", narrow, -up))
        for thumb in (narrow, -narrow):
            ways.append(("side", "around", thumb, across))
    else:
        for closing, along in ((narrow, across), (across, narrow)):
            for thumb in (closing, -closing):
                ways.append(("top", "none", thumb, -up))
                ways.append(("side", "none", thumb, along))
                ways.append(("side", "none", thumb, -along))
    measured = _Measured(item.fit, solid, np.array([narrow, across, up]))
    return tuple(_grip(measured, ground, *way) for way in ways)


def turned(grip: Grip, count: int) -> tuple[Grip, ...]:
    """Give a grip turned about up, so many times over a whole turn, the first one as it is.

    Only for what is round for the hand: widths are taken to stay.
    """
    side = np.cross(grip.up, _flat(grip))
    found = []
    for angle in np.arange(count) * 2.0 * np.pi / count:
        turn = np.cos(angle) * _flat(grip) + np.sin(angle) * side
        if grip.approach == "top":
            found.append(replace(grip, closing=turn, axis=np.cross(grip.palm, turn)))
        else:
            closing = np.cross(grip.axis, turn)
            closing /= np.linalg.norm(closing)
            found.append(replace(grip, palm=turn, closing=closing))
    return tuple(found)


def _flat(grip: Grip) -> NDArray[np.float64]:
    """The direction that turns when a grip turns about up: closing from above, palm from aside."""
    return grip.closing if grip.approach == "top" else grip.palm


class _Measured:
    """A solid's ends and doubts along three axes at right angles, asked for once."""

    def __init__(
        self, fit: SuperquadricFit, solid: Superquadric, axes: NDArray[np.float64]
    ) -> None:
        ends = solid.support(np.vstack([axes, -axes]))
        self.kind, self.own = solid.kind, solid.rotation[:, 2]
        self.axes, self.up = axes, axes[2]
        self.spans = ends[:3] + ends[3:]
        self.middle = 0.5 * (ends[:3] - ends[3:]) @ axes
        self.doubts = [doubt_along(fit, axis) for axis in axes]

    def which(self, direction: NDArray[np.float64]) -> int:
        """Number of the axis that a direction is along."""
        return int(np.argmax(np.abs(self.axes @ direction)))


def _grip(
    solid: _Measured,
    ground: float,
    approach: Approach,
    freedom: Freedom,
    closing: NDArray[np.float64],
    palm: NDArray[np.float64],
) -> Grip:
    axis = np.cross(palm, closing)
    along = solid.which(axis)
    if freedom == "around" and solid.kind != "sphere":
        upright = float(solid.own @ axis)
        if abs(upright) > UPRIGHT_COSINE:
            axis = solid.own * np.sign(upright)
    return Grip(
        kind=solid.kind,
        approach=approach,
        freedom=freedom,
        closing=closing,
        palm=palm,
        axis=axis,
        up=solid.up,
        centre=solid.middle,
        width=float(solid.spans[solid.which(closing)]),
        length=float(solid.spans[along]),
        height=float(solid.spans[2]),
        half_depth=0.5 * float(solid.spans[solid.which(palm)]),
        rise=float(solid.middle @ solid.up) - ground,
        doubt=solid.doubts[solid.which(closing)],
        flat=_flat_face(solid, palm),
    )


def _flat_face(solid: _Measured, palm: NDArray[np.float64]) -> bool:
    if solid.kind == "cylinder":
        return abs(float(solid.own @ palm)) > UPRIGHT_COSINE
    return solid.kind in ("box", "superquadric")


def _ground(
    item: SceneObject,
    solid: Superquadric,
    support: SupportPlane | None,
    up: NDArray[np.float64],
) -> float:
    """Coordinate along up of what the object stands on, m."""
    lowest = -float(solid.support(-up))
    if support is None or item.rests_on not in (0, None):
        return lowest
    return -support.offset
