"""Random scenes of the public clutter-removal protocol, and its camera."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.grasping.hands import ParallelHand
from eyehand.perception import CameraIntrinsics

from ..scenes.piece_object import PieceObject
from ..scenes.viewpoint import look_at
from .clutter_world import WORKSPACE, ClutterWorld

ClutterFamily = Literal["packed", "pile"]

SCALES: dict[ClutterFamily, tuple[float, float]] = {"packed": (0.7, 0.9), "pile": (0.8, 1.0)}
"""Range of the factor by which an object is made smaller."""
MAX_PACKED_ATTEMPTS = 12
"""Number of objects tried in a packed scene. One that touches anything is dropped."""
PACKED_HALF = 0.07
"""Packed objects stand within this distance of the middle along x and y, m."""
PILE_HALF = WORKSPACE / 6
"""The same for objects that fall, m."""
DROP_HEIGHT = 0.2
"""Height from which objects fall, m."""
STANDING_GAP = 0.002
"""Height of a packed object above the table before it settles, m."""
PILE_TIMEOUT = 1.0
"""Time for a falling object to come to rest, s."""
CAMERA = CameraIntrinsics(540.0, 540.0, 320.0, 240.0, 640, 480)
"""The original's camera."""
CAMERA_DISTANCE = 2 * WORKSPACE
"""Distance of the camera from the point that it looks at, m."""
CAMERA_ANGLE = np.pi / 3
"""Angle of the line of sight from the vertical, rad."""
TARGET_HEIGHT = WORKSPACE / 3 - 0.05
"""Height of the point that it looks at, m."""
MAX_RANGE = 2.0
"""Maximum depth with a reading, m."""


def make_clutter(
    family: ClutterFamily,
    objects: Sequence[PieceObject],
    hand: ParallelHand,
    rng: np.random.Generator,
    *,
    count: int = 5,
    force: float = 20.0,
    friction: float = 1.0,
) -> ClutterWorld:
    """Draw objects, place them, and let them come to rest.

    Parameters
    ----------
    family
        ``packed``: upright, apart; fewer than `count` if they do not fit. ``pile``: dropped one
        after the other between four walls, which are then removed.
    objects
        Objects to draw from, with replacement.
    hand
        The gripper.
    rng
        Source of randomness.
    count
        Number of objects.
    force
        Maximum closing force of each finger, N.
    friction
        Coulomb friction of all pairs.

    Returns
    -------
    ClutterWorld
        The world with its objects at rest. Those that left the workspace are removed.
    """
    drawn = count if family == "pile" else max(MAX_PACKED_ATTEMPTS, count)
    chosen = [
        objects[int(rng.integers(len(objects)))].scaled(rng.uniform(*SCALES[family]))
        for _ in range(drawn)
    ]
    world = ClutterWorld(chosen, hand, force=force, friction=friction, walls=family == "pile")
    if family == "pile":
        for number in range(count):
            position = [*rng.uniform(-PILE_HALF, PILE_HALF, 2), DROP_HEIGHT]
            world.place(number, RigidTransform.from_components(position, Rotation.random(rng=rng)))
            world.rest(PILE_TIMEOUT)
        world.remove_walls()
        world.rest_and_remove()
        return world
    for number, item in enumerate(chosen):
        turn = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
        up = STANDING_GAP - float(turn.apply(item.corners)[:, 2].min())
        position = [*rng.uniform(-PACKED_HALF, PACKED_HALF, 2), up]
        world.place(number, RigidTransform.from_components(position, turn))
        if world.touching(number):
            world.remove(number)
            continue
        world.rest_and_remove()
        if world.count == count:
            break
    return world


def camera_pose(turned: float = 0.0) -> RigidTransform:
    """Return T_world_camera of the protocol's camera, nearer to the vertical by `turned`, rad."""
    angle = CAMERA_ANGLE - turned
    target = np.array([0.0, 0.0, TARGET_HEIGHT])
    eye = target + CAMERA_DISTANCE * np.array([0.0, -np.sin(angle), np.cos(angle)])
    return look_at(eye, target)
