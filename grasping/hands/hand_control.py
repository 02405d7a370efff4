"""What a pick needs of every kind of hand: its commands, and how it senses an object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.tactile import ContactFeatures

    from ..prototypes import Prototype
    from .closing import ClosingState
    from .grip_options import GripOptions
    from .hand_messages import AnyCommand, AnyReading


class ClosingController(Protocol):
    """A controller that closes a hand on an object, one control period at a time."""

    state: ClosingState
    """State of closing."""
    touched: bool
    """Whether the hand has touched an object."""

    def step(self, reading: AnyReading, dt: float) -> AnyCommand:
        """Compute the command of the next control period of dt seconds."""
        ...


@dataclass(frozen=True)
class HeldState:
    """What a hand senses of the object that it holds."""

    pads: int
    """Number of pads in contact."""
    curl: float = 0.0
    """Mean curl of the fingers, rad; 0 for jaws."""
    tips: tuple[ContactFeatures, ...] = ()
    """Contact on each fingertip; empty without tactile sensors."""


class HandControl(Protocol):
    """Commands and senses of one kind of hand. The phases of a pick use no other property of it."""

    @property
    def fingers(self) -> tuple[str, ...]:
        """Names of the fingers, in the order of the recorded forces."""
        ...

    @property
    def max_opening(self) -> float:
        """Maximum opening, m."""
        ...

    def reach(self, opening: float) -> float:
        """Return the distance of the fingertips from the hand frame along z at an opening, m."""
        ...

    def half_width(self, opening: float) -> float:
        """Return half the width of the hand at an opening in m, m."""
        ...

    def posture(self, opening: float, prototype: Prototype | None = None) -> NDArray[np.float64]:
        """Return the values (D,) for `Robot.description` at an opening in m."""
        ...

    def preshape(self, opening: float, prototype: Prototype) -> AnyCommand:
        """Return the command of the pre-shape with an opening in m."""
        ...

    def opened(self) -> AnyCommand:
        """Return the command that opens the hand fully."""
        ...

    def closing(
        self, prototype: Prototype, opening: float, options: GripOptions
    ) -> ClosingController:
        """Return the controller that closes the hand from an opening in m."""
        ...

    def contacts(self, reading: AnyReading, min_force: float) -> tuple[str, ...]:
        """Return the names of the pads with a force above ``min_force``, N.

        Without a sense of touch there are none.
        """
        ...

    def touched_side(self, reading: AnyReading, min_force: float) -> float:
        """Return the touched side along the hand's x axis: 1, -1, or 0 for both or neither."""
        ...

    def touches_outside(self, reading: AnyReading, min_force: float) -> bool:
        """Return whether a fingertip touches something beside its gripping face."""
        ...

    def forces(self, reading: AnyReading) -> NDArray[np.float64]:
        """Return the force on each finger, then on the palm, (F + 1,), N."""
        ...

    def width(self, reading: AnyReading) -> float:
        """Return the distance between the fingertips, m."""
        ...

    def holds(self, reading: AnyReading) -> bool:
        """Return whether an object is in the closed hand."""
        ...

    def held(self, reading: AnyReading) -> HeldState:
        """Return what the hand senses of the object that it holds."""
        ...
