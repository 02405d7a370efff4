"""The simulated world of a grasping cell: robot, table, tray, camera and free objects."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..mujoco_import import import_mujoco
from ..scenes.mesh_object import MeshObject, add_mesh_object
from ..scenes.tabletop_scene import TabletopObject
from ..scenes.tabletop_spec import tabletop_spec
from .cell_appearance import add_cell_visuals
from .grasp_cell import GraspCell
from .grasp_robot import GraspRobot
from .spec_assembly import match_options, set_base

STEP_S = 0.002
"""Physics step, s: longer steps lose held objects."""
IMPRATIO = 100.0
"""Stiffness of friction over that of normal contact: held objects do not creep."""
ROBOT_PREFIX = "robot_"
"""Prefix of the robot's names in the world."""

_NEAR_TRAY_M = 0.02
"""Points this close to the tray count as tray in a depth image."""


@dataclass(frozen=True, eq=False)
class GraspWorld:
    """A compiled world, made by :meth:`build`. Robots that run in it copy the model."""

    model: Any
    """`mujoco.MjModel`; bodies of objects carry their names, the robot's begin with ``robot_``."""
    objects: tuple[TabletopObject | MeshObject, ...]
    """Objects on the table, at the start."""
    robot: GraspRobot
    """Arm and hand."""
    cell: GraspCell
    """Poses of base, table, tray and camera."""
    friction: float | None
    """Sliding friction of the hand; None keeps the value of its file."""

    @classmethod
    def build(
        cls,
        objects: Sequence[TabletopObject | MeshObject],
        *,
        robot: GraspRobot | None = None,
        cell: GraspCell | None = None,
        friction: float | None = None,
    ) -> GraspWorld:
        """Build the world.

        Parameters
        ----------
        objects
            Objects on the table (`TabletopScene.objects`, meshes). Their names must differ, and
            none may stand in the place of the tray.
        robot
            Arm and hand; the LBR-like arm with the included hand if None.
        cell
            Poses of base, table, tray and camera.
        friction
            Sliding friction of the hand, which holds an object. Friction of objects on table and
            tray is that of `tabletop_spec`.

        Raises
        ------
        InputError
            If the friction is not positive, a name is taken twice, an object stands in the tray's
            place, or the robot's files cannot be read or put together.
        """
        robot, cell = robot or GraspRobot(), cell or GraspCell()
        objects = tuple(objects)
        _check(objects, friction)
        for item in objects:
            cell.check_clear(item.name, *_ball(item))
        mujoco = import_mujoco()
        simple = [item for item in objects if isinstance(item, TabletopObject)]
        spec = tabletop_spec(simple, cell.table, free=True, visuals=True)
        for item in objects:
            if isinstance(item, MeshObject):
                add_mesh_object(spec, item)
        cell.add_furniture(spec)
        add_cell_visuals(spec, cell)
        arm = robot.spec(friction)
        match_options(spec, arm)
        set_base(arm, cell.T_world_base)
        spec.attach(arm, prefix=ROBOT_PREFIX, frame=spec.worldbody.add_frame())
        option = spec.option
        option.timestep, option.impratio = STEP_S, IMPRATIO
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.cone, option.solver = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtSolver.mjSOL_NEWTON
        # An unstable simulation must report it instead of resetting itself.
        option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        try:
            model = spec.compile()
        except ValueError as error:
            reason = " ".join(str(error).split())
            raise InputError(f"MuJoCo cannot compile the cell: {reason}") from None
        if robot.hand_prefix and robot.jaws is None:
            _compensate_hand_weight(model, ROBOT_PREFIX + robot.hand_prefix)
        return cls(model, objects, robot, cell, friction)

    @property
    def object_names(self) -> tuple[str, ...]:
        """Names of the objects."""
        return tuple(item.name for item in self.objects)

    @property
    def hand_prefix(self) -> str:
        """Prefix of the hand's names in the model."""
        return ROBOT_PREFIX + self.robot.hand_prefix

    def copy_model(self) -> Any:
        """Return a copy of the model, because drives change it while they run."""
        return copy.copy(self.model)

    def is_near_tray(self, points: NDArray[np.float64]) -> Any:
        """Return which points (…, 3), world, m, lie at or over the tray, (…,) bool."""
        near = replace(self.cell, tray_wall=self.cell.tray_wall + _NEAR_TRAY_M)
        return near.is_over_tray(points)


def _compensate_hand_weight(model: Any, prefix: str) -> None:
    """Compensate the weight of the whole hand, as an arm's controller does for its tool."""
    for body in range(1, model.nbody):
        parent = model.body(int(model.body_parentid[body])).name
        if model.body(body).name.startswith(prefix) and not parent.startswith(prefix):
            model.body_gravcomp[body] = model.body_subtreemass[body] / model.body_mass[body]


def _ball(item: TabletopObject | MeshObject) -> tuple[NDArray[np.float64], float]:
    """Return centre (3,), m, and radius, m, of a ball around an object."""
    if isinstance(item, MeshObject):
        return item.centre, item.radius
    return item.shape.centre, float(np.linalg.norm(item.shape.semi_axes))


def _check(objects: Sequence[TabletopObject | MeshObject], friction: float | None) -> None:
    if friction is not None and not 0.0 < friction < 10.0:
        raise InputError(f"friction must lie in (0, 10), got {friction}")
    names = [item.name for item in objects]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise InputError(f"names of objects must differ; used twice: {', '.join(twice)}")
