"""Obstacles too near: faces in parallel, starts in penetration, and what comes flying."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import (
    Box,
    CollisionOptions,
    CollisionWorld,
    CoverOptions,
    Obstacle,
    RobotModel,
    Sphere,
    repulsion_gradient,
)
from eyehand.control.tasks import Position

from ..bench import Sweep, Trial
from .stress_trial import SLACK_M, MotionFigures, judged, lbr_world, simulate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import ControlOptions

JUMP_PCT = 1.0
"""Largest change of the gradient, of its length, that counts as smooth."""
FACES_M = 0.04
"""Distance of the parallel faces."""
BALL_RADIUS = 0.06
"""Of a ball that is in the way or comes flying, m."""
LARGE_RADIUS = 0.10
"""Of a ball that the hand starts in, m: room for depths."""
COME_FROM = 0.5
"""How far from the hand a moving ball starts, m."""
PASSES = 0.05
"""How far past where the hand was it flies, m."""

_HAND = """
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="hand">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="y" type="slide" axis="0 1 0"/>
      <joint name="z" type="slide" axis="0 0 1"/>
      <joint name="tilt" type="hinge" axis="0 1 0"/>
      <joint name="turn" type="hinge" axis="1 0 0"/>
      <geom name="palm" type="box" size="0.05 0.035 0.012" mass="1"/>
      <site name="tool"/>
    </body>
  </worldbody>
</mujoco>
"""


def contact_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """Sweeps over what is near."""
    parallel = [
        Sweep(
            name=f"parallel-{name}",
            axis=f"{told}: tilt through parallel",
            unit="°",
            values=(0.0005, 0.002, 0.01, 0.05, 0.2, 1.0),
            holds_to=holds_to,
            attempt=partial(_parallel, cover=cover),
            right=f"gradient changes by less than {JUMP_PCT:g} % of itself",
            repeats=3,
        )
        for name, told, cover, holds_to in (
            ("cover", "soft minimum over balls", CoverOptions(), 0.002),
            ("plain", "shapes as they are", None, None),
        )
    ]
    return (
        *parallel,
        Sweep(
            name="penetration",
            axis="start in penetration, depth",
            unit="mm",
            values=(1.0, 5.0, 10.0, 20.0, 40.0, 80.0, 95.0),
            holds_to=80.0,
            attempt=_penetration,
            right="comes out to the margin, never deeper than it began",
            repeats=3,
        ),
        Sweep(
            name="flying-ball",
            axis="a ball flies at the hand, speed",
            unit="m/s",
            values=(0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4),
            holds_to=0.4,
            attempt=_flying_ball,
            right="margin kept; where it cannot be, status infeasible",
            repeats=4,
        ),
    )


def _parallel(
    step_deg: float, seed: int, options: ControlOptions, *, cover: CoverOptions | None
) -> Trial:
    rng = np.random.default_rng([seed, 8])
    robot = RobotModel.load(_HAND, "tool")
    pose = RigidTransform.from_components(np.zeros(3), Rotation.identity())
    table = Obstacle("table", Box(np.array([0.3, 0.3, 0.05])), pose)
    world = CollisionWorld(robot, [table], options=CollisionOptions(cover=cover))
    place = [*rng.uniform(-0.05, 0.05, 2), 0.05 + 0.012 + FACES_M]
    half = 0.5 * np.radians(step_deg)
    below, above = (
        repulsion_gradient(world.proximity(np.array([*place, tilt, 0.0])), options)
        for tilt in (-half, half)
    )
    jump = 100 * float(np.linalg.norm(above - below) / np.linalg.norm(below))
    smooth = jump < JUMP_PCT
    note = "" if smooth else f"the gradient jumps by {jump:.3g} %"
    clean = bool(np.isfinite(jump))
    return Trial(smooth, note, clean=clean, picture=MotionFigures(jump_pct=jump))


def _penetration(depth_mm: float, seed: int, options: ControlOptions) -> Trial:
    rng = np.random.default_rng([seed, 9])
    world, outward = _ball_at_hand(rng, LARGE_RADIUS)
    robot = world.robot
    depth = 1e-3 * depth_mm
    hand = robot.at(robot.home).position
    # Bisected until the least distance is the depth asked for: the hand is no ball.
    near, far = 0.0, LARGE_RADIUS + 0.2
    for _ in range(40):
        middle = 0.5 * (near + far)
        world.move("ball", _at(hand + middle * outward))
        inside = float(world.proximity(robot.home).distance.min(initial=1.0)) < -depth
        near, far = (middle, far) if inside else (near, middle)
    goal = hand + 0.12 * np.cross(outward, [0.0, 0.0, 1.0])
    motion = simulate(world, [Position(goal)], options, 8.0)
    deeper = float(motion.clearance[0] - motion.clearance.min())
    end = float(motion.clearance[-1])
    out = end >= options.margin - SLACK_M
    note = f"{motion.last.status}, ends at {1e3 * end:.1f} mm, {1e3 * deeper:.2f} mm deeper"
    return judged(motion, options, passed=out and deeper < SLACK_M, note=note, margin=False)


def _flying_ball(speed: float, seed: int, options: ControlOptions) -> Trial:
    rng = np.random.default_rng([seed, 10])
    world, outward = _ball_at_hand(rng)
    robot = world.robot
    hand = robot.at(robot.home).position
    start = hand + COME_FROM * outward
    velocity = -speed * outward

    def fly(number: int) -> None:
        middle = start + number * options.dt * velocity
        world.move("ball", _at(middle), np.concatenate([velocity, np.zeros(3)]))

    # Farther on it would meet links that cannot get out of its way.
    seconds = (COME_FROM + PASSES) / speed
    motion = simulate(
        world, [Position(hand)], options, seconds, stop_when_reached=False, before=fly
    )
    kept = motion.closest >= options.margin - SLACK_M
    told = any(cycle.status == "infeasible" for cycle in motion.cycles)
    note = f"as near as {1e3 * motion.closest:.1f} mm, {'told' if told else 'not told'}"
    trial = judged(motion, options, passed=kept, note=note, margin=False)
    if not kept and not told:
        return Trial(False, note, clean=False, picture=trial.picture)
    return trial


def _ball_at_hand(
    rng: np.random.Generator, radius: float = BALL_RADIUS
) -> tuple[CollisionWorld, NDArray[np.float64]]:
    """A ball far from the hand, and a direction from which it comes: from in front, any height."""
    turn, rise = rng.uniform(-1.2, 1.2), rng.uniform(-0.3, 0.6)
    outward = np.array([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)])
    world = lbr_world([Obstacle("ball", Sphere(radius), _at(5.0 * outward))])
    return world, outward


def _at(place: NDArray[np.float64]) -> RigidTransform:
    return RigidTransform.from_components(place, Rotation.identity())
