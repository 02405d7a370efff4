"""Cluttered reaching scenes: a 7-joint arm amid boxes, where it starts and what it shall reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

from .arm_clearance import ArmClearance, ReachingObstacle

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_BOXES = 12
"""With more there is hardly a posture left that touches none."""

HALF_EXTENT_M = (0.05, 0.20)
"""Range of a box's half extents."""
SHELL_RADIUS_M = (0.30, 0.75)
"""Range of a box's middle's distance from the arm's first axis: where elbow and hand move."""
SHELL_HEIGHT_M = (0.05, 0.85)
"""Range of a box's middle's height above the arm's foot."""
SHARE_NEAR_PATH = 0.5
"""Share of the boxes that are drawn about the tool's straight way, the others anywhere in the
shell; the dial of how hard the scenes are."""
PATH_RANGE = (0.2, 0.8)
"""Part of the way that they are drawn about."""
SPREAD_M = 0.10
"""Standard deviation of their middle from it, along each axis."""
MAX_TILT = 0.5
"""A box leans by up to this angle, rad, to any side."""
COLUMN_M = (0.16, 0.42)
"""Radius and height about the arm's foot that boxes stay out of: link1 cannot move away."""

MIN_CLEARANCE_M = 0.020
"""Start and goal posture are this far from all boxes and from themselves: room for a margin."""
MIN_TRAVEL_M = 0.4
"""The tool's way is at least this long, so that something may stand in it."""
MIN_HEIGHT_M = 0.1
"""Elbow, wrist and tool start and end above this: the arm stands on a floor, though none is met."""
JOINT_RANGE_SHARE = 0.95
"""Share of each joint's range that postures are drawn from: a goal at a limit is another test."""

_TRIES = 600
"""Boxes drawn for one start and goal before these are drawn anew."""
_ROUTES = 50


@dataclass(frozen=True)
class ReachingScene:
    """Take the tool from where it is at `start` to `goal`, in any orientation, touching nothing."""

    seed: int
    """What it was drawn from."""
    start: NDArray[np.float64]
    """Joint angles to start from (7,), rad, clear of everything."""
    goal: NDArray[np.float64]
    """Where the tool shall go (3,), world, m."""
    obstacles: tuple[ReachingObstacle, ...]
    """What stands around."""
    witness: NDArray[np.float64]
    """Joint angles (7,), rad, clear of everything, with the tool at the goal: it can be reached.
    For the judge's eyes only."""


def make_reaching_scene(seed: int, *, boxes: int = 5) -> ReachingScene:
    """Draw a scene; the goal is where the tool is in a posture that touches nothing.

    Whether a way leads from the start to such a posture is left to chance: boxes may wall it off.

    Parameters
    ----------
    seed
        Source of chance, >= 0; the same seed gives the same scene.
    boxes
        How many boxes stand around, 0 to 12.

    Returns
    -------
    ReachingScene
        The scene, for the arm of `LBR_ARM`.

    Raises
    ------
    InputError
        If the seed or the number of boxes is out of its range.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    if seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed}")
    if not 0 <= boxes <= MAX_BOXES:
        raise InputError(f"boxes must be a whole number from 0 to {MAX_BOXES}, got {boxes}")
    rng = np.random.default_rng(seed)
    alone = ArmClearance()
    for _ in range(_ROUTES):
        witness = _free_posture(rng, alone)
        goal = alone.tool(witness)
        start = _free_posture(rng, alone, away_from=goal)
        obstacles = _clutter(rng, boxes, start, witness)
        if obstacles is not None:
            return ReachingScene(seed, start, goal, obstacles, witness)
    raise InputError(f"found no room for {boxes} boxes; take fewer")


def straight_path_is_blocked(scene: ReachingScene) -> bool:
    """Tell whether the tool's straight way to the goal crosses a box: how hard the scene is."""
    first = ArmClearance(scene.obstacles).tool(scene.start)
    return any(_crosses(first, scene.goal, item) for item in scene.obstacles)


def _clutter(
    rng: np.random.Generator,
    boxes: int,
    start: NDArray[np.float64],
    witness: NDArray[np.float64],
) -> tuple[ReachingObstacle, ...] | None:
    alone = ArmClearance()
    way = np.array([alone.tool(start), alone.tool(witness)])
    placed: list[ReachingObstacle] = []
    for _ in range(_TRIES):
        if len(placed) == boxes:
            return tuple(placed)
        box = _box(rng, f"box_{len(placed) + 1}", way)
        if _meets_column(box):
            continue
        clearance = ArmClearance([box])
        if min(clearance.at(start), clearance.at(witness)) >= MIN_CLEARANCE_M:
            placed.append(box)
    return None


def _box(rng: np.random.Generator, name: str, way: NDArray[np.float64]) -> ReachingObstacle:
    low, high, tall = rng.uniform(*HALF_EXTENT_M, size=3)
    azimuth, lean_azimuth, yaw = rng.uniform(-np.pi, np.pi, size=3)
    lean = rng.uniform(0.0, MAX_TILT)
    axis = np.array([np.cos(lean_azimuth), np.sin(lean_azimuth), 0.0])
    turn = Rotation.from_rotvec(lean * axis) * Rotation.from_rotvec([0.0, 0.0, yaw])
    radius, height = rng.uniform(*SHELL_RADIUS_M), rng.uniform(*SHELL_HEIGHT_M)
    if rng.random() < SHARE_NEAR_PATH:
        share = rng.uniform(*PATH_RANGE)
        centre = way[0] + share * (way[1] - way[0]) + rng.normal(0.0, SPREAD_M, size=3)
    else:
        centre = np.array([radius * np.cos(azimuth), radius * np.sin(azimuth), height])
    pose = RigidTransform.from_components(centre, turn)
    return ReachingObstacle(name, "box", (float(low), float(high), float(tall)), pose)


def _meets_column(box: ReachingObstacle) -> bool:
    radius, height = COLUMN_M
    axis = np.zeros((24, 3))
    axis[:, 2] = np.linspace(0.0, height, len(axis))
    inside = np.abs(box.T_world_shape.inv().apply(axis)) - box.size
    return bool(np.linalg.norm(np.maximum(inside, 0.0), axis=1).min() < radius)


def _free_posture(
    rng: np.random.Generator,
    clearance: ArmClearance,
    away_from: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    while True:
        posture = rng.uniform(*(JOINT_RANGE_SHARE * clearance.joint_range))
        far = away_from is None or bool(
            np.linalg.norm(clearance.tool(posture) - away_from) >= MIN_TRAVEL_M
        )
        if (
            far
            and clearance.lowest_joint(posture) >= MIN_HEIGHT_M
            and clearance.at(posture) >= MIN_CLEARANCE_M
        ):
            return posture


def _crosses(first: NDArray[np.float64], last: NDArray[np.float64], box: ReachingObstacle) -> bool:
    into = box.T_world_shape.inv()
    origin, end = into.apply(np.array([first, last]))
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = (np.outer([-1.0, 1.0], box.size) - origin) / (end - origin)
    entry, leave = np.nanmin(sides, axis=0).max(), np.nanmax(sides, axis=0).min()
    return bool(max(entry, 0.0) <= min(leave, 1.0))
