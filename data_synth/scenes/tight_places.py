"""Furniture around a goal of the 7-joint arm: a shelf, a bin with walls, and two neighbours."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from .arm_clearance import ReachingObstacle

Place = Literal["boxes", "shelf", "bin", "neighbours"]
"""Surroundings of a goal: random boxes; inside a shelf; inside a bin; between two boxes."""
PLACES: tuple[Place, ...] = ("boxes", "shelf", "bin", "neighbours")
"""Names of all surroundings."""

BOARD_M = 0.01
"""Half thickness of boards and walls."""
SHELF_M = ((0.40, 0.60), (0.28, 0.40), (0.30, 0.40))
"""Ranges of inner width, height and depth of a shelf."""
SHELF_DEPTH_M = (0.06, 0.14)
"""Range of the distance of the goal from the front of the shelf."""
BIN_M = ((0.30, 0.40), (0.25, 0.35), (0.12, 0.20))
"""Ranges of inner length, width and height of a bin."""
BIN_FLOOR_M = (0.05, 0.10)
"""Range of the height of the goal above the floor of the bin."""
GAP_M = 0.06
"""Gap between two neighbours and the last link together: half of it on each side."""
LINK_RADIUS_M = 0.037
"""Radius of the arm's last link."""
NEIGHBOUR_M = (0.04, 0.08)
"""Range of the half extents of a neighbour."""
MAX_TILT = np.radians(25.0)
"""Maximum angle between the tool and the direction into the place."""


def suits(place: Place, axis: NDArray[np.float64]) -> bool:
    """Return whether a tool with this axis (3,), world, can be inside a place."""
    if place == "shelf":
        return abs(float(axis[2])) < np.sin(MAX_TILT)
    if place in ("bin", "neighbours"):
        return float(axis[2]) < -np.cos(MAX_TILT)
    return True


def furniture(
    place: Place, goal: NDArray[np.float64], axis: NDArray[np.float64], rng: np.random.Generator
) -> tuple[ReachingObstacle, ...]:
    """Return the solids of a place around a goal.

    Parameters
    ----------
    place
        A shelf, a bin or two neighbours.
    goal
        Position of the tool (3,), world, m.
    axis
        Axis of the tool (3,), world; see `suits`.
    rng
        Source of the sizes.
    """
    yaw = np.arctan2(axis[1], axis[0]) if place == "shelf" else rng.uniform(-np.pi, np.pi)
    frame = RigidTransform.from_components(goal, Rotation.from_rotvec([0.0, 0.0, float(yaw)]))
    solids = {"shelf": _shelf, "bin": _bin, "neighbours": _neighbours}[place](rng)
    return tuple(
        ReachingObstacle(
            f"{place}_{number + 1}",
            "box",
            (float(half[0]), float(half[1]), float(half[2])),
            frame * RigidTransform.from_translation(middle),
        )
        for number, (middle, half) in enumerate(solids)
    )


_Solids = list[tuple[list[float], list[float]]]


def _shelf(rng: np.random.Generator) -> _Solids:
    """Return centres and half extents: x leads into the shelf, the goal is the origin."""
    width, height, depth = (0.5 * rng.uniform(*span) for span in SHELF_M)
    x = depth - rng.uniform(*SHELF_DEPTH_M)
    y = rng.uniform(-0.3, 0.3) * width
    z = rng.uniform(-0.2, 0.2) * height
    t = BOARD_M
    return [
        ([x, y, z - height - t], [depth, width, t]),
        ([x, y, z + height + t], [depth, width, t]),
        ([x, y - width - t, z], [depth, t, height]),
        ([x, y + width + t, z], [depth, t, height]),
        ([x + depth + t, y, z], [t, width, height]),
    ]


def _bin(rng: np.random.Generator) -> _Solids:
    """Return centres and half extents: z is up, the goal is the origin."""
    length, width, height = (0.5 * rng.uniform(*span) for span in BIN_M)
    x, y = rng.uniform(-0.3, 0.3, 2) * [length, width]
    floor = -rng.uniform(*BIN_FLOOR_M)
    z, t = floor + height, BOARD_M
    return [
        ([x, y, floor - t], [length, width, t]),
        ([x - length - t, y, z], [t, width, height]),
        ([x + length + t, y, z], [t, width, height]),
        ([x, y - width - t, z], [length, t, height]),
        ([x, y + width + t, z], [length, t, height]),
    ]


def _neighbours(rng: np.random.Generator) -> _Solids:
    """Return centres and half extents: the neighbours stand on both sides along y."""
    solids: _Solids = []
    for side in (-1.0, 1.0):
        half = rng.uniform(*NEIGHBOUR_M, 3)
        y = side * (LINK_RADIUS_M + 0.5 * GAP_M + half[1])
        # The goal is up to 60 mm below the top of a neighbour.
        top = rng.uniform(0.0, 0.06)
        solids.append(([0.0, float(y), float(top - half[2])], half.tolist()))
    return solids
