"""Stress sweeps over goals: out of reach, inside an obstacle, behind a wall, in conflict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.control import Box, ControlOptions, Obstacle, Sphere
from eyehand.control.tasks import Position

from ..bench import Sweep, Trial
from .stress_trial import SETTLED_STEP, direction, lbr_world, motion_trial, simulate

SHOULDER = np.array([0.0, 0.0, 0.34])
"""Intersection of the arm's first two axes, m. The reachable space is a ball around it."""
REACH = 0.926
"""Radius of that ball, m."""
LONG_S = 60.0
"""Simulated time in front of an obstacle, s. It is long enough to show a slow drift."""
TIME_LIMIT_S = 40.0
"""Maximum simulated time elsewhere, s: enough for three attempts and two retreats."""
LONG_TRIALS = 2
"""Number of trials per value of the long runs."""


def goal_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """Return the sweeps over goals."""
    return (
        Sweep(
            name="out-of-reach",
            axis="goal beyond the arm's reach",
            unit="mm",
            values=(-100.0, -20.0, -5.0, 0.0, 5.0, 20.0, 100.0, 1000.0, 10000.0),
            holds_to=10000.0,
            attempt=_out_of_reach,
            right="reached, or stuck and at rest",
            repeats=4,
        ),
        Sweep(
            name="inside-obstacle",
            axis="goal inside a ball, below its surface",
            unit="mm",
            values=(0.0, 20.0, 60.0, 120.0),
            holds_to=120.0,
            attempt=_inside,
            right="stuck at the margin, naming the ball, for 60 s",
            repeats=LONG_TRIALS,
        ),
        Sweep(
            name="behind-wall",
            axis="width of a wall between hand and goal",
            unit="cm",
            values=(10.0, 30.0, 80.0, 160.0),
            holds_to=160.0,
            attempt=_behind_wall,
            right="past the wall, or stuck and naming it, for 60 s",
            repeats=LONG_TRIALS,
        ),
        Sweep(
            name="conflict",
            axis="distance between two goals of the same point",
            unit="mm",
            values=(0.0, 1.0, 10.0, 100.0, 1000.0),
            holds_to=1000.0,
            attempt=_conflict,
            right="first goal reached and kept, second named as not reached",
            repeats=3,
        ),
    )


def _out_of_reach(beyond_mm: float, seed: int, options: ControlOptions) -> Trial:
    rng = np.random.default_rng([seed, 1])
    azimuth, elevation = rng.uniform(-2.0, 2.0), rng.uniform(0.2, 1.2)
    outward = direction(azimuth, elevation)
    goal = SHOULDER + (REACH + 1e-3 * beyond_mm) * outward
    motion = simulate(lbr_world(), [Position(goal)], options, TIME_LIMIT_S, stop_when_stuck=True)
    status = motion.last.status
    at_rest = status == "stuck" and motion.end_step < SETTLED_STEP
    # At the border of the reachable space, the damped inverse has an error of some 0.1 mm.
    passed = status == "reached" if beyond_mm < -1.0 else status == "reached" or at_rest
    error_mm = 1e3 * motion.last.errors[0]
    note = f"{status}, last steps {motion.end_step:.1e} rad, error {error_mm:.1f} mm"
    return motion_trial(motion, options, passed=passed, note=note)


def _inside(depth_mm: float, seed: int, options: ControlOptions) -> Trial:
    world = lbr_world()
    rng = np.random.default_rng([seed, 2])
    hand = world.robot.at(world.robot.home).position
    offset = np.array(
        [rng.uniform(0.15, 0.3), rng.choice([-1.0, 1.0]) * rng.uniform(0.25, 0.4), 0.2]
    )
    radius, centre = 0.12, hand + offset
    inward = offset / np.linalg.norm(offset)
    goal = centre - (radius - 1e-3 * depth_mm) * inward
    world.add(Obstacle("ball", Sphere(radius), RigidTransform.from_translation(centre)))
    motion = simulate(world, [Position(goal)], options, LONG_S)
    last = motion.last
    passed = last.status == "stuck" and "ball" in last.reason and motion.end_step < SETTLED_STEP
    return motion_trial(motion, options, passed=passed)


def _behind_wall(width_cm: float, seed: int, options: ControlOptions) -> Trial:
    world = lbr_world()
    rng = np.random.default_rng([seed, 3])
    hand = world.robot.at(world.robot.home).position
    half = np.array([0.5e-2 * width_cm, 0.01, 0.5e-2 * width_cm])
    place = hand + np.array([0.0, 0.15, 0.0]) + rng.uniform(-0.02, 0.02, 3)
    # The lower edge stays in place: the wall grows to the sides and upwards.
    place[2] += half[2] - 0.05
    goal = hand + np.array([rng.uniform(-0.03, 0.03), 0.28, 0.0])
    world.add(Obstacle("wall", Box(half), RigidTransform.from_translation(place)))
    motion = simulate(world, [Position(goal)], options, LONG_S)
    last = motion.last
    stuck = last.status == "stuck" and "wall" in last.reason and motion.end_step < SETTLED_STEP
    return motion_trial(motion, options, passed=stuck or last.status == "reached")


def _conflict(apart_mm: float, seed: int, options: ControlOptions) -> Trial:
    world = lbr_world()
    rng = np.random.default_rng([seed, 4])
    hand = world.robot.at(world.robot.home).position
    first = hand + rng.uniform(-0.15, 0.15, 3)
    offset = rng.normal(size=3)
    second = first + 1e-3 * apart_mm * offset / np.linalg.norm(offset)
    tasks = [Position(first, name="upper"), Position(second, name="lower")]
    # A retreat would leave the first goal.
    options = replace(options, retreats=0)
    motion = simulate(world, tasks, options, TIME_LIMIT_S, stop_when_stuck=True)
    last = motion.last
    if apart_mm == 0.0:
        return motion_trial(motion, options, passed=last.status == "reached")
    upper = np.array([cycle.errors[0] for cycle in motion.cycles])
    reached = np.flatnonzero(upper <= options.tolerance)
    kept = len(reached) > 0 and bool(np.all(upper[reached[0] :] <= options.tolerance))
    named = last.status == "stuck" and "lower" in last.reason and "upper" not in last.reason
    note = f"upper: error {1e3 * last.errors[0]:.2f} mm; {last.status}: {last.reason}"
    return motion_trial(motion, options, passed=kept and named, note=note)
