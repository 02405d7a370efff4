"""Geometric model of a hand: openings, reaches, and the names of its parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .hand_names import check_names


@dataclass(frozen=True)
class HandModel:
    """Geometry of a hand whose fingers oppose a thumb along x, with z out of the palm.

    `openings`, `reaches`, `excursions` and `outer_widths` are a table of the empty hand at
    increasing openings. All fingers move equally, and their pads are as far from the middle of the
    palm as the thumb's pad.

    The names define the function of each part:

    - fingers: the last one is ``thumb``. If one is called ``middle``, only this finger pinches
      against the thumb; otherwise all fingers do. No name begins with the name of another finger
      or with ``palm``.
    - drives: one must be ``thumb``. A drive with the name of a finger moves that finger. A drive
      with any other name moves all fingers without a drive of the same name. It is required if
      there are such fingers, and invalid if there are none. ``wrap`` and ``thumb_wrap`` are
      optional: they bend the outer joints around an object.
    - pads: ``<finger>_distal`` is the pad at the tip of each finger. Other names begin with the
      name of their finger or with ``palm``.
    - joints: names begin with the name of their finger. The joints of a finger are listed from base
      to tip; this order is not checked.

    For example, a gripper with two driven jaws has the fingers and drives ``jaw`` and ``thumb``
    and the pads ``jaw_distal`` and ``thumb_distal``.

    Raises
    ------
    InputError
        If a name breaks these rules, the openings do not increase, or the tables have different
        lengths.
    """

    drives: tuple[str, ...]
    """Names of the drives; each pulls a tendon or closes fingers in another way."""
    joints: tuple[str, ...]
    """Names of the joints; may be empty."""
    pads: tuple[str, ...]
    """Names of the force-sensing pads on phalanges and palm, in any order."""
    fingers: tuple[str, ...]
    """Names of the fingers, the thumb last."""
    openings: NDArray[np.float64]
    """Distances between finger pads and thumb pad at the tips, (K,), increasing, m."""
    reaches: NDArray[np.float64]
    """Maximum distance of the fingertips from the palm along z at each opening, (K,), m."""
    excursions: NDArray[np.float64]
    """Excursions of the D drives at each opening, (K, D), m."""
    outer_widths: NDArray[np.float64]
    """Outer width of the hand along x at each opening, (K,), m."""
    row_width: float
    """Outer width of the row of fingers along y, m."""
    pinch_width: float
    """Outer width of the pinching finger along y, m."""
    thickness: float
    """Thickness of a fingertip along x, m."""
    palm_depth: float
    """Depth of the hand behind the palm's face, m."""
    finger_rows: tuple[float, ...] = ()
    """Position of each finger along y without the thumb, m. If empty, the named fingers are evenly
    spaced."""
    finger_width: float = 0.0
    """Width of a finger's pad along y, m; 0 for `pinch_width`."""

    def __post_init__(self) -> None:
        check_names(self.drives, self.joints, self.pads, self.fingers)
        openings = self.openings
        if openings.ndim != 1 or len(openings) < 2 or not (np.diff(openings) > 0).all():
            raise InputError(
                f"openings must be at least two increasing widths in m, got {openings.tolist()}"
            )
        for name in ("reaches", "outer_widths", "excursions"):
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
    def max_opening(self) -> float:
        """Maximum opening, m."""
        return float(self.openings[-1])

    def reach(self, opening: float) -> float:
        """Return the maximum distance of the fingertips from the palm along z at an opening, m.

        Openings outside the table count as its first or last one.
        """
        return float(np.interp(opening, self.openings, self.reaches))

    def outer_width(self, opening: float) -> float:
        """Return the outer width along x at an opening, m, limited as in :meth:`reach`."""
        return float(np.interp(opening, self.openings, self.outer_widths))

    @property
    def row_offsets(self) -> NDArray[np.float64]:
        """Position of each finger along y without the thumb, (R,), m."""
        if self.finger_rows:
            return np.array(self.finger_rows)
        count = len(self.fingers) - 1
        half = 0.5 * (self.row_width - self.pinch_width) if count > 1 else 0.0
        return np.linspace(half, -half, count)

    @property
    def pad_width(self) -> float:
        """Width of a finger's pad along y, m."""
        return self.finger_width or self.pinch_width

    def excursions_at(self, opening: float) -> NDArray[np.float64]:
        """Return the drive excursions at an opening, (D,), m, limited as in :meth:`reach`."""
        return np.array([np.interp(opening, self.openings, e) for e in self.excursions.T])
