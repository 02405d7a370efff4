"""Two unit directions at right angles to a given one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def perpendicular_pair(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows a, b (2, 3) that complete a unit direction d (3,) to a right-handed frame (a, b, d).

    Deterministic: a is perpendicular to the coordinate axis farthest from d, too.
    """
    least = np.zeros(3)
    least[int(np.argmin(np.abs(direction)))] = 1.0
    first = np.cross(direction, least)
    first = first / np.sqrt(np.sum(first * first))
    return np.array([first, np.cross(direction, first)], dtype=np.float64)
