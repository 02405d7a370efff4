"""Gains and periods raised until motions oscillate, and weights that change their mind."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import (
    ApproachController,
    Box,
    CollisionWorld,
    Obstacle,
    RobotModel,
    Sphere,
    nominal_motion,
)
from eyehand.control.tasks import Position
from eyehand.data_synth import PLANAR_ARM, TOOL_SITE
from eyehand.errors import InputError

from ..bench import Sweep, Trial
from .stress_trial import MotionFigures, judged, lbr_world, simulate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import ControlOptions

BETA = 5.0
"""Fixed weight at which gains are tried: the heaviest of the paper's figure."""
DISTURBED_M = 1e-3
"""How far inside an obstacle's influence the raw law starts, m."""
ARM_RADIUS = 0.015
"""Of the planar arm's links, m."""
STEPS, LAST = 1000, 50
"""Steps of the raw law, and those at its end whose distances tell the amplitude."""
CALM_MM = 0.01
"""Amplitude below which nothing oscillates."""
MAX_ACCELERATION = 340.0
"""Largest change of a joint's speed over time that changing weights may cost, rad/s²: in a cycle of
5 ms no more than the slowest joint's full speed."""
CHATTER = 1e-3
"""Largest change of a joint's speed between cycles at the goal, rad/s."""


def gain_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """Sweeps over gains."""
    return (
        Sweep(
            name="gain",
            axis="gain β dt λmax(∇²H) that is asked for",
            unit="",
            values=(0.5, 0.99, 1.01, 1.5, 2.0, 4.0, 100.0),
            holds_to=100.0,
            attempt=_asked_gain,
            right="accepted up to 1, above refused with the η and dt that would do",
            repeats=1,
        ),
        Sweep(
            name="raw-gain",
            axis="the same gain of eq. 8 alone, unrefused",
            unit="",
            values=(0.25, 0.5, 1.0, 1.5, 1.9, 1.98, 2.02, 2.1, 2.5, 3.0),
            holds_to=1.9,
            attempt=_raw_gain,
            right=f"oscillates by less than {CALM_MM:g} mm",
            repeats=4,
        ),
        Sweep(
            name="period",
            axis="control period",
            unit="ms",
            values=(1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0),
            holds_to=100.0,
            attempt=_period,
            right="margin kept past a ball, and no oscillation at the end; or refused as above",
            repeats=3,
        ),
        Sweep(
            name="switching",
            axis="weight fixed / dynamic in turns: cycles each",
            unit="",
            values=(200.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0),
            holds_to=1.0,
            attempt=_switching,
            right=f"reached, below {MAX_ACCELERATION:g} rad/s², no chatter at the goal",
            repeats=3,
        ),
    )


def _asked_gain(gain: float, seed: int, options: ControlOptions) -> Trial:
    world = lbr_world()
    task = Position(world.robot.at(world.robot.home).position)
    options = replace(options, beta=BETA)
    # What is refused tells where the limit lies; then the gain asked for is made of it.
    largest = _told_eta(world, task, replace(options, eta=1e5))
    asked = replace(options, eta=gain * largest)
    try:
        ApproachController(world, [task], asked)
    except InputError as error:
        if gain <= 1.0:
            return Trial(False, f"refused: {error}", refused=True)
        return _right_numbers(world, task, asked, str(error))
    return Trial(gain <= 1.0, "" if gain <= 1.0 else "accepted")


def _right_numbers(
    world: CollisionWorld, task: Position, asked: ControlOptions, said: str
) -> Trial:
    """Whether the numbers that a refusal gives are indeed accepted."""
    eta = re.search(r"eta at most ([0-9.e+-]+)", said)
    period = re.search(r"dt at most ([0-9.e+-]+) ms", said)
    if eta is None or period is None:
        return Trial(False, f"refused without the number that would do: {said}", refused=True)
    better = [replace(asked, eta=float(eta[1]))]
    if float(period[1]) * 1e-3 >= 1e-5:
        better.append(replace(asked, dt=float(period[1]) * 1e-3))
    for options in better:
        try:
            ApproachController(world, [task], options)
        except InputError as error:
            return Trial(False, f"what it says would do is refused too: {error}", refused=True)
    return Trial(True, refused=True)


def _told_eta(world: CollisionWorld, task: Position, options: ControlOptions) -> float:
    try:
        ApproachController(world, [task], options)
    except InputError as error:
        found = re.search(r"eta at most ([0-9.e+-]+)", str(error))
        if found is not None:
            return float(found[1])
    raise InputError(f"eta = {options.eta:g} is accepted; where is the limit?")


def _raw_gain(gain: float, seed: int, options: ControlOptions) -> Trial:
    world, start, goal = _hand_before_plate(seed, options.influence)
    options = replace(options, beta=BETA, centring=0.0)
    # Where repulsion and goal are in balance does not depend on η, but the gain there does: let
    # it settle at half, then ask for the gain in the posture that it settled in.
    for wanted in (0.5, gain):
        # One pair is near, so its Hessian's one eigenvalue is 2 η |row|².
        largest = float(np.linalg.norm(world.proximity(start).rows[0])) ** 2
        options = replace(options, eta=wanted / (2.0 * BETA * options.dt * largest))
        start, distances = _raw_law(world, goal, start, options)
    amplitude = 1e3 * float(np.ptp(distances[-LAST:]))
    clean = bool(np.all(np.isfinite(start)))
    calm = clean and amplitude < CALM_MM
    note = "" if calm else f"oscillates by {amplitude:.2g} mm"
    figures = MotionFigures(closest_mm=1e3 * min(distances), amplitude_mm=amplitude)
    return Trial(calm, note, clean=clean, picture=figures)


def _raw_law(
    world: CollisionWorld, goal: Position, q: NDArray[np.float64], options: ControlOptions
) -> tuple[NDArray[np.float64], list[float]]:
    """Where eq. 8 leads, with nothing above it, and the least distance on the way, by step."""
    distances = []
    for _ in range(STEPS):
        near = world.proximity(q)
        distances.append(float(near.distance.min(initial=np.inf)))
        q = q + options.dt * nominal_motion(world.robot.at(q), [goal], near, options).velocity
    return q, distances


def _period(dt_ms: float, seed: int, options: ControlOptions) -> Trial:
    options = replace(options, dt=1e-3 * dt_ms)
    world, task = _past_a_ball(seed)
    try:
        motion = simulate(world, [task], options, 8.0, stop_when_reached=False)
    except InputError as error:
        return _right_numbers(world, task, options, str(error))
    tail = motion.postures[-max(round(0.5 / options.dt), 4) :]
    swing = float(np.ptp(tail, axis=0).max())
    reached = motion.last.status in ("reached", "stuck")
    note = f"{motion.last.status}, swings by {swing:.1e} rad"
    return judged(motion, options, passed=reached and swing < 1e-2, note=note)


def _switching(cycles: float, seed: int, options: ControlOptions) -> Trial:
    world, task = _past_a_ball(seed)
    # A second try starts with a jump of its own, which is not what is asked for here.
    options = replace(options, retreats=0)
    fixed = replace(options, beta=BETA)
    motion = simulate(
        world,
        [task],
        options,
        10.0,
        stop_when_reached=False,
        in_turns=(fixed, round(cycles)),
    )
    acceleration = motion.peak_acceleration
    tail = motion.velocities[-round(1.0 / options.dt) :]
    chatter = float(np.abs(np.diff(tail, axis=0)).max())
    passed = (
        motion.last.status == "reached" and acceleration < MAX_ACCELERATION and chatter < CHATTER
    )
    note = f"{motion.last.status}, {acceleration:.0f} rad/s², chatter {chatter:.1e} rad/s"
    return judged(motion, options, passed=passed, note=note, peak_acceleration=acceleration)


def _past_a_ball(seed: int) -> tuple[CollisionWorld, Position]:
    """A goal aside, beyond a ball that the straight way to it touches."""
    rng = np.random.default_rng([seed, 6])
    world = lbr_world()
    hand = world.robot.at(world.robot.home).position
    side = rng.choice([-1.0, 1.0])
    middle = hand + np.array([0.06, side * 0.2, rng.uniform(0.0, 0.03)])
    pose = RigidTransform.from_components(middle, Rotation.identity())
    world.add(Obstacle("ball", Sphere(0.05), pose))
    goal = hand + np.array([rng.uniform(-0.05, -0.02), side * 0.42, rng.uniform(-0.03, 0.03)])
    return world, Position(goal)


def _hand_before_plate(
    seed: int, influence: float
) -> tuple[CollisionWorld, NDArray[np.float64], Position]:
    """The planar arm at the edge of a plate's influence, no other pair near, and a goal beyond."""
    rng = np.random.default_rng([seed, 7])
    robot = _planar()
    q = np.array([0.9, 0.5, -0.6, -0.4]) + rng.uniform(-0.1, 0.1, 4)
    tip = robot.at(q).position
    heading = float(q.sum())
    outward = np.array([np.cos(heading), np.sin(heading), 0.0])
    half = 0.02
    middle = tip + (ARM_RADIUS + influence - DISTURBED_M + half) * outward
    pose = RigidTransform.from_components(middle, Rotation.from_rotvec([0.0, 0.0, heading]))
    plate = Obstacle("plate", Box(np.array([half, 0.2, 0.1])), pose)
    return CollisionWorld(robot, [plate]), q, Position(tip + influence * outward)


@lru_cache(maxsize=1)
def _planar() -> RobotModel:
    return RobotModel.load(PLANAR_ARM, TOOL_SITE)
