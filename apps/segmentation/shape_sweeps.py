"""Sweeps of object shapes: thin objects, hollow objects, one object inside another."""

from __future__ import annotations

from functools import partial

import numpy as np

from eyehand.data_synth.render import StagedObject, StagedScene
from eyehand.data_synth.scenes import staged_solids as shapes

from ..bench import Trial, as_sweep
from .camera_sweeps import COLOURS, MM, view_around
from .stress_trial import SegmentCallable, try_scene

RED, BLUE, GREEN = COLOURS[:3]
BESIDE = StagedObject(shapes.box(0.06, 0.05, 0.07), (0.17, 0.03, 0.0), yaw=0.5, colour=BLUE)
"""An ordinary object beside the difficult one. It must stay one segment."""

finds_both = partial(as_sweep, right="exactly this object and the box beside it found")


@finds_both("flat", "height of a plate", "mm", (20, 15, 12, 10, 8, 6, 5, 4, 3, 2), holds_to=3)
def _flat(height: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 43])
    solid = shapes.box(rng.uniform(0.08, 0.12), rng.uniform(0.06, 0.08), height * MM)
    return _try_beside_box(
        StagedObject(solid, (-0.05, 0.0, 0.0), rng.uniform(0, np.pi)), rng, seed, method
    )


@finds_both(
    "slim", "thickness of a lying rod", "mm", (20, 15, 12, 10, 8, 6, 5, 4, 3, 2), holds_to=8
)
def _slim(thickness: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 47])
    solid = shapes.rod(thickness * MM / 2, 0.15)
    return _try_beside_box(
        StagedObject(solid, (-0.06, 0.0, 0.0), rng.uniform(0, np.pi)), rng, seed, method
    )


@finds_both(
    "board",
    "thickness of a board seen edge-on",
    "mm",
    (20, 15, 12, 10, 8, 6, 5, 4, 3, 2),
    holds_to=20,
)
def _board(thickness: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 53])
    solid = shapes.box(thickness * MM, rng.uniform(0.06, 0.1), rng.uniform(0.06, 0.1))
    yaw = np.radians(rng.uniform(-3, 3))
    # The camera looks along the board, at most 3° off its plane.
    view = view_around(rng, (30, 55), turn=0.0, target=(0.0, 0.0, 0.03))
    objects = (StagedObject(solid, yaw=yaw, colour=RED), BESIDE)
    return try_scene(method, StagedScene(objects, view), seed)


@finds_both("mug", "yaw of a mug", "°", (0, 45, 90, 135, 180, 225, 270, 315), holds_to=None)
def _mug(yaw: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 59])
    solid = shapes.mug(rng.uniform(0.036, 0.044), rng.uniform(0.08, 0.105))
    item = StagedObject(solid, (-0.05, 0.0, 0.0), np.radians(yaw), colour=GREEN)
    return _try_beside_box(item, rng, seed, method)


@finds_both(
    "bowl", "depth of a bowl 140 mm wide", "mm", (20, 30, 40, 55, 70, 90, 110, 130), holds_to=40
)
def _bowl(depth: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 61])
    return _try_beside_box(
        StagedObject(shapes.bowl(0.07, depth * MM), (-0.05, 0.0, 0.0)), rng, seed, method
    )


@as_sweep(
    "in-bowl",
    "diameter of a ball in a bowl",
    "mm",
    (80, 70, 60, 50, 40, 30, 25, 20, 15, 10),
    holds_to=None,
    right="exactly bowl, ball and the box beside them found",
)
def _in_bowl(diameter: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 67])
    wall, depth = 0.004, 0.05
    outside = shapes.bowl(0.08, depth, wall)
    inner = StagedObject(
        shapes.ball(diameter * MM / 2),
        (-0.05, 0.0, _rest_height(diameter * MM / 2, 0.08 - wall, depth - wall) + wall),
        colour=COLOURS[3],
    )
    return _try_beside_box(StagedObject(outside, (-0.05, 0.0, 0.0)), rng, seed, method, inner)


def _try_beside_box(
    item: StagedObject,
    rng: np.random.Generator,
    seed: int,
    method: SegmentCallable,
    *more: StagedObject,
) -> Trial:
    """Run a trial with an object, the box beside it, and further objects."""
    view = view_around(rng, (30, 55), turn=20.0, target=(0.04, 0.0, 0.03))
    return try_scene(method, StagedScene((item, BESIDE, *more), view), seed)


def _rest_height(radius: float, half_width: float, depth: float) -> float:
    """Return the height of a resting ball's lowest point above the bottom of a half ellipsoid, m.

    It is 0 if the ball is more curved than the bottom of the bowl. Otherwise the ball touches the
    wall in a circle and not the bottom.
    """
    angle = np.linspace(0.0, np.pi / 2, 2001)
    across, down = half_width * np.sin(angle), depth * np.cos(angle)
    # The lowest centre of the ball at which every point of the wall is at least a radius away.
    inside = np.sqrt(np.maximum(radius**2 - across**2, 0.0))
    centre = np.max(np.where(across <= radius, inside - down, -depth + radius))
    return float(centre - radius + depth)


SHAPE_SWEEPS = (_flat, _slim, _board, _mug, _bowl, _in_bowl)
"""All sweeps of object shapes."""
