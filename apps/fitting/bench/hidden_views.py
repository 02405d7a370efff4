"""Views of objects that something in front hides from one side."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from .mesh_views import MeshView

NEARER = 0.08
"""Distance of the occluder in front of what it hides, m."""
BESIDE = 25
"""Pixels beside the object that the occluder hides too."""
MIN_PIXELS = 100
"""Minimum number of pixels of an object that remain."""


def hide_in_turn(views: Iterable[MeshView], shares: Sequence[float]) -> list[MeshView]:
    """Hide a share of the first object of each view, in turn from a list of shares, 0-1."""
    return [hide_side(view, shares[k % len(shares)]) for k, view in enumerate(views)]


def hide_side(view: MeshView, share: float) -> MeshView:
    """Replace the readings of a share of the rows or columns of the first object by nearer ones.

    The seed of the view selects the side.
    """
    if share <= 0.0:
        return view
    mask = view.object_pixels == 1
    across = np.nonzero(mask)[view.seed % 2]
    if len(across) <= MIN_PIXELS:
        return view
    low, high = int(across.min()), int(across.max())
    kept = max(round((1.0 - share) * (high - low + 1)), 1)
    position = np.indices(mask.shape)[view.seed % 2]
    if view.seed // 2 % 2:
        kept = max(kept, int(np.quantile(across, MIN_PIXELS / len(across))) - low + 1)
        hidden = position >= low + kept
    else:
        last = int(np.quantile(across, 1.0 - MIN_PIXELS / len(across)))
        hidden = position <= min(high - kept, last - 1)
    rows, columns = np.nonzero(mask)
    around = np.zeros_like(mask)
    around[
        max(rows.min() - BESIDE, 0) : rows.max() + BESIDE,
        max(columns.min() - BESIDE, 0) : columns.max() + BESIDE,
    ] = True
    hidden &= around
    depth = view.frame.depth.copy()
    depth[hidden & (depth > NEARER)] -= NEARER
    return replace(
        view,
        name=f"{view.name} {100 * share:.0f} % hidden",
        frame=replace(view.frame, depth=depth),
        object_pixels=np.where(hidden, 0, view.object_pixels).astype(np.uint8),
    )
