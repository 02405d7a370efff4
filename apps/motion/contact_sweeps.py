"""Stress sweeps over near obstacles: starts in penetration, and moving balls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.control import CollisionWorld, ControlOptions, Obstacle, Sphere
from eyehand.control.tasks import Position

from ..bench import Sweep, Trial
from .stress_trial import MARGIN_TOLERANCE_M, direction, lbr_world, motion_trial, simulate

BALL_RADIUS = 0.06
"""Radius of a moving ball, m."""
LARGE_RADIUS = 0.10
"""Radius of a ball that the hand starts in, m. It is large enough for all depths."""
START_DISTANCE = 0.5
"""Distance from the hand at which a moving ball starts, m."""
OVERSHOOT = 0.05
"""Distance that the ball moves beyond the start position of the hand, m."""


def contact_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """Return the sweeps over near obstacles."""
    return (
        Sweep(
            name="penetration",
            axis="start in penetration, depth",
            unit="mm",
            values=(1.0, 5.0, 10.0, 20.0, 40.0, 80.0, 95.0),
            holds_to=80.0,
            attempt=_penetration,
            right="moves out to the margin, never deeper than at the start",
            repeats=3,
        ),
        Sweep(
            name="flying-ball",
            axis="a ball flies at the hand, speed",
            unit="m/s",
            values=(0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4),
            holds_to=0.4,
            attempt=_flying_ball,
            right="margin kept, or status infeasible",
            repeats=4,
        ),
    )


def _penetration(depth_mm: float, seed: int, options: ControlOptions) -> Trial:
    rng = np.random.default_rng([seed, 9])
    world, outward = _ball_at_hand(rng, LARGE_RADIUS)
    robot = world.robot
    depth = 1e-3 * depth_mm
    hand = robot.at(robot.home).position
    # Bisection finds the position of the ball at which the penetration has the wanted depth.
    near, far = 0.0, LARGE_RADIUS + 0.2
    for _ in range(40):
        middle = 0.5 * (near + far)
        world.move("ball", RigidTransform.from_translation(hand + middle * outward))
        inside = float(world.proximity(robot.home).distance.min(initial=1.0)) < -depth
        near, far = (middle, far) if inside else (near, middle)
    goal = hand + 0.12 * np.cross(outward, [0.0, 0.0, 1.0])
    motion = simulate(world, [Position(goal)], options, 8.0)
    deeper = float(motion.clearance[0] - motion.clearance.min())
    end = float(motion.clearance[-1])
    out = end >= options.margin - MARGIN_TOLERANCE_M
    note = f"{motion.last.status}, ends at {1e3 * end:.1f} mm, {1e3 * deeper:.2f} mm deeper"
    return motion_trial(
        motion, options, passed=out and deeper < MARGIN_TOLERANCE_M, note=note, margin=False
    )


def _flying_ball(speed: float, seed: int, options: ControlOptions) -> Trial:
    rng = np.random.default_rng([seed, 10])
    world, outward = _ball_at_hand(rng)
    robot = world.robot
    hand = robot.at(robot.home).position
    start = hand + START_DISTANCE * outward
    velocity = -speed * outward

    def fly(number: int) -> None:
        middle = start + number * options.dt * velocity
        world.move(
            "ball", RigidTransform.from_translation(middle), np.concatenate([velocity, np.zeros(3)])
        )

    # Beyond that, the ball would hit links that cannot avoid it.
    seconds = (START_DISTANCE + OVERSHOOT) / speed
    motion = simulate(
        world, [Position(hand)], options, seconds, stop_when_reached=False, before=fly
    )
    kept = motion.closest >= options.margin - MARGIN_TOLERANCE_M
    reported = any(cycle.status == "infeasible" for cycle in motion.cycles)
    note = f"distance {1e3 * motion.closest:.1f} mm, {'' if reported else 'not '}reported"
    trial = motion_trial(motion, options, passed=kept, note=note, margin=False)
    if not kept and not reported:
        return Trial(False, note, clean=False, picture=trial.picture)
    return trial


def _ball_at_hand(
    rng: np.random.Generator, radius: float = BALL_RADIUS
) -> tuple[CollisionWorld, NDArray[np.float64]]:
    """Return a world with a ball far from the hand, and a direction towards the front (3,)."""
    outward = direction(rng.uniform(-1.2, 1.2), rng.uniform(-0.3, 0.6))
    world = lbr_world(
        [Obstacle("ball", Sphere(radius), RigidTransform.from_translation(5.0 * outward))]
    )
    return world, outward
