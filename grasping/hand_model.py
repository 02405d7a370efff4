"""What is known of a hand before it touches anything: how wide it opens, how far its tips reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .hand_names import check_names

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class HandModel:
    """Geometry of a hand whose fingers oppose a thumb along x, z out of the palm.

    The table of openings holds what the hand does when it is opened to a width with nothing in it,
    all fingers alike, their pads as far from the middle of the palm as the thumb's.

    Names have a meaning. A two-jaw gripper with a motor for each jaw has the fingers ``jaw`` and
    ``thumb``, drives of the same names and the pads ``jaw_distal`` and ``thumb_distal``:

    - fingers: the last is ``thumb``; ``middle`` is the one that pinches against it (without one,
      all do); none begins with another's name or with ``palm``;
    - drives: ``thumb`` moves the thumb, a finger's name that finger; ``wrap`` and ``thumb_wrap``
      bend the outer joints around an object, where the hand can; any other name moves all fingers
      that have no drive of their own, and each must have one;
    - pads: ``<finger>_distal`` at the tip of each finger; others begin with their finger's name or
      with ``palm``;
    - joints: a finger's begin with its name, from the base to the tip.

    Raises
    ------
    InputError
        If a name breaks these rules, the openings do not rise, or the tables do not fit one
        another.
    """

    drives: tuple[str, ...]
    """Names of what the motors pull: a tendon, or whatever closes fingers like one."""
    joints: tuple[str, ...]
    """Names of the joints."""
    pads: tuple[str, ...]
    """Names of what feels normal force: phalanges from the base to the tip, and the palm."""
    fingers: tuple[str, ...]
    """Names of fingers and thumb, the thumb last; a pad or joint of one begins with its name."""
    openings: NDArray[np.float64]
    """Free widths between finger pads and thumb pad at the tips, (K,), rising, m."""
    reaches: NDArray[np.float64]
    """Distance of the farthest point of the tips from the palm along z at each opening, (K,), m."""
    excursions: NDArray[np.float64]
    """Tendon excursions that make each opening, (K, D), m."""
    spreads: NDArray[np.float64]
    """Outer width of the open hand along x at each opening, (K,), m: what must be free of
    neighbours."""
    row: float
    """Outer width of the row of fingers along y, m."""
    middle_row: float
    """Outer width along y of what a pincer uses, m."""
    thickness: float
    """Thickness of a fingertip along x, m."""
    palm_depth: float
    """How far the hand reaches behind the palm's face, m."""

    def __post_init__(self) -> None:
        check_names(self.drives, self.joints, self.pads, self.fingers)
        openings = self.openings
        if openings.ndim != 1 or len(openings) < 2 or not (np.diff(openings) > 0).all():
            raise InputError(f"openings must be two or more rising widths, got {openings.tolist()}")
        for name in ("reaches", "spreads", "excursions"):
            if len(getattr(self, name)) != len(openings):
                raise InputError(
                    f"{name} must have a row for each of {len(openings)} openings, "
                    f"got {len(getattr(self, name))}"
                )
        if self.excursions.shape[1] != len(self.drives):
            raise InputError(
                f"excursions must have a column for each of {len(self.drives)} drives, "
                f"got {self.excursions.shape[1]}"
            )

    @property
    def widest(self) -> float:
        """Widest opening, m."""
        return float(self.openings[-1])

    def reach(self, opening: float) -> float:
        """Distance of the tips' farthest point from the palm along z at an opening, m."""
        return float(np.interp(opening, self.openings, self.reaches))

    def spread(self, opening: float) -> float:
        """Outer width along x at an opening, m."""
        return float(np.interp(opening, self.openings, self.spreads))

    def pulled(self, opening: float) -> NDArray[np.float64]:
        """Tendon excursions that make an opening, (D,), m."""
        return np.array([np.interp(opening, self.openings, e) for e in self.excursions.T])
