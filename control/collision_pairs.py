"""Which parts of a robot are measured against which: its own, and what stands fixed in its file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .mujoco_binding import mujoco

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .mujoco_binding import Model
    from .robot_model import RobotModel

_UNMEASURED = (int(mujoco.mjtGeom.mjGEOM_HFIELD), int(mujoco.mjtGeom.mjGEOM_SDF))


@dataclass(frozen=True, eq=False)
class Parts:
    """Geoms of a robot's file, by what they are for the collision world."""

    robot: tuple[int, ...]
    """Geoms that a controlled joint moves."""
    fixed: tuple[int, ...]
    """Geoms that none moves: a table, the robot's foot, an arm that is not controlled."""
    names: dict[int, str]
    """Name of each: its own, else its body's with a number if the body has several."""
    moves: NDArray[np.bool_]
    """(geoms, n): which joint moves which."""


def parts_of(robot: RobotModel) -> Parts:
    """Sort a robot's geoms: those that collide, or all if none does.

    Raises
    ------
    InputError
        If a geom is of a kind that distances cannot be measured to.
    """
    model = robot.model
    every = range(model.ngeom)
    colliding = [g for g in every if model.geom_contype[g] or model.geom_conaffinity[g]]
    moves = robot.moves[model.geom_bodyid]
    if not any(moves[g].any() for g in colliding):
        colliding = [g for g in every if moves[g].any() or g in set(colliding)]
    names = {geom: _name(model, geom, colliding) for geom in colliding}
    for geom in colliding:
        if int(model.geom_type[geom]) in _UNMEASURED:
            raise InputError(
                f"robot: geom {names[geom]} is a height field or distance field, to which no "
                "distance can be measured; use boxes, a mesh, or set its contype and "
                "conaffinity to 0"
            )
    return Parts(
        tuple(g for g in colliding if moves[g].any()),
        tuple(g for g in colliding if not moves[g].any()),
        names,
        moves,
    )


def candidate_pairs(robot: RobotModel, parts: Parts) -> list[tuple[int, int]]:
    """Return the pairs (robot's geom, other geom) of the file that joints can bring together.

    Left out: parts that move together, parent and child, and what ``<exclude>`` names.
    """
    model = robot.model
    excluded = {int(signature) for signature in model.exclude_signature}
    pairs = []
    for place, a in enumerate(parts.robot):
        for b in (*parts.robot[place + 1 :], *parts.fixed):
            one, other = sorted((int(model.geom_bodyid[a]), int(model.geom_bodyid[b])))
            together = np.array_equal(parts.moves[a], parts.moves[b])
            if together or related(model, one, other) or (one << 16) + other in excluded:
                continue
            pairs.append((a, b))
    return pairs


def related(model: Model, one: int, other: int) -> bool:
    """Return whether two bodies are parent and child, or fixed to one another.

    The world is no parent: a table is an obstacle also to the first link that stands on it. What is
    fixed to a child is not its parent's child: a hand can hit the link before the wrist.
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
