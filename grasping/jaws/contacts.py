"""Contacts of candidate poses with their object, with the hand centred on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .clearance import lift_above
from .contact_kernels import contacts
from .scoring import ContactTable

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SupportPlane

    from ..hands import ParallelHand
    from .candidates import Candidates
    from .surface_model import ObjectSurface

TABLE_MARGIN = 0.003
"""Minimum height of the hand above the support, m."""
NEAR = 0.004
"""Depth of the contact patch behind the outermost point, m."""
FACING, MIN_SEEN = 0.6, 3
"""Cosine and number of measured normals that show a side."""
MAX_LOWERED = 5e-4
"""Height by which centring may lower the hand below the margin before it is lifted again, m."""


def centred_contacts(
    candidates: Candidates,
    surface: ObjectSurface,
    support: SupportPlane | None,
    hand: ParallelHand,
) -> tuple[Candidates, ContactTable]:
    """Lift candidates above the support, centre them on the object, and return their contacts.

    Candidates that do not meet the object with both pads are left out.
    """
    lifted = candidates.at(lift_above(candidates, support, hand, TABLE_MARGIN))
    columns = pad_contacts(lifted, surface, hand)
    lifted, columns = _meeting(lifted, columns)
    centred = _centred(lifted, columns)
    # Along an inclined closing axis, centring moves the hand down.
    again = lift_above(centred, support, hand, TABLE_MARGIN)
    low = np.linalg.norm(again - centred.tip, axis=1) > MAX_LOWERED
    if low.any():
        moved = centred.take(low).at(again[low])
        renewed = pad_contacts(moved, surface, hand)
        tip = centred.tip.copy()
        tip[low] = moved.tip
        columns[low] = renewed
        centred = centred.at(tip)
        centred, columns = _meeting(centred, columns)
    return centred, contact_table(centred, columns)


def pad_contacts(
    candidates: Candidates, surface: ObjectSurface, hand: ParallelHand
) -> NDArray[np.float64]:
    """Return the columns of :func:`.contact_kernels.contacts` for one object, (n, 9)."""
    return contacts(
        candidates.rotation,
        candidates.tip,
        candidates.reach,
        (surface.points, surface.normals),
        (surface.blocks.start, surface.blocks.centre, surface.blocks.radius),
        surface.measured,
        (0.5 * hand.pad_width, hand.pad_height, NEAR),
        (FACING, MIN_SEEN),
    )


def contact_table(candidates: Candidates, columns: NDArray[np.float64]) -> ContactTable:
    """Return the contacts of candidates from the columns of the kernel."""
    height = 0.5 * (columns[:, 6] + columns[:, 7])
    return ContactTable(
        width=columns[:, 1],
        cosine=columns[:, 2:4],
        seen=columns[:, 4:6],
        overlap=np.maximum(columns[:, 7] - columns[:, 6], 0.0),
        middle=candidates.tip + height[:, None] * candidates.rotation[:, :, 2],
    )


def _meeting(
    candidates: Candidates, columns: NDArray[np.float64]
) -> tuple[Candidates, NDArray[np.float64]]:
    meets = columns[:, 1] > 0.0
    return candidates.take(meets), columns[meets]


def _centred(candidates: Candidates, columns: NDArray[np.float64]) -> Candidates:
    return candidates.at(candidates.tip + columns[:, :1] * candidates.rotation[:, :, 0])
