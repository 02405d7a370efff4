"""The world of the public clutter-removal protocol: a table, objects, and a floating gripper.

Source: the simulation of VGN (Breyer et al. 2020) and GIGA (Jiang et al. 2021), in PyBullet. This
one is in MuJoCo. The world's origin is the middle of the workspace on the table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.grasping.hands import ParallelHand

from ..mujoco_import import import_mujoco
from ..scenes.piece_object import PHYSICS_GROUP, PieceObject, add_piece_object, set_grip_contact
from .floating_hand import AXES, FINGERS, PALM, add_floating_hand

WORKSPACE = 0.3
"""Side of the workspace, m."""
BELOW_TABLE = 0.05
"""Depth of the workspace below the table, m."""
TIMESTEP = 0.002
QUIET_SPEED = 0.01
"""Objects slower than this are at rest, m/s and rad/s, as in the original."""
CHECK_TIME = 0.25
"""Time between two checks whether the objects are at rest, s."""
BOX_SIDE, BOX_HEIGHT, BOX_WALL = 0.26, 0.3, 0.02
"""Walls around a pile while it falls, m. They are removed before the first frame."""
PARKING = 50.0
"""Distance of everything that is not in the scene, m."""
CONTACT_DEPTH = 1e-5
"""Least penetration that counts as a contact, m."""


@dataclass(frozen=True)
class Touch:
    """A contact of the hand."""

    part: str
    """Body of the hand."""
    object: int
    """Index of the object, or -1 for the table."""


class ClutterWorld:
    """State of the simulated world. Objects are parked until they are placed."""

    def __init__(
        self,
        objects: Sequence[PieceObject],
        hand: ParallelHand,
        *,
        force: float,
        friction: float = 1.0,
        walls: bool = False,
    ) -> None:
        """Compile the world.

        Parameters
        ----------
        objects
            All objects that may be placed, in their final size.
        hand
            The gripper.
        force
            Maximum closing force of each finger, N.
        friction
            Coulomb friction of all pairs.
        walls
            Whether the four walls for dropping a pile stand at the beginning.
        """
        mujoco = self._mujoco = import_mujoco()
        spec = mujoco.MjSpec()
        spec.option.timestep = TIMESTEP
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.impratio = 100.0
        table = spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE)
        table.size = [2.0, 2.0, 0.1]
        set_grip_contact(table, friction)
        _add_walls(mujoco, spec, friction)
        self.names = [f"object_{number}" for number in range(len(objects))]
        for name, item in zip(self.names, objects, strict=True):
            add_piece_object(spec, item, name, friction)
        add_floating_hand(spec, hand, force=force, friction=friction)
        self.objects = tuple(objects)
        self.hand = hand
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.placed: set[int] = set()
        self._index()
        self._enable_walls(walls)
        for number in range(len(objects)):
            self._enable(number, on=False)
            self._park(number)
        self.park_hand()

    def _index(self) -> None:
        """Find the addresses of objects, geoms and actuators in the model."""
        model = self.model
        bodies = {model.body(name).id: number for number, name in enumerate(self.names)}
        self._object_of_geom = np.array([bodies.get(b, -1) for b in model.geom_bodyid])
        hand = {model.body(name).id: name for name in (PALM, *FINGERS)}
        self._part_of_geom = [hand.get(b, "") for b in model.geom_bodyid]
        self._qpos = [model.joint(name).qposadr[0] for name in self.names]
        self._qvel = [model.joint(name).dofadr[0] for name in self.names]
        self._base = [model.joint(f"hand_{axis}").qposadr[0] for axis in AXES]
        self._base_dof = [model.joint(f"hand_{axis}").dofadr[0] for axis in AXES]
        self._base_servo = [model.actuator(f"hand_{axis}").id for axis in AXES]
        self._finger = [model.joint(name).qposadr[0] for name in FINGERS]
        self._finger_dof = [model.joint(name).dofadr[0] for name in FINGERS]
        self._finger_servo = [model.actuator(name).id for name in FINGERS]
        self._palm = model.body(PALM).id
        group = np.asarray(model.geom_group)
        self._pieces = [
            np.flatnonzero((self._object_of_geom == number) & (group == PHYSICS_GROUP))
            for number in range(len(self.names))
        ]
        self._walls = [k for k in range(model.ngeom) if model.geom(k).name.startswith("wall_")]
        self._hand_geoms = [k for k, part in enumerate(self._part_of_geom) if part]
        self.labels = (self._object_of_geom + 1).astype(np.int32)

    @property
    def count(self) -> int:
        """Number of objects in the scene."""
        return len(self.placed)

    @property
    def width(self) -> float:
        """Distance between the pads, m."""
        return float(self.data.qpos[self._finger].sum())

    def place(self, number: int, T_world_object: RigidTransform) -> None:
        """Place an object at rest."""
        self._enable(number, on=True)
        self._put(number, T_world_object)
        self.placed.add(number)
        self._mujoco.mj_forward(self.model, self.data)

    def remove(self, number: int) -> None:
        """Take an object out of the scene."""
        self.placed.discard(number)
        self._enable(number, on=False)
        self._park(number)
        self._mujoco.mj_forward(self.model, self.data)

    def pose(self, number: int) -> RigidTransform:
        """Return T_world_object."""
        first = self._qpos[number]
        qpos = self.data.qpos[first : first + 7]
        return RigidTransform.from_components(
            qpos[:3], Rotation.from_quat(qpos[3:], scalar_first=True)
        )

    def vertices(self, number: int) -> NDArray[np.float64]:
        """Return the vertices of an object's surface in the world, (V, 3), m."""
        return self.pose(number).apply(self.objects[number].vertices)

    def touching(self, number: int) -> bool:
        """Return whether an object touches anything."""
        return any(
            number in (self._object_of_geom[a], self._object_of_geom[b])
            for a, b in self._contacts()
        )

    def hand_touches(self) -> list[Touch]:
        """Return the contacts of the hand."""
        found = []
        for a, b in self._contacts():
            for part, other in ((a, b), (b, a)):
                if self._part_of_geom[part]:
                    found.append(Touch(self._part_of_geom[part], int(self._object_of_geom[other])))
        return found

    def rest(self, timeout: float = 2.0) -> None:
        """Simulate until all objects are at rest, or for a time, s."""
        ends = self.data.time + timeout
        while self.data.time < ends:
            self.step(CHECK_TIME)
            speeds = [
                np.linalg.norm(self.data.qvel[self._qvel[k] : self._qvel[k] + 6])
                for k in self.placed
            ]
            if max(speeds, default=0.0) < QUIET_SPEED:
                break

    def rest_and_remove(self) -> list[int]:
        """Let the objects come to rest; remove and return those that left the workspace."""
        gone: list[int] = []
        while True:
            self.rest()
            left = [k for k in sorted(self.placed) if _outside(self.pose(k).translation)]
            for number in left:
                self.remove(number)
            gone += left
            if not left:
                return gone

    def remove_walls(self) -> None:
        """Remove the walls around a pile."""
        self._enable_walls(False)

    def set_hand(self, T_world_tcp: RigidTransform, opening: float) -> None:
        """Put the hand at a pose, at rest and open."""
        turn = T_world_tcp.rotation.as_quat(scalar_first=True)
        self.model.body_quat[self._palm] = turn
        self.data.qpos[self._base] = self.data.ctrl[self._base_servo] = T_world_tcp.translation
        self.data.qvel[self._base_dof] = 0.0
        self.data.qpos[self._finger] = self.data.ctrl[self._finger_servo] = 0.5 * opening
        self.data.qvel[self._finger_dof] = 0.0
        for geom in self._hand_geoms:
            self.model.geom_contype[geom] = self.model.geom_conaffinity[geom] = 1
        self._mujoco.mj_forward(self.model, self.data)

    def park_hand(self) -> None:
        """Take the hand out of the scene."""
        far = RigidTransform.from_translation([PARKING, 0.0, PARKING])
        self.set_hand(far, self.hand.stroke)
        for geom in self._hand_geoms:
            self.model.geom_contype[geom] = self.model.geom_conaffinity[geom] = 0

    def command(self, position: NDArray[np.float64], opening: float | None = None) -> None:
        """Command the tool centre point (3,), m, and the distance between the pads, m."""
        self.data.ctrl[self._base_servo] = position
        if opening is not None:
            self.data.ctrl[self._finger_servo] = 0.5 * opening

    def step(self, duration: float) -> None:
        """Simulate for a time, s."""
        for number in range(len(self.names)):
            if number not in self.placed:
                self._park(number)
        self._mujoco.mj_step(self.model, self.data, max(round(duration / TIMESTEP), 1))

    def _park(self, number: int) -> None:
        self._put(number, RigidTransform.from_translation([PARKING, number, PARKING]))

    def _put(self, number: int, pose: RigidTransform) -> None:
        first, speed = self._qpos[number], self._qvel[number]
        self.data.qpos[first : first + 3] = pose.translation
        self.data.qpos[first + 3 : first + 7] = pose.rotation.as_quat(scalar_first=True)
        self.data.qvel[speed : speed + 6] = 0.0

    def _enable(self, number: int, *, on: bool) -> None:
        for geom in self._pieces[number]:
            self.model.geom_contype[geom] = self.model.geom_conaffinity[geom] = int(on)

    def _enable_walls(self, on: bool) -> None:
        for geom in self._walls:
            self.model.geom_contype[geom] = self.model.geom_conaffinity[geom] = int(on)

    def _contacts(self) -> list[tuple[int, int]]:
        """Return the pairs of geoms in contact."""
        count = self.data.ncon
        deep = np.asarray(self.data.contact.dist[:count]) < -CONTACT_DEPTH
        pairs = np.asarray(self.data.contact.geom[:count])[deep]
        return [(int(a), int(b)) for a, b in pairs]


def _outside(position: NDArray[np.float64]) -> bool:
    x, y, z = position
    half = 0.5 * WORKSPACE
    return bool(max(abs(x), abs(y)) > half or not -BELOW_TABLE < z < WORKSPACE - BELOW_TABLE)


def _add_walls(mujoco: Any, spec: Any, friction: float) -> None:
    """Add the four walls of the box in which a pile falls."""
    middle = 0.5 * (BOX_SIDE + BOX_WALL)
    for number, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        wall = spec.worldbody.add_geom(
            name=f"wall_{number}", type=mujoco.mjtGeom.mjGEOM_BOX, group=PHYSICS_GROUP
        )
        wall.pos = [x * middle, y * middle, 0.5 * BOX_HEIGHT]
        along, across = 0.5 * BOX_SIDE + BOX_WALL, 0.5 * BOX_WALL
        wall.size = [across if x else along, across if y else along, 0.5 * BOX_HEIGHT]
        set_grip_contact(wall, friction)
