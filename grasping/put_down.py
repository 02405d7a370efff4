"""Poses in which a held object is released in the tray, and those that clear its content."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from eyehand.control.tasks import AxisAlignment, Orientation, Position, Task

from .hands import HandModel, ParallelHand
from .motion import TURN_SPEED, with_speed
from .pick_state import LIFT_SPEED, RETREAT_TOLERANCE
from .reachable import is_reachable
from .tray_clearance import Columns, clear_heights, lowest_points, opening_boxes, tray_columns
from .tray_plan import (
    JAW_DEPTH,
    SIDE_COSINE,
    UP,
    WALL_DISTANCE,
    HeldSize,
    TrayPlace,
    laid_size,
    measure_held,
    measure_places,
    plan_place,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from .cell import Cell
    from .pick_state import PickState

TURNS = np.radians(np.arange(-165, 181, 15))
"""Rotations of the hand about the vertical that are tried, rad."""
TURN_COST = 0.05
"""Length of a move of the object that costs as much as a turn by 1 rad, m."""
TRAY_CLEARANCE = 0.03
"""Height at which the object passes over the tray's walls, m."""
RAISE_STEP = 0.01
"""Difference of the heights of two releases below which the nearer one is used, m."""
MAX_RAISE = 0.1
"""Maximum height above its usual one at which an object is released, m."""
UNDER_MARGIN = 0.005
"""Distance from an object up to which a lower segment counts as under it, m."""


@dataclass(frozen=True)
class PutDown:
    """A pose in which the held object is released in the tray."""

    size: HeldSize
    """Size of the object in this pose."""
    place: TrayPlace
    """Its place."""
    alignment: AxisAlignment | Orientation
    """Task that keeps the object in its pose."""
    centre_in_palm: NDArray[np.float64]
    """Centre of the object in the palm's frame, (3,), m."""
    low: NDArray[np.float64]
    """Position of the centre at the release, (3,), world, m."""
    high: NDArray[np.float64]
    """Position from which it is lowered, (3,), world, m. It lies above tray and content, and not
    below the lifted object: a hidden part of the object may reach down to where the table was."""

    def tasks(self, goal: NDArray[np.float64]) -> tuple[Task, ...]:
        """Return the tasks that bring the object to `low` or `high`."""
        return Position(goal, self.centre_in_palm), self.alignment


def object_centre(state: PickState) -> NDArray[np.float64]:
    """Return the centre of the object before the grasp, (3,), m."""
    target = state.grasp.target
    solid = target.fit.superquadric
    centre: NDArray[np.float64] = target.points.mean(axis=0) if solid is None else solid.centre
    return centre


def _upright_size(state: PickState, centre: NDArray[np.float64]) -> HeldSize:
    """Return the size of the object as it stood on the table, with its hidden lower part.

    A solid may describe the upper part only, and another segment the lower part. Without a sense
    of the load, whatever is under the object counts as a part of it.
    """
    scene, target = state.grasp.scene, state.grasp.target
    solid = target.fit.superquadric
    if solid is None:
        away = target.points - centre
        radius = float(np.linalg.norm(away[:, :2], axis=1).max())
        low, high = float(away[:, 2].min()), float(away[:, 2].max())
        size = HeldSize(radius, 2.0 * radius, -low, high - low)
    else:
        size = measure_held(target.fit.parts or (solid,), centre)
    if scene.support is None:
        return size
    radius = size.radius
    hidden = float(scene.support.normal @ centre + scene.support.offset) - size.below
    for item in scene.objects if hidden > RETREAT_TOLERANCE else ():
        away = item.points[item.points[:, 2] < centre[2] - size.below] - centre
        beside = np.linalg.norm(away[:, :2], axis=1)
        if item.label == target.label or not (beside < size.radius + UNDER_MARGIN).any():
            continue
        if state.held is not None:
            return size
        radius = max(radius, float(beside.max()))
    hidden = max(hidden, 0.0)
    return replace(size, radius=radius, below=size.below + hidden, height=size.height + hidden)


def put_down_poses(cell: Cell, state: PickState) -> list[PutDown]:
    """Return the poses in which the object may be released, the preferred one first."""
    palm, centre = cell.palm_pose(), object_centre(state)
    fit, size = state.grasp.target.fit, _upright_size(state, centre)
    solid = fit.superquadric
    # The centre of the object is moved over its place. In a side grasp it is far from the palm.
    centre_in_palm = state.T_palm_world_at_grasp.apply(centre)
    # The object stays upright; its rotation about the vertical is free. A sphere has no upright
    # axis, so the palm faces down.
    sphere = solid is not None and solid.kind == "sphere" and len(fit.parts) < 2
    axis = -UP if sphere else palm.rotation.inv().apply(UP)
    poses = [_put_down(cell, size, AxisAlignment(axis, UP), centre_in_palm, size.below)]
    facing_down = float(palm.rotation.as_matrix()[:, 2] @ -UP)
    if size.unstable and state.plan.geometry is not None and facing_down < SIDE_COSINE:
        laid = laid_size(size, 2.0 * state.plan.geometry.half_depth)
        tips = cell.hand.reach(state.plan.geometry.width) - float(centre_in_palm[2])
        down = AxisAlignment(-UP, UP)
        poses.insert(0, _put_down(cell, laid, down, centre_in_palm, max(laid.below, tips)))
    return poses


def _put_down(
    cell: Cell,
    size: HeldSize,
    alignment: AxisAlignment,
    centre_in_palm: NDArray[np.float64],
    above: float,
) -> PutDown:
    """Plan the place of the object; its centre is released a height above what is under it, m."""
    jaws = isinstance(cell.robot.hand, ParallelHand)
    distance = 0.5 * cell.hand.max_opening + JAW_DEPTH if jaws else WALL_DISTANCE
    place = plan_place(cell.tray, cell.tray_content, size, distance)
    free = place.below + cell.options.drop_height
    low = place.position + (free + above) * UP
    lifted = float((cell.palm_pose().apply(centre_in_palm) - low) @ UP)
    high = low + max(cell.tray_height + TRAY_CLEARANCE - free, lifted, 0.0) * UP
    return PutDown(size, place, alignment, centre_in_palm, low, high)


def clear_poses(cell: Cell, state: PickState, goal: PutDown) -> Iterator[PutDown]:
    """Yield poses in which the hand clears walls and content while it opens, the best one first.

    The hand holds the object over the place of ``goal``. If it clears them there, this is the first
    pose, and so it is for a hand with fingers. In others it is turned about the vertical, or the
    object is released higher.
    """
    palm = cell.palm_pose().rotation
    width = cell.hand.width(cell.reading.hand)
    boxes = opening_boxes(cell.robot.hand, state.prototype, width)
    columns = tray_columns(cell.tray, cell.tray_content)
    points = lowest_points(boxes, palm.as_matrix(), goal.centre_in_palm)
    clear = cell.tray.centre[2] + clear_heights(columns, points, goal.low[None, :2])[0]
    # Fingers give way to what they touch while they open.
    if isinstance(cell.robot.hand, HandModel) or clear < goal.low[2] + RAISE_STEP:
        yield goal
    # An arm that was stuck on its way may tilt the object.
    assert isinstance(goal.alignment, AxisAlignment), "the turn about the vertical is free"
    upright = Rotation.align_vectors(UP, palm.apply(np.array(goal.alignment.axis)))[0]
    points = lowest_points(boxes, (upright * palm).as_matrix(), goal.centre_in_palm)
    world, control = state.world(cell, "held"), state.near_options(cell)
    for turn, place in _turned(cell, goal, points, columns):
        pose = replace(place, alignment=Orientation(turn * upright * palm))
        ends = (pose.high, pose.low)
        legs = [with_speed(pose.tasks(end), LIFT_SPEED, TURN_SPEED) for end in ends]
        if is_reachable(world, legs, cell.reading.q, control):
            yield pose
    if clear < goal.low[2] + MAX_RAISE:
        yield replace(goal, low=np.append(goal.low[:2], max(clear, goal.low[2])))


def _turned(
    cell: Cell, goal: PutDown, points: NDArray[np.float64], columns: Columns
) -> list[tuple[Rotation, PutDown]]:
    """Return the best pose of each turn of the hand about the vertical, the best one first.

    ``points`` (P, 3), m, are the lowest ones of the upright hand from the object's centre.
    """
    margin = goal.size.radius + RETREAT_TOLERANCE
    positions, below, gap = measure_places(cell.tray, cell.tray_content, goal.size, margin)
    here = cell.palm_pose().apply(goal.centre_in_palm)
    moves = np.linalg.norm((positions - here)[:, :2], axis=1)
    above = float(goal.low[2] - cell.tray.centre[2]) - goal.place.below
    found = []
    for angle in TURNS:
        turn = Rotation.from_euler("z", angle)
        heights = clear_heights(columns, turn.apply(points), positions[:, :2])
        raised = np.maximum(heights - below - above, 0.0)
        cost = moves + TURN_COST * abs(angle)
        keys = (cost, -gap.round(2), (raised / RAISE_STEP).round(), below.round(3))
        best = np.lexsort(keys)[0]
        if raised[best] > MAX_RAISE:
            continue
        place = TrayPlace(positions[best], float(below[best]), float(gap[best]))
        low = place.position + (above + place.below + raised[best]) * UP
        high = np.append(low[:2], max(low[2], goal.high[2]))
        key = tuple(float(one[best]) for one in reversed(keys))
        found.append((key, turn, replace(goal, place=place, low=low, high=high)))
    found.sort(key=lambda one: one[0])
    return [(turn, pose) for _, turn, pose in found]
