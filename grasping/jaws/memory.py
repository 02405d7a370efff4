"""The memory of failed grasps: similar ones rank lower."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .candidates import Candidates
    from .grasp import Grasp

NEAR_OBJECT = 0.05
"""A candidate within this distance of a failed grasp is for the same object, m."""
NEAR_GRASP, NEAR_ANGLE = 0.025, np.radians(30.0)
"""A candidate within these distances is the same grasp, m and rad."""
OBJECT_TERM, GRASP_TERM = 0.6, 0.3
"""Terms of the same object, and of the same grasp."""


def memory_term(candidates: Candidates, failed: Sequence[Grasp]) -> NDArray[np.float64]:
    """Return a term below 1 for candidates near failed grasps, (n,)."""
    term = np.ones(len(candidates))
    for grasp in failed:
        distance = np.linalg.norm(candidates.tip - grasp.position, axis=1)
        closing = np.abs(candidates.rotation[:, :, 0] @ grasp.closing)
        approach = candidates.rotation[:, :, 2] @ grasp.approach
        near = distance < NEAR_OBJECT
        limit = np.cos(NEAR_ANGLE)
        same = (distance < NEAR_GRASP) & (closing > limit) & (approach > limit)
        term *= np.where(same, GRASP_TERM, np.where(near, OBJECT_TERM, 1.0))
    return term
