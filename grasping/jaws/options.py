"""Options of planning grasps for parallel jaws."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from eyehand.errors import InputError

from .grasp import Grasp

MAX_FRICTION, MAX_ERROR, MAX_SCALE_ERROR = 3.0, 0.05, 0.2
MAX_APPROACHES, MAX_TESTED, MAX_THREADS = 360, 100_000, 256


@dataclass(frozen=True)
class JawOptions:
    """Options of :func:`.plan_grasps`.

    Raises
    ------
    InputError
        If a number is outside its range, or a value has another type.
    """

    friction: float = 0.6
    """Coulomb friction coefficient of pads and objects."""
    calibration_error: float = 0.003
    """Standard deviation of the hand's position relative to the image, m."""
    depth_error: float = 0.03
    """Standard deviation of the scale of the depth image, as a share of the distance. A smaller
    `Scene.scale_error` replaces it, as after :func:`.correct_depth`. Set it to 0.005 for a
    calibrated camera."""
    max_tilt: float = math.radians(95.0)
    """Maximum angle of the approach from straight down, rad. 90° is from the side."""
    full_opening: bool = False
    """Whether the hand always opens fully before it closes. Otherwise it opens less where its
    fingers would touch something."""
    guarded: bool = False
    """Whether the arm stops at the first contact of the hand, and closes there. With an unknown
    scale, such a grasp may lie up to 24 mm deeper than the object looks, even below the support:
    never execute it with an arm that does not stop."""
    inclined: bool = False
    """Whether the support is inclined in the world. Otherwise no grasp is safe on a support that
    tilts by more than 3°: the pose of the camera is then probably wrong."""
    per_object: int = 3
    """Maximum number of grasps returned for each object."""
    approaches: int = 24
    """Approaches over a full turn around each closing axis. Fewer plan faster, and find fewer ways
    past neighbours."""
    tested: int = 220
    """Maximum number of candidates of each object that are compared with the scene, those with the
    best contacts. Fewer plan faster in clutter."""
    failed: tuple[Grasp, ...] = ()
    """Grasps that failed before in this scene. Similar ones rank lower."""
    threads: int = 2
    """Number of objects planned at the same time. More threads save time on idle cores. The grasps
    do not change."""

    def __post_init__(self) -> None:
        for name in ("full_opening", "guarded", "inclined"):
            if not isinstance(getattr(self, name), bool):
                raise InputError(f"{name} must be True or False, got {getattr(self, name)!r}")
        if not all(isinstance(grasp, Grasp) for grasp in self.failed):
            raise InputError(f"failed must hold grasps of plan_grasps, got {self.failed!r}")
        for name, low, high in (
            ("friction", 0.0, MAX_FRICTION),
            ("calibration_error", 0.0, MAX_ERROR),
            ("depth_error", 0.0, MAX_SCALE_ERROR),
            ("max_tilt", 0.0, math.pi),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{name} must be from {low:g} to {high:g}, got {value}")
        for name, low, high in (
            ("approaches", 4, MAX_APPROACHES),
            ("tested", 1, MAX_TESTED),
            ("per_object", 1, MAX_TESTED),
            ("threads", 1, MAX_THREADS),
        ):
            value = getattr(self, name)
            if not isinstance(value, (int, np.integer)) or not low <= value <= high:
                raise InputError(f"{name} must be from {low} to {high}, got {value}")
