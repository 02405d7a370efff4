"""The distances of near pairs of parts, with normals and derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Proximity:
    """The P pairs of parts nearer than the cut-off, in a fixed order. All arrays are copies."""

    names: tuple[tuple[str, str], ...]
    """Names of the pairs: a part of the robot, and an obstacle or another part."""
    distance: NDArray[np.float64]
    """Signed distance (P,), m. If the parts overlap, it is the negative penetration depth. The
    distance of two parts of the robot nearer than 11 mm in the home posture is scaled such that it
    is 11 mm there, and so is its derivative."""
    normal: NDArray[np.float64]
    """Unit directions (P, 3), world, in which the part of the robot moves away from the other
    part."""
    on_robot: NDArray[np.float64]
    """Nearest points on the robot's parts (P, 3), m, world; the deepest points if they overlap."""
    on_other: NDArray[np.float64]
    """Nearest points on the other parts (P, 3), m, world."""
    rows: NDArray[np.float64]
    """Derivative of the distance by the joints (P, n), m/rad (m/m for a slide joint)."""
    drift: NDArray[np.float64]
    """Rate of the distance due to the motion of the obstacle (P,), m/s."""


def proximity_of(found: tuple, names: tuple[tuple[str, str], ...]) -> Proximity:
    """Return the result of `near_pairs` with the names of all pairs."""
    index, distance, normal, on_robot, on_other, rows, drift = found
    # The frozen constructor would take as long as several distances.
    proximity = object.__new__(Proximity)
    vars(proximity).update(
        names=tuple([names[pair] for pair in index.tolist()]),
        distance=distance,
        normal=normal,
        on_robot=on_robot,
        on_other=on_other,
        rows=rows,
        drift=drift,
    )
    return proximity
