"""The pairs of geoms in the robot's file that are checked for collision."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .mujoco_binding import Model, mujoco
from .proximity_tables import FULL_SCALE
from .robot_model import RobotModel

_NO_DISTANCE = (int(mujoco.mjtGeom.mjGEOM_HFIELD), int(mujoco.mjtGeom.mjGEOM_SDF))
STEADY_M = 0.01
"""Two parts of the robot nearer than this in every posture are never checked, m. With the usual
margin of the controller, 10 mm, they would stop the arm, although no joint moves them apart."""
HOME_M = 0.011
"""Least distance that two parts of the robot count as having in the home posture, m. It is the
usual margin of the controller and 1 mm, so that the arm can reach that posture."""
LEAST_M = 0.001
"""Least distance at home for which this holds, m. Parts that are nearer there stop the arm."""
POSTURES = 16
"""Number of random postures in which such parts are measured."""


@dataclass(frozen=True, eq=False)
class CollisionGeoms:
    """The geoms of the robot's file that can collide."""

    robot: tuple[int, ...]
    """Geoms that a controlled joint moves: the parts of the robot."""
    fixed: tuple[int, ...]
    """Geoms that no controlled joint moves: a table, the robot's base, an arm that stands still."""
    names: dict[int, str]
    """Name of each geom. A geom without a name has that of its body, with a number if the body has
    several."""
    moves: NDArray[np.bool_]
    """(geoms, n): whether a joint moves a geom."""


def find_collision_geoms(robot: RobotModel) -> CollisionGeoms:
    """Find the geoms that collide. If no part of the robot collides, all its geoms count.

    Raises
    ------
    InputError
        If MuJoCo cannot compute distances to a geom of this type.
    """
    model = robot.model
    moves = robot.moves[model.geom_bodyid]
    moved = [bool(row.any()) for row in moves]
    collides = [
        bool(model.geom_contype[g] or model.geom_conaffinity[g]) for g in range(model.ngeom)
    ]
    any_part = any(part and hit for part, hit in zip(moved, collides, strict=True))
    colliding = [g for g in range(model.ngeom) if collides[g] or (moved[g] and not any_part)]
    names = {geom: _name(model, geom, colliding) for geom in colliding}
    for geom in colliding:
        if int(model.geom_type[geom]) in _NO_DISTANCE:
            raise InputError(
                f"robot: geom {names[geom]} is a height field or signed distance field, to which "
                "no distance can be computed; use boxes or a mesh, or set its contype and "
                "conaffinity to 0"
            )
    return CollisionGeoms(
        tuple(geom for geom in colliding if moved[geom]),
        tuple(geom for geom in colliding if not moved[geom]),
        names,
        moves,
    )


def sort_pairs(
    robot: RobotModel,
    geoms: CollisionGeoms,
    self_margin: float,
    distances: Callable[[NDArray[np.float64], list[tuple[int, int]]], NDArray[np.float64]],
) -> tuple[list[tuple[int, int, int]], tuple[tuple[str, str], ...]]:
    """Return the pairs of the file to check, and the names of those to ignore.

    ``distances`` returns the distances (P,), m, of P pairs at joint positions (n,). The third
    number of a pair is the scale of its distance in thousandths. It is larger than one for parts of
    the robot that are nearer than HOME_M at home, and makes HOME_M of that distance. So the arm
    reaches home, and the parts still never overlap.
    """
    pairs = candidate_pairs(robot, geoms)
    own = np.array([b in geoms.robot for _, b in pairs], dtype=bool)
    farthest = distances(robot.home, pairs)
    scale = np.where(own, HOME_M / np.clip(farthest, LEAST_M, HOME_M), 1.0)
    ignore = farthest < np.where(own, self_margin, 0.0)
    low, high = np.clip((robot.lower, robot.upper), robot.home - np.pi, robot.home + np.pi)
    for q in np.random.default_rng(0).uniform(low, high, (POSTURES, robot.n)):
        near = np.flatnonzero(own & ~ignore & (farthest < STEADY_M))
        farthest[near] = np.maximum(farthest[near], distances(q, [pairs[k] for k in near]))
    ignore |= own & (farthest < STEADY_M)
    named = [(geoms.names[a], geoms.names[b]) for a, b in pairs]
    ignored = tuple(named[k] for k in np.flatnonzero(ignore))
    scales = np.ceil(FULL_SCALE * scale).astype(int).tolist()
    return [(*pairs[k], scales[k]) for k in np.flatnonzero(~ignore)], ignored


def candidate_pairs(robot: RobotModel, geoms: CollisionGeoms) -> list[tuple[int, int]]:
    """Return the pairs (robot's geom, other geom) of the file that joints can bring together.

    Two geoms that move together are left out, and so are parent and child, and the pairs that the
    file names in ``<exclude>``.
    """
    model = robot.model
    excluded = {int(signature) for signature in model.exclude_signature}
    pairs = []
    for index, a in enumerate(geoms.robot):
        for b in (*geoms.robot[index + 1 :], *geoms.fixed):
            low, high = sorted((int(model.geom_bodyid[a]), int(model.geom_bodyid[b])))
            together = np.array_equal(geoms.moves[a], geoms.moves[b])
            # MuJoCo packs the two body ids of an exclusion into one number.
            if together or are_connected(model, low, high) or (low << 16) + high in excluded:
                continue
            pairs.append((a, b))
    return pairs


def are_connected(model: Model, one: int, other: int) -> bool:
    """Return whether two bodies are parent and child, or fixed to each other.

    The world does not count as a parent: a table is an obstacle also to the first link, which
    stands on it. A body fixed to a child does not count as the child: a hand can hit the link
    before the wrist.
    """
    welds = model.body_weldid
    if welds[one] == welds[other]:
        return True
    parents = model.body_parentid
    return 0 not in (one, other) and (parents[one] == other or parents[other] == one)


def _name(model: Model, geom: int, colliding: list[int]) -> str:
    if model.geom(geom).name:
        return model.geom(geom).name
    body = int(model.geom_bodyid[geom])
    name = model.body(body).name or f"body {body}"
    siblings = [g for g in colliding if model.geom_bodyid[g] == body and not model.geom(g).name]
    return name if len(siblings) == 1 else f"{name}[{siblings.index(geom)}]"
