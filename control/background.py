"""A thread that searches for paths while the control loop runs."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

from .collision_world import CollisionWorld
from .mesh_preparation import SWITCH_INTERVAL
from .mujoco_binding import mujoco
from .proximity_tables import kernel_arguments
from .search import SearchResult


class Worker:
    """One thread for searches. The compiled parts of a search run without Python's lock."""

    def __init__(self) -> None:
        sys.setswitchinterval(min(sys.getswitchinterval(), SWITCH_INTERVAL))
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="eyehand-search")

    def start(
        self, search: Callable[..., SearchResult], world: CollisionWorld, *arguments: object
    ) -> Future[SearchResult]:
        """Search in a copy of a world as it is now; return the future result."""
        return self._pool.submit(_run, search, WorldState(world), arguments)


class WorldState:
    """The state of a world at one moment, copied in less than 0.1 ms."""

    def __init__(self, world: CollisionWorld) -> None:
        self._fields = dict(vars(world))
        for name in ("_shapes", "_motion", "_obstacles", "_held", "_geoms"):
            self._fields[name] = self._fields[name].copy()
        data = world.tables.data
        self._mocap = data.mocap_pos.copy(), data.mocap_quat.copy()

    def make(self) -> CollisionWorld:
        """Return a world with buffers of its own, for another thread.

        It shares MuJoCo's model, which no search changes.
        """
        world = object.__new__(CollisionWorld)
        fields = vars(world)
        fields.update(self._fields)
        model = world.tables.model
        data = mujoco.MjData(model)
        data.qpos[:] = world.robot.home_qpos
        data.mocap_pos[:], data.mocap_quat[:] = self._mocap
        tables = replace(
            world.tables,
            model=model,
            data=data,
            shapes=self._fields["_shapes"],
            motion=self._fields["_motion"],
        )
        fields.update(
            robot=world.robot.duplicate(),
            tables=tables,
            _world=replace(self._fields["_world"], model=model, data=data),
            _arguments=kernel_arguments(tables),
        )
        world.proximity(world.robot.home)
        return world


def _run(search: Callable[..., SearchResult], state: WorldState, arguments: tuple) -> SearchResult:
    return search(state.make(), *arguments)
