"""The robot among obstacles: what is near in a posture, and what joint motion does about it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .collision_options import CollisionOptions
from .collision_pairs import candidate_pairs, parts_of
from .held_object import HeldObject, beside_frame, held_row
from .proximity import Proximity
from .proximity_kernels import near_pairs, pair_distance
from .proximity_tables import ProximityTables, kernel_arguments, shape_row
from .robot_model import RobotModel
from .shapes import ConvexMesh, check_pose, checked_obstacles
from .sphere_cover import cover_parts
from .world_spec import build_world, fill_slot

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike, NDArray
    from scipy.spatial.transform import RigidTransform

    from .shapes import Obstacle, Shape


SLOTS = 16
"""Obstacles that fit before the world is compiled anew, which takes a few ms."""


class CollisionWorld:
    """A robot and obstacles, which can be added, moved and removed between cycles.

    The robot's parts are the colliding geoms that controlled joints move (all geoms if none
    collides). Obstacles are those given here and whatever else collides in the robot's file.
    Primitives go into prepared slots in a fraction of a millisecond; a :class:`ConvexMesh` must be
    compiled into the model, and so must the slots be when they run out (some ms).

    One world is for one thread: it computes in MuJoCo's buffers, and hands out copies.

    Parameters
    ----------
    robot
        The robot; its home posture tells which parts belong together.
    obstacles
        Obstacles to begin with.
    options
        Cut-off, slots, soft minimum.
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
        self._parts = parts_of(robot)
        self._obstacles: dict[str, Obstacle] = {}
        self._held: dict[str, HeldObject] = {}
        self._velocities: dict[str, NDArray[np.float64]] = {}
        self._geoms: dict[str, int] = {}
        self._slots = SLOTS
        for obstacle in checked_obstacles(obstacles):
            self._check_free(obstacle.name)
            self._obstacles[obstacle.name] = obstacle
        self._build()
        self._own_pairs, self.ignored = self._sort_own_pairs()
        self._list_pairs()

    tables: ProximityTables
    """Tables for the distance kernels; replaced when an object is added, attached or removed."""
    ignored: tuple[tuple[str, str], ...]
    """Names of pairs of the robot's file that are never measured, because at home they overlap, or
    are two parts of the robot nearer than ``self_margin``."""

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """Obstacles that were added, where they are now."""
        return tuple(self._obstacles.values())

    @property
    def held(self) -> tuple[HeldObject, ...]:
        """Objects that were attached."""
        return tuple(self._held.values())

    @property
    def pair_names(self) -> tuple[tuple[str, str], ...]:
        """Names of all pairs that are measured when near."""
        return self.tables.names

    def add(self, obstacle: Obstacle) -> None:
        """Add an obstacle; a mesh, or more obstacles than slots, compiles the world anew.

        Raises
        ------
        InputError
            If it is no obstacle, or its name is taken.
        """
        checked_obstacles([obstacle])
        self._check_free(obstacle.name)
        self._obstacles[obstacle.name] = obstacle
        self._place_new(obstacle.name, obstacle.shape)

    def move(self, name: str, pose: RigidTransform, velocity: ArrayLike | None = None) -> None:
        """Move an obstacle.

        Parameters
        ----------
        name
            Its name.
        pose
            Its frame in the world (T_world_obstacle).
        velocity
            Its twist [v; ω] (6,) at its origin, world axes, m/s and rad/s; it holds until the next
            move, and None is standing still. The obstacle is not moved by it: distances change by
            the ``drift`` it causes.

        Raises
        ------
        InputError
            If the name is unknown, or the pose or velocity is not finite.
        """
        obstacle = self._known(name)
        check_pose(pose, name)
        twist = np.zeros(6) if velocity is None else _twist(velocity, name)
        self._obstacles[name] = replace(obstacle, pose=pose)
        self._velocities[name] = twist
        self._put(name)

    def remove(self, name: str) -> None:
        """Remove an obstacle.

        Raises
        ------
        InputError
            If the name is unknown.
        """
        self._known(name)
        del self._obstacles[name]
        self._velocities.pop(name, None)
        del self._geoms[name]
        self._list_pairs()

    def attach(self, name: str, shape: Shape, pose: RigidTransform) -> None:
        """Attach an object to the robot. It is then a part of the robot in all distances.

        Parts of the robot that carry the frame or hang on it are not measured against it: they
        may touch what they hold.

        Parameters
        ----------
        name
            Name of the object; an obstacle of this name is to be removed first.
        shape
            Its shape, in its own frame.
        pose
            Its frame in the controlled frame (T_frame_object).

        Raises
        ------
        InputError
            If the name is taken, or the shape or pose is none.
        """
        held = HeldObject(name, shape, pose)
        self._check_free(name)
        self._held[name] = held
        self._place_new(name, shape)

    def detach(self, name: str) -> None:
        """Detach an object. Add an obstacle at its new place if it is needed.

        Raises
        ------
        InputError
            If the name is unknown.
        """
        if name not in self._held:
            raise InputError(f"unknown held object {name!r}; there are: {_listed(self._held)}")
        del self._held[name]
        del self._geoms[name]
        self._list_pairs()

    def proximity(self, q: ArrayLike) -> Proximity:
        """Measure all pairs nearer than the cut-off at joint positions ``q`` (n,).

        Raises
        ------
        InputError
            If q is not n finite numbers.
        """
        q = self.robot.checked(q)
        found = near_pairs(q, *self._arguments)
        index, distance, normal, on_robot, on_other, rows, drift = found
        # The frozen constructor would take as long as several distances.
        proximity = object.__new__(Proximity)
        vars(proximity).update(
            names=tuple([self.tables.names[pair] for pair in index.tolist()]),
            distance=distance,
            normal=normal,
            on_robot=on_robot,
            on_other=on_other,
            rows=rows,
            drift=drift,
        )
        return proximity

    def _place_new(self, name: str, shape: Shape) -> None:
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
            self._put(name, shape)
        self._list_pairs()

    def _build(self) -> None:
        """Compile robot, slots and meshes, and put every obstacle in its place."""
        shapes = {one.name: one.shape for one in (*self.obstacles, *self.held)}
        meshes = {n: shape for n, shape in shapes.items() if isinstance(shape, ConvexMesh)}
        while len(shapes) - len(meshes) > self._slots:
            self._slots *= 2
        self._world = world = build_world(self.robot.spec, self._slots, list(meshes.values()))
        model, data = world.model, world.data
        data.qpos[:] = self.robot.home_qpos
        self._geoms = dict(zip(meshes, world.meshes, strict=True))
        plain = [name for name in shapes if name not in meshes]
        self._geoms.update(zip(plain, world.slots, strict=False))
        self._shapes = np.array([shape_row(model, geom) for geom in range(model.ngeom)])
        self._motion = np.zeros((model.ngeom, 9))
        self._spheres, self._covers = cover_parts(model, self._parts.robot, self.options.cover)
        for name in shapes:
            self._put(name, shapes[name])

    def _put(self, name: str, shape: Shape | None = None) -> None:
        """Bring an obstacle's pose and velocity, and its shape if new, to the model."""
        world, geom = self._world, self._geoms[name]
        if shape is not None and not isinstance(shape, ConvexMesh):
            fill_slot(world.model, geom, shape)
            self._shapes[geom] = shape_row(world.model, geom)
        if name in self._held:
            self._motion[geom] = 0.0
            return
        pose = self._obstacles[name].pose
        mocap = world.model.body_mocapid[world.model.geom_bodyid[geom]]
        world.data.mocap_pos[mocap] = pose.translation
        world.data.mocap_quat[mocap] = pose.rotation.as_quat(scalar_first=True)
        self._motion[geom, :3] = pose.translation
        self._motion[geom, 3:] = self._velocities.get(name, 0.0)

    def _sort_own_pairs(self) -> tuple[list[tuple[int, int]], tuple[tuple[str, str], ...]]:
        """Split the file's pairs into those to measure and those that belong together at home."""
        candidates = candidate_pairs(self.robot, self._parts)
        self._own_pairs = []
        self._list_pairs()
        self.proximity(self.robot.home)
        measured, ignored = [], []
        for a, b in candidates:
            margin = self.options.self_margin if b in self._parts.robot else 0.0
            distance = pair_distance(self.tables, a, b, 2.0 * self.options.self_margin + 1.0)
            if distance < margin:
                ignored.append((self._parts.names[a], self._parts.names[b]))
            else:
                measured.append((a, b))
        return measured, tuple(ignored)

    def _list_pairs(self) -> None:
        """List pairs and names after a shape was added or removed."""
        parts, robot, model = self._parts, self.robot, self._world.model
        names = {**parts.names, **{geom: name for name, geom in self._geoms.items()}}
        moves = np.zeros((model.ngeom, robot.n), dtype=bool)
        moves[: len(parts.moves)] = parts.moves
        held = [self._geoms[name] for name in self._held]
        moves[held] = robot.moves[robot.frame_body]
        obstacles = [self._geoms[name] for name in self._obstacles]
        pairs = list(self._own_pairs)
        pairs += [(a, b) for a in (*parts.robot, *held) for b in obstacles]
        near = beside_frame(robot, parts) if held else set()
        pairs += [
            (a, b)
            for a in held
            for b in (*parts.robot, *parts.fixed)
            if b not in near and not np.array_equal(moves[a], moves[b])
        ]
        # A cover is that of the first of two parts.
        pairs = [(b, a) if self._covers[b, 1] > self._covers[a, 1] else (a, b) for a, b in pairs]
        cover = self.options.cover
        self.tables = ProximityTables(
            model=model,
            data=self._world.data,
            joints=robot.joint_table,
            moves=moves,
            shapes=self._shapes,
            motion=self._motion,
            pairs=np.array(pairs, dtype=np.int64).reshape(-1, 2),
            names=tuple((names[a], names[b]) for a, b in pairs),
            held=np.array(
                [held_row(robot, model, self._geoms[one.name], one.pose) for one in self.held]
            ).reshape(-1, 14),
            spheres=self._spheres,
            covers=self._covers,
            probe=self._world.probe,
            sharpness=cover.sharpness if cover else 1.0,
            cut_off=self.options.cut_off,
        )
        self._arguments = kernel_arguments(self.tables)

    def _check_free(self, name: str) -> None:
        taken = {**self._obstacles, **self._held}
        if name in taken:
            raise InputError(f"the name {name!r} is taken; in the world are: {_listed(taken)}")
        if name in self._parts.names.values():
            raise InputError(f"the name {name!r} is that of a part in the robot's file")

    def _known(self, name: str) -> Obstacle:
        if name not in self._obstacles:
            raise InputError(f"unknown obstacle {name!r}; there are: {_listed(self._obstacles)}")
        return self._obstacles[name]


def _twist(velocity: ArrayLike, name: str) -> NDArray[np.float64]:
    try:
        twist = np.array(velocity, dtype=np.float64)
    except (TypeError, ValueError):
        twist = np.empty(0)
    if twist.shape != (6,) or not np.all(np.isfinite(twist)):
        raise InputError(f"{name}: the velocity must be 6 finite numbers [v; ω], got {velocity!r}")
    return twist


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"
