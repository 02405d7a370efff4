"""Stress sweeps over gains and control periods, and over weights that switch."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import (
    ApproachController,
    Box,
    CollisionWorld,
    ControlOptions,
    Obstacle,
    RobotModel,
    Sphere,
    nominal_motion,
)
from eyehand.control.tasks import Position
from eyehand.data_synth import PLANAR_ARM, TOOL_SITE
from eyehand.errors import InputError

from ..bench import Sweep, Trial
from .stress_trial import MotionFigures, lbr_world, motion_trial, simulate

BETA = 5.0
"""Fixed weight of avoidance in these sweeps: the largest of Fig. 1."""
START_DEPTH_M = 1e-3
"""Depth inside an obstacle's influence distance at which the raw law starts, m."""
ARM_RADIUS = 0.015
"""Radius of the planar arm's links, m."""
STEPS, LAST = 1000, 50
"""Number of steps of the raw law, and of those at its end that determine the amplitude."""
MAX_AMPLITUDE_MM = 0.01
"""Amplitude below which a motion does not oscillate, mm."""
MAX_ACCELERATION = 340.0
"""Maximum joint acceleration that switching weights may cause, rad/s². In a cycle of 5 ms, this is
the full speed of the slowest joint."""
CHATTER = 1e-3
"""Maximum change of a joint's speed between cycles at the goal, rad/s."""


def gain_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """Return the sweeps over gains, periods and switching weights."""
    return (
        Sweep(
            name="gain",
            axis="requested gain β dt λmax(∇²H)",
            unit="",
            values=(0.5, 0.99, 1.01, 1.5, 2.0, 4.0, 100.0),
            holds_to=100.0,
            attempt=_requested_gain,
            right="accepted up to 1, above rejected with a valid η and dt",
            repeats=1,
        ),
        Sweep(
            name="raw-gain",
            axis="the same gain of eq. 8 alone, without the check",
            unit="",
            values=(0.25, 0.5, 1.0, 1.5, 1.9, 1.98, 2.02, 2.1, 2.5, 3.0),
            holds_to=1.9,
            attempt=_raw_gain,
            right=f"oscillates by less than {MAX_AMPLITUDE_MM:g} mm",
            repeats=4,
        ),
        Sweep(
            name="period",
            axis="control period",
            unit="ms",
            values=(1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0),
            holds_to=100.0,
            attempt=_period,
            right="margin kept past a ball, no oscillation at the end; or rejected as above",
            repeats=3,
        ),
        Sweep(
            name="switching",
            axis="cycles between switches of fixed and dynamic weight",
            unit="",
            values=(200.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0),
            holds_to=1.0,
            attempt=_switching,
            right=f"reached, below {MAX_ACCELERATION:g} rad/s², no chatter at the goal",
            repeats=3,
        ),
    )


def _requested_gain(gain: float, seed: int, options: ControlOptions) -> Trial:
    world = lbr_world()
    task = Position(world.robot.at(world.robot.home).position)
    options = replace(options, beta=BETA)
    # The message of a rejection contains the largest valid η. The requested gain is set from it.
    max_eta = _max_valid_eta(world, task, replace(options, eta=1e5))
    requested = replace(options, eta=gain * max_eta)
    message = _rejection(world, task, requested)
    if not message:
        return Trial(gain <= 1.0, "" if gain <= 1.0 else "accepted")
    if gain <= 1.0:
        return Trial(False, f"rejected: {message}", refused=True)
    return _check_suggestion(world, task, requested, message)


def _rejection(world: CollisionWorld, task: Position, options: ControlOptions) -> str:
    """Return the message with which the controller rejects options; empty if it accepts them."""
    try:
        ApproachController(world, [task], options)
    except InputError as error:
        return str(error)
    return ""


def _check_suggestion(
    world: CollisionWorld, task: Position, requested: ControlOptions, message: str
) -> Trial:
    """Check that the values which a rejection suggests are accepted."""
    eta = re.search(r"eta at most ([0-9.e+-]+)", message)
    period = re.search(r"dt at most ([0-9.e+-]+) ms", message)
    if eta is None or period is None:
        return Trial(False, f"rejected without a valid value: {message}", refused=True)
    suggested = [replace(requested, eta=float(eta[1]))]
    if float(period[1]) * 1e-3 >= 1e-5:
        suggested.append(replace(requested, dt=float(period[1]) * 1e-3))
    for options in suggested:
        again = _rejection(world, task, options)
        if again:
            return Trial(False, f"the suggested value is rejected too: {again}", refused=True)
    return Trial(True, refused=True)


def _max_valid_eta(world: CollisionWorld, task: Position, options: ControlOptions) -> float:
    found = re.search(r"eta at most ([0-9.e+-]+)", _rejection(world, task, options))
    if found is None:
        raise InputError(f"eta {options.eta:g} must be rejected with a valid value, but is not")
    return float(found[1])


def _raw_gain(gain: float, seed: int, options: ControlOptions) -> Trial:
    world, start, goal = _hand_before_plate(seed, options.influence)
    options = replace(options, beta=BETA, centring=0.0)
    # The posture in which repulsion and goal are in balance does not depend on η, but the gain in
    # this posture does. The law first settles at a gain of 0.5. Then the wanted gain is set there.
    for wanted in (0.5, gain):
        # Only one pair is near, so that the only eigenvalue of the Hessian is 2 η |row|².
        squared_row = float(np.linalg.norm(world.proximity(start).rows[0])) ** 2
        options = replace(options, eta=wanted / (2.0 * BETA * options.dt * squared_row))
        start, distances = _raw_law(world, goal, start, options)
    amplitude = 1e3 * float(np.ptp(distances[-LAST:]))
    clean = bool(np.all(np.isfinite(start)))
    stable = clean and amplitude < MAX_AMPLITUDE_MM
    note = "" if stable else f"oscillates by {amplitude:.2g} mm"
    figures = MotionFigures(closest_mm=1e3 * min(distances), amplitude_mm=amplitude)
    return Trial(stable, note, clean=clean, picture=figures)


def _raw_law(
    world: CollisionWorld, goal: Position, q: NDArray[np.float64], options: ControlOptions
) -> tuple[NDArray[np.float64], list[float]]:
    """Return the final posture of eq. 8 without a safety level, and the distance in each step."""
    distances = []
    for _ in range(STEPS):
        near = world.proximity(q)
        distances.append(float(near.distance.min(initial=np.inf)))
        q = q + options.dt * nominal_motion(world.robot.at(q), [goal], near, options).velocity
    return q, distances


def _period(dt_ms: float, seed: int, options: ControlOptions) -> Trial:
    options = replace(options, dt=1e-3 * dt_ms)
    world, task = _goal_behind_ball(seed)
    try:
        motion = simulate(world, [task], options, 8.0, stop_when_reached=False)
    except InputError as error:
        return _check_suggestion(world, task, options, str(error))
    tail = motion.postures[-max(round(0.5 / options.dt), 4) :]
    oscillation = float(np.ptp(tail, axis=0).max())
    reached = motion.last.status in ("reached", "stuck")
    note = f"{motion.last.status}, oscillates by {oscillation:.1e} rad"
    return motion_trial(motion, options, passed=reached and oscillation < 1e-2, note=note)


def _switching(cycles: float, seed: int, options: ControlOptions) -> Trial:
    world, task = _goal_behind_ball(seed)
    # Retreats are off, because each one starts with a jump.
    options = replace(options, retreats=0)
    fixed = replace(options, beta=BETA)
    motion = simulate(
        world,
        [task],
        options,
        10.0,
        stop_when_reached=False,
        alternate=(fixed, round(cycles)),
    )
    acceleration = motion.peak_acceleration
    tail = motion.velocities[-round(1.0 / options.dt) :]
    chatter = float(np.abs(np.diff(tail, axis=0)).max())
    passed = (
        motion.last.status == "reached" and acceleration < MAX_ACCELERATION and chatter < CHATTER
    )
    note = f"{motion.last.status}, {acceleration:.0f} rad/s², chatter {chatter:.1e} rad/s"
    return motion_trial(motion, options, passed=passed, note=note, peak_acceleration=acceleration)


def _goal_behind_ball(seed: int) -> tuple[CollisionWorld, Position]:
    """Return a world with a ball on the straight path, and the task to reach the goal behind it."""
    rng = np.random.default_rng([seed, 6])
    world = lbr_world()
    hand = world.robot.at(world.robot.home).position
    side = rng.choice([-1.0, 1.0])
    middle = hand + np.array([0.06, side * 0.2, rng.uniform(0.0, 0.03)])
    pose = RigidTransform.from_translation(middle)
    world.add(Obstacle("ball", Sphere(0.05), pose))
    goal = hand + np.array([rng.uniform(-0.05, -0.02), side * 0.42, rng.uniform(-0.03, 0.03)])
    return world, Position(goal)


def _hand_before_plate(
    seed: int, influence: float
) -> tuple[CollisionWorld, NDArray[np.float64], Position]:
    """Return the planar arm in front of a plate, its posture, and a goal behind the plate.

    The hand is just inside the influence distance of the plate. No other pair is near.
    """
    rng = np.random.default_rng([seed, 7])
    robot = _planar()
    q = np.array([0.9, 0.5, -0.6, -0.4]) + rng.uniform(-0.1, 0.1, 4)
    tip = robot.at(q).position
    heading = float(q.sum())
    outward = np.array([np.cos(heading), np.sin(heading), 0.0])
    half = 0.02
    middle = tip + (ARM_RADIUS + influence - START_DEPTH_M + half) * outward
    pose = RigidTransform.from_components(middle, Rotation.from_rotvec([0.0, 0.0, heading]))
    plate = Obstacle("plate", Box(np.array([half, 0.2, 0.1])), pose)
    return CollisionWorld(robot, [plate]), q, Position(tip + influence * outward)


@lru_cache(maxsize=1)
def _planar() -> RobotModel:
    return RobotModel.load(PLANAR_ARM, TOOL_SITE)
