"""Moving obstacles with unknown velocity: what distance the arm keeps, and what it reports."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import ApproachController
from eyehand.control.tasks import Position
from eyehand.data_synth import ReachingArm
from eyehand.data_synth.scenes import (
    ArmClearance,
    ReachingObstacle,
    make_reaching_scene,
    passes_base,
)
from eyehand.errors import InputError

from .reach_methods import CONTROLLERS, DEFAULT, reaching_world

SPEEDS = (0.25, 0.5)
"""Speeds of the solids, m/s: of people beside the arm, and of conveyors."""
TRIALS = 20
"""Number of trials per row."""
HALF_M = (0.04, 0.08)
"""Range of the half extents of a solid."""
START_M = 0.6
"""Distance of the first solid from the tool at the start."""
BEYOND_M = 0.3
"""Distance behind the tool at which the last solid is removed."""
SPACING_M = 0.5
"""Distance between solids on a conveyor."""
ON_CONVEYOR = 3
"""Number of solids on a conveyor."""
MISS_M = 0.03
"""Standard deviation of the distance at which a solid would pass the tool."""
KEPT_M = 0.005
"""Distance that must be kept."""
MAX_DRAWS = 1000
"""Number of lines of solids that are drawn before a trial is given up."""
NAMED = ("too_near", "contact", "infeasible")
"""Statuses that report a solid."""


class MovingCase(NamedTuple):
    """A trial with solids that move at the tool of an arm that holds its position."""

    seed: int
    """Seed of the posture and of the solids."""
    speed: float
    """Speed of the solids, m/s."""
    conveyor: bool
    """Whether several solids pass horizontally, one after another. Otherwise one comes from any
    side."""
    arm: ReachingArm
    """The arm."""


class MovingResult(NamedTuple):
    """The measurements of a trial."""

    clearance: float
    """Minimum distance of all cycles, by a model that the controller cannot access, m."""
    named: bool
    """Whether a status reported a solid."""
    peak_acceleration: float
    """Maximum joint acceleration as a share of its limit."""


def moving_rows(
    seed: int, trials: int = TRIALS, arm: ReachingArm | None = None
) -> list[dict[str, Any]]:
    """Return a row per speed and kind of motion.

    Parameters
    ----------
    seed
        Seed of the first trial.
    trials
        Number of trials per row.
    arm
        The arm; None for the included one.

    Returns
    -------
    list of dict
        `trials`: number of trials, without those that hold the tool too near to the base;
        `kept_pct`: share of trials with at least 5 mm in every cycle; `touched`: number with a
        contact; `unnamed`: number below 5 mm without a status that says so; least distance; peak
        acceleration in % of its limit.
    """
    rows = []
    for conveyor in (False, True):
        for speed in SPEEDS:
            cases = [
                MovingCase(seed + k, speed, conveyor, arm or ReachingArm()) for k in range(trials)
            ]
            results = _results(cases)
            near = [result for result in results if result.clearance < KEPT_M]
            rows.append(
                {
                    "name": f"{'conveyor' if conveyor else 'any side'} {speed:g} m/s",
                    "trials": len(results),
                    "kept_pct": round(100.0 * (1.0 - len(near) / len(results)), 1),
                    "touched": sum(result.clearance < 0.0 for result in results),
                    "unnamed": sum(not result.named for result in near),
                    "min_clearance_mm": round(1e3 * min(r.clearance for r in results), 2),
                    "peak_acceleration_pct": round(
                        100.0 * max(r.peak_acceleration for r in results), 1
                    ),
                }
            )
    return rows


class NoLineError(InputError):
    """No line of solids to the tool passes beside the base of the arm."""


def moving_trial(case: MovingCase) -> MovingResult:
    """Move solids at the tool of an arm. Only their poses are reported to the controller.

    Raises
    ------
    NoLineError
        If the posture of the seed holds the tool too near to the base.
    """
    scene = make_reaching_scene(case.seed, boxes=0, arm=case.arm)
    q = scene.start.copy()
    target = ArmClearance((), case.arm).tool(q)
    rng = np.random.default_rng([case.seed, 2])
    solids, ahead, velocity = _solids(case, target, rng)
    checker = ArmClearance(solids, case.arm)
    world = reaching_world(solids, case.arm)
    options = CONTROLLERS[DEFAULT].options
    controller = ApproachController(world, (Position(target),), options)
    clearance, named, last, peak = checker.at(q), False, np.zeros(len(q)), 0.0
    seconds = _travel(len(solids)) / case.speed
    for cycle in range(round(seconds / options.dt)):
        moved = ahead + velocity * options.dt * cycle
        for solid, place in zip(solids, moved, strict=True):
            pose = RigidTransform.from_components(place, solid.T_world_shape.rotation)
            world.move(solid.name, pose)
            checker.move(solid.name, place + velocity * options.dt)
        step = controller.step(q)
        q = q + options.dt * step.velocity
        clearance = min(clearance, checker.at(q))
        named = named or step.status in NAMED
        change = np.abs(step.velocity - last) / options.dt / world.robot.acceleration
        peak, last = max(peak, float(change.max())), step.velocity
    return MovingResult(clearance, named, peak)


def _results(cases: Sequence[MovingCase]) -> list[MovingResult]:
    """Return the results of the trials, without those for which no line is found.

    Raises
    ------
    NoLineError
        If none is found for any trial.
    """
    results: list[MovingResult] = []
    errors: list[NoLineError] = []
    for case in cases:
        try:
            results.append(moving_trial(case))
        except NoLineError as error:
            errors.append(error)
    if not results:
        raise errors[0]
    return results


def _solids(
    case: MovingCase, target: NDArray[np.float64], rng: np.random.Generator
) -> tuple[list[ReachingObstacle], NDArray[np.float64], NDArray[np.float64]]:
    """Return the solids, their places at the start (N, 3), m, and their velocity (3,), m/s.

    A line of solids that passes through the base of the arm is drawn again: no arm evades it.

    Raises
    ------
    NoLineError
        If no line passes beside the base.
    """
    for _ in range(MAX_DRAWS):
        solids, direction = _line(case, target, rng)
        travel = _travel(len(solids)) * direction
        if not any(passes_base(solid, travel, case.arm) for solid in solids):
            places = np.array([solid.T_world_shape.translation for solid in solids])
            return solids, places, case.speed * direction
    raise NoLineError(
        f"found no line beside the arm's base among {MAX_DRAWS}; seed {case.seed} holds the tool "
        "too near to it"
    )


def _travel(count: int) -> float:
    """Return how far each of so many solids moves in a trial, m."""
    return START_M + BEYOND_M + SPACING_M * (count - 1)


def _line(
    case: MovingCase, target: NDArray[np.float64], rng: np.random.Generator
) -> tuple[list[ReachingObstacle], NDArray[np.float64]]:
    """Draw the solids at their start, one behind the other, and their direction (3,)."""
    direction = rng.normal(size=3)
    if case.conveyor:
        direction[2] = 0.0
    direction /= np.linalg.norm(direction)
    miss = rng.normal(0.0, MISS_M, 3)
    miss -= direction * (direction @ miss)
    count = ON_CONVEYOR if case.conveyor else 1
    first = target + miss - START_M * direction
    places = first - SPACING_M * np.arange(count)[:, None] * direction
    solids = []
    for number, place in enumerate(places):
        half = rng.uniform(*HALF_M, 3)
        yaw = Rotation.from_rotvec([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
        turn = yaw if case.conveyor else Rotation.random(rng=rng)
        pose = RigidTransform.from_components(place, turn)
        size = (float(half[0]), float(half[1]), float(half[2]))
        solids.append(ReachingObstacle(f"solid_{number + 1}", "box", size, pose))
    return solids, direction
