"""Observe a doubtful object once more with a camera on the wrist, from the most useful side."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.control import ApproachController
from eyehand.control.tasks import AxisAlignment, Position
from eyehand.errors import DeviceError, InputError

from .motion import TURN_SPEED, execute, unexpected_contact, with_speed
from .pick_state import TRANSIT_SPEED, PickState
from .reachable import is_reachable
from .report import PhaseRecord
from .scene_fusion import fuse_scenes
from .scene_validation import validate_scene

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from eyehand.perception import Scene, SceneObject

    from .cell import Cell
    from .pick_state import SelectedGrasp
    from .plan import GraspPlan
    from .robot import Camera
    from .tray import Tray

DOUBTFUL_SCORE = 0.25
"""Score of a grasp below which it is doubtful. In development piles 68 % of such picks succeed, and
98 % of the others."""
VIEW_DISTANCE = 0.40
"""Distance of the camera from the object, m. Depth cameras need 0.3 m."""
ELEVATIONS = (35.0, 55.0, 75.0)
"""Elevations of the views, degrees."""
AZIMUTHS = 12
"""Number of views at each elevation."""
MAX_TRIES = 8
"""Maximum number of views whose reachability is checked, the most useful first."""
VIEW_TOLERANCE = 0.01
"""Error at which a view counts as reached, m or rad."""
VIEW_SECONDS = 3.0
"""Time limit of the motion to a view, s."""
MIN_COSINE = 0.2
"""Cosine of the angle to a side's normal above which a view shows the side. Depth cameras give few
readings on surfaces that they graze."""
SIGHT_POINTS = 12
"""Number of points between camera and side at which neighbours are searched."""


@dataclass(frozen=True)
class WristCamera:
    """A depth camera that the hand carries."""

    camera: Camera
    """Its driver. The frames have the pose `T_world_camera` at the time of the capture, and no
    readings on the robot."""
    T_palm_camera: RigidTransform
    """Pose of the camera in the hand's frame."""


@dataclass(frozen=True)
class SecondView:
    """The result of a second view."""

    scene: Scene | None
    """The fused scene; None if the view was not reached or is not valid."""
    record: PhaseRecord
    """The motion."""
    compute_ms: float
    """Computing time, ms."""


def is_doubtful(plan: GraspPlan) -> bool:
    """Return whether a grasp will succeed so seldom that a second view may help."""
    return plan.score.total < DOUBTFUL_SCORE


def view_again(cell: Cell, wrist: WristCamera, grasp: SelectedGrasp) -> SecondView:
    """Move the wrist camera to the most useful view of an object, and fuse what it shows.

    The hand already has the pre-shape of the grasp, so that it turns and moves once.

    Parameters
    ----------
    cell
        The robot with an empty hand.
    wrist
        Its wrist camera.
    grasp
        The doubtful grasp, with its scene and object.
    """
    start, began = cell.enter("view"), time.perf_counter()
    state = PickState(grasp)
    controller = _controller(cell, wrist, state)
    computed = time.perf_counter() - began
    fused, outcome = None, "the arm reaches no view of the object"
    if controller is not None:
        shape = cell.hand.preshape(state.plan.opening, state.prototype)
        outcome = execute(
            cell,
            controller,
            cell.options.time_limit(VIEW_SECONDS),
            command=lambda _: shape,
            stop=lambda reading: unexpected_contact(cell, reading),
        ).reason
    if not outcome:
        began = time.perf_counter()
        fused, outcome = _observe(cell, wrist, grasp)
        computed += time.perf_counter() - began
    record = PhaseRecord("view", start, cell.reading.time, outcome or "done")
    return SecondView(fused, record, 1e3 * computed)


def view_directions(scene: Scene, target: SceneObject) -> NDArray[np.float64]:
    """Return unit directions (K, 3) from an object to the camera, the most useful first.

    A view is worth the sum of the variances of the sides of the solid that it shows, because it
    measures them. It does not show a side behind a neighbour, or the one on the support. Without
    a solid, the views farthest from the first one come first.
    """
    directions = _sphere()
    if target.fit.superquadric is None:
        to_camera = scene.view_origin - target.points.mean(axis=0)
        return directions[np.argsort(directions @ to_camera)]
    others = [
        solid for item in scene.objects if item.label != target.label for solid in item.fit.parts
    ]
    centre = target.fit.superquadric.centre
    worth = np.zeros(len(directions))
    for side in target.fit.sides:
        middle = centre + side.position * side.direction
        away = centre + VIEW_DISTANCE * directions - middle
        shown = away @ side.direction > MIN_COSINE * np.linalg.norm(away, axis=1)
        shares = np.linspace(0.0, 1.0, SIGHT_POINTS + 2)[1:-1]
        sight = middle + shares[:, None, None] * away
        for solid in others:
            shown &= ~solid.contains(sight.reshape(-1, 3)).reshape(sight.shape[:2]).any(axis=0)
        worth += side.sigma**2 * shown
    return directions[np.argsort(-worth, kind="stable")]


def _sphere() -> NDArray[np.float64]:
    """Return the directions of all views and the one straight up, (K, 3)."""
    rise, turn = np.meshgrid(np.radians(ELEVATIONS), 2.0 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS)
    level = np.cos(rise)
    rings = np.stack([level * np.cos(turn), level * np.sin(turn), np.sin(rise)], axis=-1)
    return np.vstack([rings.reshape(-1, 3), [0.0, 0.0, 1.0]])


def _controller(cell: Cell, wrist: WristCamera, state: PickState) -> ApproachController | None:
    """Return a controller to the most useful view that the arm reaches; None without one."""
    target = state.grasp.target
    solid = target.fit.superquadric
    centre = target.points.mean(axis=0) if solid is None else solid.centre
    world = state.world(cell, "obstacle")
    control = replace(state.far_options(cell), tolerance=VIEW_TOLERANCE, retreats=0)
    lens, axis = wrist.T_palm_camera.translation, wrist.T_palm_camera.rotation.as_matrix()[:, 2]
    speed = cell.options.speed
    for direction in view_directions(state.grasp.scene, target)[:MAX_TRIES]:
        tasks = with_speed(
            (
                Position(centre + VIEW_DISTANCE * direction, lens),
                AxisAlignment(axis, -direction),
            ),
            speed * TRANSIT_SPEED,
            speed * TURN_SPEED,
        )
        if is_reachable(world, [tasks], cell.reading.q, control):
            return ApproachController(world, tasks, control)
    return None


def _observe(cell: Cell, wrist: WristCamera, grasp: SelectedGrasp) -> tuple[Scene | None, str]:
    """Return the scene fused with what the wrist camera shows, or None and the reason."""
    try:
        frame = wrist.camera.capture()
        second = without_tray(cell.perceive(frame), cell.tray)
        problem = validate_scene(frame, second, cell.tray)
    except (InputError, DeviceError) as error:
        return None, f"no valid depth image: {error}"
    return (
        (None, problem) if problem else (fuse_scenes(grasp.scene, second, grasp.target.label), "")
    )


def without_tray(scene: Scene, tray: Tray) -> Scene:
    """Return a scene without the objects in the tray."""
    objects = tuple(item for item in scene.objects if not tray.contains(item.points.mean(axis=0)))
    return replace(scene, objects=objects)
