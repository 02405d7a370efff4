"""List the pairs of a world and fill the tables of the distance kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .held_object import HeldObject, held_pairs, held_row
from .proximity_tables import FULL_SCALE, ProximityTables

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .collision_pairs import CollisionGeoms
    from .options import CollisionOptions
    from .robot_model import RobotModel
    from .world_spec import WorldModel


class AddedGeoms(NamedTuple):
    """The geoms of the objects that were added to the robot's file."""

    obstacles: dict[str, int]
    """Geom of each obstacle."""
    held: dict[str, int]
    """Geom of each held object."""
    objects: tuple[HeldObject, ...]
    """The held objects, in the same order."""


class GeomArrays(NamedTuple):
    """The arrays by geom that the tables share."""

    shapes: NDArray[np.float64]
    motion: NDArray[np.float64]


def build_tables(
    robot: RobotModel,
    world: WorldModel,
    geoms: CollisionGeoms,
    file_pairs: list[tuple[int, int, int]],
    added: AddedGeoms,
    arrays: GeomArrays,
    options: CollisionOptions,
) -> ProximityTables:
    """Return the tables of a compiled world for all its pairs.

    ``geoms`` and ``file_pairs`` are those of the robot's file.
    """
    model = world.model
    placed = {**added.obstacles, **added.held}
    names = {**geoms.names, **{geom: name for name, geom in placed.items()}}
    held = list(added.held.values())
    moves = np.zeros((model.ngeom, robot.n), dtype=bool)
    moves[: len(geoms.moves)] = geoms.moves
    moves[held] = robot.moves[robot.frame_body]
    new = [(a, b) for a in (*geoms.robot, *held) for b in added.obstacles.values()]
    new += held_pairs(robot, geoms, held, moves)
    pairs = [*file_pairs, *((a, b, FULL_SCALE) for a, b in new)]
    rows = [held_row(robot, model, placed[one.name], one.pose) for one in added.objects]
    return ProximityTables(
        model=model,
        data=world.data,
        joints=robot.joint_table,
        moves=moves,
        shapes=arrays.shapes,
        motion=arrays.motion,
        pairs=np.array(pairs, dtype=np.int64).reshape(-1, 3),
        names=tuple((names[a], names[b]) for a, b, _ in pairs),
        held=np.array(rows).reshape(-1, 14),
        cut_off=options.cut_off,
    )
