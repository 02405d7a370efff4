"""Meshes that a thread compiles into the world, and the boxes that stand for them meanwhile."""

from __future__ import annotations

import sys
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING

from scipy.spatial.transform import RigidTransform

from .shapes import Box, ConvexMesh
from .world_spec import build_world

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from .held_object import HeldObject
    from .robot_model import RobotModel
    from .shapes import Obstacle, Shape
    from .world_spec import WorldModel

SWITCH_INTERVAL = 1e-4
"""Time after which Python hands over to a waiting thread, s. At Python's default of 5 ms, the
control loop would wait up to five periods for a thread."""


class MeshPreparation:
    """The meshes of a world that are not compiled yet. MuJoCo compiles without Python's lock."""

    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot
        self._boxes: dict[str, tuple[Box, RigidTransform]] = {}
        self._slots = 0
        self._meshes: tuple[ConvexMesh, ...] = ()
        self._result: Future[WorldModel] | None = None
        self._pool: ThreadPoolExecutor | None = None

    @property
    def waiting(self) -> bool:
        """Whether a mesh is not compiled yet."""
        return bool(self._boxes)

    def begin(self, name: str, mesh: ConvexMesh) -> None:
        """Let the bounding box of a mesh stand for it."""
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        middle = RigidTransform.from_translation(0.5 * (low + high))
        self._boxes[name] = (Box(0.5 * (high - low)), middle)

    def forget(self, name: str) -> None:
        """Forget a mesh that was removed."""
        self._boxes.pop(name, None)

    def shapes(self, objects: Iterable[Obstacle | HeldObject]) -> dict[str, Shape]:
        """Return the shape of each object by name, or the box that stands for it."""
        boxes = {name: box for name, (box, _) in self._boxes.items()}
        return {one.name: boxes.get(one.name, one.shape) for one in objects}

    def pose(self, name: str, pose: RigidTransform) -> RigidTransform:
        """Return the pose of what stands for an obstacle with this pose."""
        return pose * self._boxes[name][1] if name in self._boxes else pose

    def build(self, slots: int, meshes: tuple[ConvexMesh, ...]) -> WorldModel:
        """Compile the robot with empty slots and meshes."""
        return build_world(self._robot, slots, meshes)

    def compiled(self, slots: int, wanted: tuple[ConvexMesh, ...]) -> WorldModel | None:
        """Return the world with all meshes if it is compiled; otherwise start the thread.

        A result for other meshes than the wanted ones is discarded.
        """
        if self._result is not None and self._result.done():
            world, self._result = self._result.result(), None
            same = slots == self._slots and len(wanted) == len(self._meshes)
            if same and all(a is b for a, b in zip(wanted, self._meshes, strict=True)):
                self._boxes.clear()
                return world
        if self._result is None:
            if self._pool is None:
                sys.setswitchinterval(min(sys.getswitchinterval(), SWITCH_INTERVAL))
                self._pool = ThreadPoolExecutor(1, thread_name_prefix="eyehand-mesh")
            self._slots, self._meshes = slots, wanted
            self._result = self._pool.submit(self.build, slots, wanted)
        return None


def meshes_of(shapes: Mapping[str, Shape]) -> dict[str, ConvexMesh]:
    """Return the meshes among shapes by name."""
    return {name: shape for name, shape in shapes.items() if isinstance(shape, ConvexMesh)}
