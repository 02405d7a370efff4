"""Cluttered reaching scenes: an arm between boxes, its start and its goal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

from ..arms import ReachingArm
from .arm_clearance import INCLUDED, ArmClearance, ReachingObstacle
from .tight_places import PLACES, Place, furniture, suits

MAX_BOXES = 12
"""Maximum number of boxes. With more, few postures are free of contact."""

# Lengths are those for the included arm. For another arm they grow with its reach.
HALF_EXTENT_M = (0.05, 0.20)
"""Range of a box's half extents."""
SHELL_RADIUS_M = (0.30, 0.75)
"""Range of the distance of a box centre from the arm's first axis: where elbow and hand move."""
SHELL_HEIGHT_M = (0.05, 0.85)
"""Range of the height of a box centre above the arm's base."""
SHARE_NEAR_PATH = 0.5
"""Share of the boxes drawn near the tool's straight path; the others lie anywhere in the shell. It
sets the difficulty of the scenes."""
PATH_RANGE = (0.2, 0.8)
"""Part of the path near which they are drawn."""
SPREAD_M = 0.10
"""Standard deviation of their centres from the path, along each axis."""
MAX_TILT = 0.5
"""Maximum tilt of a box, rad, to any side."""
COLUMN_M = (0.16, 0.42)
"""Radius and height of a column around the arm's base without boxes: link1 cannot move away."""
SWEEP_STEP_M = 0.01
"""Distance between the places of a moving solid at which the column is tested."""

MIN_CLEARANCE_M = 0.020
"""Minimum distance of start and goal posture to boxes and between the arm's own links."""
MIN_TRAVEL_M = 0.4
"""Minimum length of the tool's path, so that a box may block it."""
MIN_HEIGHT_M = 0.1
"""Minimum height of elbow, wrist and tool at start and goal. The scene itself has no floor."""
JOINT_RANGE_SHARE = 0.95
"""Share of each joint's range from which postures are drawn. Goals at joint limits are another
test."""

_TRIES = 600
"""Boxes drawn for one start and goal before both are drawn again."""
_ROUTES = 50
"""Starts and goals drawn before the function gives up."""
_POSTURES = 20_000
"""Postures drawn before the function gives up."""
_TIGHT_ROUTES = 20_000
"""The same for furniture around the goal, where most draws of the goal do not suit."""


@dataclass(frozen=True)
class ReachingScene:
    """Task: move the tool from `start` to `goal`, in any orientation, without contact."""

    seed: int
    """Seed of the scene."""
    start: NDArray[np.float64]
    """Joint angles at the start (7,), rad, without contact."""
    goal: NDArray[np.float64]
    """Goal position of the tool (3,), world, m."""
    obstacles: tuple[ReachingObstacle, ...]
    """The boxes."""
    witness: NDArray[np.float64]
    """Joint angles (7,), rad, without contact and with the tool at the goal. They prove that the
    goal can be reached; methods under test must not use them."""
    goal_axes: NDArray[np.float64]
    """Rotation of the tool at the goal (3, 3), tool to world, for goals with an orientation."""
    arm: ReachingArm = INCLUDED
    """The arm."""


class _Surroundings(NamedTuple):
    """What the random boxes and postures of an arm depend on."""

    arm: ReachingArm
    alone: ArmClearance
    """The arm without obstacles."""
    scale: float
    """Reach of the arm, relative to the included one."""


def make_reaching_scene(
    seed: int, *, boxes: int = 5, place: Place = "boxes", arm: ReachingArm = INCLUDED
) -> ReachingScene:
    """Draw a scene whose goal is the tool's position in a posture without contact.

    A path from the start to such a posture may not exist, because boxes may block all paths.

    Parameters
    ----------
    seed
        Source of randomness, >= 0; the same seed gives the same scene.
    boxes
        Number of boxes, 0 to 12. Other places than boxes have none.
    place
        Surroundings of the goal. Neighbours fit the last link of the included arm only.
    arm
        The arm. The lengths of a scene follow its reach.

    Returns
    -------
    ReachingScene
        The scene.

    Raises
    ------
    InputError
        If the seed or the number of boxes is out of its range, or the place is unknown.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    if seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed}")
    if not 0 <= boxes <= MAX_BOXES:
        raise InputError(f"boxes must be a whole number from 0 to {MAX_BOXES}, got {boxes}")
    if place not in PLACES:
        raise InputError(f"the place must be one of {', '.join(PLACES)}, got {place!r}")
    if place == "neighbours" and arm != INCLUDED:
        raise InputError("the place neighbours fits the included arm only")
    rng = np.random.default_rng(seed)
    around = _surroundings(arm)
    alone = around.alone
    for _ in range(_ROUTES if place == "boxes" else _TIGHT_ROUTES):
        witness = _free_posture(rng, around)
        axes = alone.tool_axes(witness)
        if not suits(place, axes[:, 2]):
            continue
        goal = alone.tool(witness)
        start = _free_posture(rng, around, away_from=goal)
        if place == "boxes":
            obstacles = _clutter(rng, boxes, start, witness, around)
        else:
            solids = furniture(place, goal, axes[:, 2], rng)
            obstacles = _enclosed(solids, start, witness, around)
        if obstacles is not None:
            return ReachingScene(seed, start, goal, obstacles, witness, axes, arm)
    raise InputError(
        f"found no positions without contact for {boxes} boxes ({place}); use fewer boxes"
    )


def straight_path_is_blocked(scene: ReachingScene) -> bool:
    """Return whether the tool's straight path to the goal crosses a box."""
    first = ArmClearance(scene.obstacles, scene.arm).tool(scene.start)
    return any(_crosses(first, scene.goal, item) for item in scene.obstacles)


def passes_base(
    solid: ReachingObstacle, travel: NDArray[np.float64], arm: ReachingArm = INCLUDED
) -> bool:
    """Return whether a solid that moves by `travel` (3,), m, enters the column around the base.

    No motion of the arm evades such a solid, because the first link cannot move away.
    """
    scale = _surroundings(arm).scale
    steps = 1 + int(np.ceil(np.linalg.norm(travel) / SWEEP_STEP_M))
    start, turn = solid.T_world_shape.translation, solid.T_world_shape.rotation
    for share in np.linspace(0.0, 1.0, steps + 1):
        pose = RigidTransform.from_components(start + share * travel, turn)
        if _overlaps_column(solid._replace(T_world_shape=pose), scale):
            return True
    return False


def _enclosed(
    solids: tuple[ReachingObstacle, ...],
    start: NDArray[np.float64],
    witness: NDArray[np.float64],
    around: _Surroundings,
) -> tuple[ReachingObstacle, ...] | None:
    """Return the solids if start and goal keep clear of them and the arm's base does."""
    if any(_overlaps_column(solid, around.scale) for solid in solids):
        return None
    clearance = ArmClearance(solids, around.arm)
    free = min(clearance.at(start), clearance.at(witness)) >= MIN_CLEARANCE_M
    return solids if free else None


def _clutter(
    rng: np.random.Generator,
    boxes: int,
    start: NDArray[np.float64],
    witness: NDArray[np.float64],
    around: _Surroundings,
) -> tuple[ReachingObstacle, ...] | None:
    path = np.array([around.alone.tool(start), around.alone.tool(witness)])
    placed: list[ReachingObstacle] = []
    for _ in range(_TRIES):
        if len(placed) == boxes:
            return tuple(placed)
        box = _box(rng, f"box_{len(placed) + 1}", path, around.scale)
        if _overlaps_column(box, around.scale):
            continue
        clearance = ArmClearance([box], around.arm)
        if min(clearance.at(start), clearance.at(witness)) >= MIN_CLEARANCE_M:
            placed.append(box)
    return None


def _box(
    rng: np.random.Generator, name: str, path: NDArray[np.float64], scale: float
) -> ReachingObstacle:
    low, high, tall = scale * rng.uniform(*HALF_EXTENT_M, size=3)
    azimuth, lean_azimuth, yaw = rng.uniform(-np.pi, np.pi, size=3)
    lean = rng.uniform(0.0, MAX_TILT)
    axis = np.array([np.cos(lean_azimuth), np.sin(lean_azimuth), 0.0])
    turn = Rotation.from_rotvec(lean * axis) * Rotation.from_rotvec([0.0, 0.0, yaw])
    radius, height = scale * rng.uniform(*SHELL_RADIUS_M), scale * rng.uniform(*SHELL_HEIGHT_M)
    if rng.random() < SHARE_NEAR_PATH:
        share = rng.uniform(*PATH_RANGE)
        centre = path[0] + share * (path[1] - path[0]) + scale * rng.normal(0.0, SPREAD_M, size=3)
    else:
        centre = np.array([radius * np.cos(azimuth), radius * np.sin(azimuth), height])
    pose = RigidTransform.from_components(centre, turn)
    return ReachingObstacle(name, "box", (float(low), float(high), float(tall)), pose)


def _overlaps_column(box: ReachingObstacle, scale: float) -> bool:
    radius, height = scale * COLUMN_M[0], scale * COLUMN_M[1]
    axis = np.zeros((24, 3))
    axis[:, 2] = np.linspace(0.0, height, len(axis))
    inside = np.abs(box.T_world_shape.inv().apply(axis)) - box.size
    return bool(np.linalg.norm(np.maximum(inside, 0.0), axis=1).min() < radius)


def _free_posture(
    rng: np.random.Generator,
    around: _Surroundings,
    away_from: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    clearance, scale = around.alone, around.scale
    for _ in range(_POSTURES):
        posture = rng.uniform(*(JOINT_RANGE_SHARE * clearance.joint_range))
        far = away_from is None or bool(
            np.linalg.norm(clearance.tool(posture) - away_from) >= scale * MIN_TRAVEL_M
        )
        if (
            far
            and clearance.lowest_joint(posture) >= scale * MIN_HEIGHT_M
            and clearance.at(posture) >= MIN_CLEARANCE_M
        ):
            return posture
    raise InputError(
        f"{around.arm.file}: found no posture without contact among {_POSTURES}; the shapes of its "
        "links may overlap in most postures"
    )


@lru_cache(maxsize=4)
def _surroundings(arm: ReachingArm) -> _Surroundings:
    alone = ArmClearance((), arm)
    return _Surroundings(arm, alone, alone.reach() / ArmClearance().reach())


def _crosses(first: NDArray[np.float64], last: NDArray[np.float64], box: ReachingObstacle) -> bool:
    into = box.T_world_shape.inv()
    origin, end = into.apply(np.array([first, last]))
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = (np.outer([-1.0, 1.0], box.size) - origin) / (end - origin)
    entry, leave = np.nanmin(sides, axis=0).max(), np.nanmax(sides, axis=0).min()
    return bool(max(entry, 0.0) <= min(leave, 1.0))
