"""The robot among obstacles: the distances of near parts, and their derivatives by the joints."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from .array_checks import checked_array
from .collision_pairs import find_collision_geoms, sort_pairs
from .held_object import HeldObject
from .mesh_preparation import MeshPreparation, meshes_of
from .obstacle_motion import ObstacleMotions
from .options import CollisionOptions
from .proximity import Proximity, proximity_of
from .proximity_kernels import near_pairs, pair_distance
from .proximity_tables import ProximityTables, kernel_arguments, shape_row
from .robot_model import RobotModel
from .shapes import ConvexMesh, Obstacle, Shape, check_pose, checked_obstacles
from .world_spec import WorldModel, fill_slot
from .world_tables import AddedGeoms, GeomArrays, build_tables

SLOTS = 16
"""Number of prepared geoms for obstacles. When they are all in use, the world is compiled again
with twice as many, which takes a few ms."""


class CollisionWorld:
    """A robot and obstacles, which can be added, moved and removed between control cycles.

    The parts of the robot are the colliding geoms that controlled joints move (all its geoms if
    none collides). Obstacles are those added here and all other colliding geoms of the robot's
    file. A primitive shape takes a prepared geom (a slot) in a fraction of a millisecond. A
    :class:`ConvexMesh` has to be compiled into the model, which takes a few ms.

    One world is for one thread, because it computes in MuJoCo's buffers. Its results are copies.

    Parameters
    ----------
    robot
        The robot. Parts that are in contact in its home posture are never checked for collision.
    obstacles
        Obstacles at the start.
    options
        Options of the distances.

    Raises
    ------
    InputError
        If the robot or an obstacle is of another type, a name is taken, or MuJoCo cannot compute
        distances to a geom of the robot's file.
    """

    def __init__(
        self,
        robot: RobotModel,
        obstacles: Iterable[Obstacle] = (),
        *,
        options: CollisionOptions | None = None,
    ) -> None:
        if not isinstance(robot, RobotModel):
            raise InputError(f"the world needs a robot from RobotModel.load, got {robot!r}")
        self.robot = robot
        self.options = options or CollisionOptions()
        self._file_geoms = find_collision_geoms(robot)
        self._obstacles: dict[str, Obstacle] = {}
        self._held: dict[str, HeldObject] = {}
        self._preparation = MeshPreparation(robot)
        self._motions = ObstacleMotions()
        self._geoms: dict[str, int] = {}
        self._slots = SLOTS
        for obstacle in checked_obstacles(obstacles):
            self._check_free(obstacle.name)
            self._obstacles[obstacle.name] = obstacle
        self._build()
        self._file_pairs, self.ignored = self._sort_file_pairs()
        self._update_tables()

    tables: ProximityTables
    """Tables for the distance kernels; replaced when an object is added, attached or removed."""
    ignored: tuple[tuple[str, str], ...]
    """Names of pairs in the robot's file that are never checked. They overlap in the home posture,
    or are two parts of the robot nearer than ``self_margin`` there, or always nearer than 10 mm."""

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The added obstacles with their current poses."""
        return tuple(self._obstacles.values())

    @property
    def held(self) -> tuple[HeldObject, ...]:
        """The attached objects."""
        return tuple(self._held.values())

    @property
    def preparing(self) -> bool:
        """Whether a box stands for a mesh that a thread compiles."""
        return self._preparation.waiting

    @property
    def pair_names(self) -> tuple[tuple[str, str], ...]:
        """Names of all pairs whose distance is computed when they are near."""
        return self.tables.names

    def add(self, obstacle: Obstacle, *, background: bool = False) -> None:
        """Add an obstacle. A mesh, or a lack of free slots, compiles the world again.

        With ``background``, a thread compiles a mesh. Its bounding box stands for it until the
        first control cycle after that.

        Raises
        ------
        InputError
            If it is not an obstacle, or its name is taken.
        """
        checked_obstacles([obstacle])
        self._check_free(obstacle.name)
        self._obstacles[obstacle.name] = obstacle
        if background and isinstance(obstacle.shape, ConvexMesh):
            self._preparation.begin(obstacle.name, obstacle.shape)
        self._insert(obstacle.name, self._preparation.shapes([obstacle])[obstacle.name])
        if self.preparing:
            self._take_meshes()

    def move(self, name: str, pose: RigidTransform, velocity: ArrayLike | None = None) -> None:
        """Move an obstacle.

        Parameters
        ----------
        name
            Name of the obstacle.
        pose
            Its new pose in the world (T_world_obstacle).
        velocity
            Its twist [v; ω] (6,) at its origin, world axes, m/s and rad/s, the cause of
            :attr:`Proximity.drift`. It is valid until the next move, and does not move the
            obstacle. None estimates it from the poses since earlier control cycles. Between two
            poses the obstacle then moves on with this velocity, for 0.25 s at most.

        Raises
        ------
        InputError
            If the name is unknown, or the pose or velocity is not finite.
        """
        obstacle = self._known(name)
        check_pose(pose, name)
        if velocity is None:
            self._motions.observe(name, pose)
        else:
            self._motions.give(name, checked_array(f"{name}: velocity [v; ω]", velocity, (6,)))
        self._obstacles[name] = replace(obstacle, pose=pose)
        self._update_geom(name)

    def velocity(self, name: str) -> tuple[NDArray[np.float64], float]:
        """Return the twist [v; ω] (6,) of an obstacle, and the standard deviation of v, m/s.

        Raises
        ------
        InputError
            If the name is unknown.
        """
        self._known(name)
        return self._motions.twist(name), self._motions.deviation(name)

    def advance(self, dt: float) -> None:
        """Advance the time of the control cycles by dt, s. :class:`ApproachController` calls it."""
        for name, shift in self._motions.advance(dt):
            self._update_geom(name, shift=shift)
        if self._preparation.waiting:
            self._take_meshes()

    def remove(self, name: str) -> None:
        """Remove an obstacle.

        Raises
        ------
        InputError
            If the name is unknown.
        """
        self._known(name)
        del self._obstacles[name]
        self._motions.forget(name)
        self._preparation.forget(name)
        del self._geoms[name]
        self._update_tables()

    def attach(self, name: str, shape: Shape, pose: RigidTransform) -> None:
        """Attach an object to the robot. It then counts as a part of the robot.

        The object is not checked for collision with the parts that may touch it. They are on the
        body of the controlled frame, on its parent, and on all bodies that hang on it.

        Parameters
        ----------
        name
            Name of the object. Remove an obstacle of the same name first.
        shape
            Its shape, in its own frame.
        pose
            Its pose in the controlled frame (T_frame_object).

        Raises
        ------
        InputError
            If the name is taken, or the shape or pose is invalid.
        """
        held = HeldObject(name, shape, pose)
        self._check_free(name)
        self._held[name] = held
        self._insert(name, shape)

    def detach(self, name: str) -> None:
        """Detach an object from the robot. It is then no longer in the world.

        Raises
        ------
        InputError
            If the name is unknown.
        """
        if name not in self._held:
            raise InputError(f"unknown held object {name!r}; there are: {_listed(self._held)}")
        del self._held[name]
        del self._geoms[name]
        self._update_tables()

    def proximity(self, q: ArrayLike) -> Proximity:
        """Compute the distances of all pairs nearer than the cut-off at joint positions q (n,).

        Raises
        ------
        InputError
            If q is not n finite numbers.
        """
        return proximity_of(near_pairs(self.robot.checked(q), *self._arguments), self.pair_names)

    def _insert(self, name: str, shape: Shape) -> None:
        """Put a new object into a free slot, or compile the world again."""
        used = set(self._geoms.values())
        free = [geom for geom in self._world.slots if geom not in used]
        if isinstance(shape, ConvexMesh) or not free:
            try:
                self._build()
            except InputError:
                self._obstacles.pop(name, None)
                self._held.pop(name, None)
                raise
        else:
            self._geoms[name] = free[0]
            self._update_geom(name, shape)
        self._update_tables()

    def _build(self) -> None:
        """Compile robot, slots and meshes."""
        shapes = self._preparation.shapes((*self.obstacles, *self.held))
        meshes = meshes_of(shapes)
        while len(shapes) - len(meshes) > self._slots:
            self._slots *= 2
        self._install(self._preparation.build(self._slots, tuple(meshes.values())))

    def _take_meshes(self) -> None:
        """Use the meshes of the background as soon as they are compiled."""
        meshes = meshes_of({one.name: one.shape for one in (*self.obstacles, *self.held)})
        world = self._preparation.compiled(self._slots, tuple(meshes.values()))
        if world is not None:
            self._install(world)
            self._update_tables()

    def _install(self, world: WorldModel) -> None:
        """Use a compiled world, and set the pose of every object."""
        self._world, model = world, world.model
        shapes = self._preparation.shapes((*self.obstacles, *self.held))
        meshes = meshes_of(shapes)
        world.data.qpos[:] = self.robot.home_qpos
        primitives = [name for name in shapes if name not in meshes]
        self._geoms = dict(zip(meshes, world.meshes, strict=True))
        self._geoms.update(zip(primitives, world.slots, strict=False))
        self._shapes = np.array([shape_row(model, geom) for geom in range(model.ngeom)])
        self._motion = np.zeros((model.ngeom, 9))
        for name, shape in shapes.items():
            self._update_geom(name, shape)

    def _update_geom(
        self, name: str, shape: Shape | None = None, *, shift: ArrayLike = 0.0
    ) -> None:
        """Write pose, shifted (3,), and velocity of an object into the model, and a new shape."""
        world, geom = self._world, self._geoms[name]
        if shape is not None and not isinstance(shape, ConvexMesh):
            fill_slot(world.model, geom, shape)
            self._shapes[geom] = shape_row(world.model, geom)
        if name in self._held:
            self._motion[geom] = 0.0
            return
        pose = self._preparation.pose(name, self._obstacles[name].pose)
        mocap = world.model.body_mocapid[world.model.geom_bodyid[geom]]
        world.data.mocap_pos[mocap] = pose.translation + shift
        world.data.mocap_quat[mocap] = pose.rotation.as_quat(scalar_first=True)
        self._motion[geom, :3] = pose.translation + shift
        self._motion[geom, 3:] = self._motions.twist(name)

    def _sort_file_pairs(self) -> tuple[list[tuple[int, int, int]], tuple[tuple[str, str], ...]]:
        """Return the pairs of the robot's file to check, and the names of those to ignore."""
        self._file_pairs = []
        self._update_tables()
        margin = self.options.self_margin
        return sort_pairs(self.robot, self._file_geoms, margin, self._distances)

    def _distances(
        self, q: NDArray[np.float64], pairs: Sequence[tuple[int, int]]
    ) -> NDArray[np.float64]:
        """Return the distances (P,) of P pairs of geoms at joint positions q (n,), m, at most 1."""
        # This call also computes the poses.
        self.proximity(q)
        return np.array([pair_distance(self.tables, a, b, 1.0) for a, b in pairs])

    def _update_tables(self) -> None:
        """List the pairs and their names again after an object was added or removed."""
        added = AddedGeoms(
            {name: self._geoms[name] for name in self._obstacles},
            {name: self._geoms[name] for name in self._held},
            self.held,
        )
        arrays = GeomArrays(self._shapes, self._motion)
        file = self._file_geoms, self._file_pairs
        self.tables = build_tables(self.robot, self._world, *file, added, arrays, self.options)
        self._arguments = kernel_arguments(self.tables)

    def _check_free(self, name: str) -> None:
        taken = {**self._obstacles, **self._held}
        if name in taken:
            raise InputError(f"the name {name!r} is taken; the world contains: {_listed(taken)}")
        if name in self._file_geoms.names.values():
            raise InputError(f"the name {name!r} is taken by a part of the robot's file")

    def _known(self, name: str) -> Obstacle:
        if name not in self._obstacles:
            raise InputError(f"unknown obstacle {name!r}; there are: {_listed(self._obstacles)}")
        return self._obstacles[name]


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"
