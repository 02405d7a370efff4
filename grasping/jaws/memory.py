"""The memory of failed grasps: the same grasp and the same object rank lower."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .candidates import Candidates
    from .grasp import Grasp
    from .surface_model import ObjectSurface

NEAR_OBJECT = 0.05
"""A candidate within this distance of a failed grasp is for the same object, m."""
NEAR_GRASP, NEAR_ANGLE = 0.025, np.radians(30.0)
"""A candidate within these distances is the same grasp, m and rad."""
OBJECT_TERM, GRASP_TERM = 0.6, 0.3
"""Terms of the same object, and of the same grasp."""
MAX_PUSHED = 0.15
"""Maximum distance by which a failed grasp pushes an object, m."""
SAME_SIZE = 0.15
"""Maximum relative difference of the three sizes of an object that was pushed."""


def memory_term(
    candidates: Candidates, surfaces: Sequence[ObjectSurface], failed: Sequence[Grasp]
) -> NDArray[np.float64]:
    """Return a term below 1 for candidates near failed grasps or on pushed objects, (n,).

    A failed grasp pushes its object away. It is recognised by its three sizes.
    """
    term = np.ones(len(candidates))
    sizes = np.array([surface.size for surface in surfaces]) if failed else np.zeros((0, 3))
    for grasp in failed:
        distance = np.linalg.norm(candidates.tip - grasp.position, axis=1)
        closing = np.abs(candidates.rotation[:, :, 0] @ grasp.closing)
        approach = candidates.rotation[:, :, 2] @ grasp.approach
        near = distance < NEAR_OBJECT
        if grasp.object_size is not None:
            ratio = np.abs(sizes - grasp.object_size).max(axis=1) / max(grasp.object_size)
            near |= (distance < MAX_PUSHED) & (ratio < SAME_SIZE)[candidates.object]
        limit = np.cos(NEAR_ANGLE)
        same = (distance < NEAR_GRASP) & (closing > limit) & (approach > limit)
        term *= np.where(same, GRASP_TERM, np.where(near, OBJECT_TERM, 1.0))
    return term
