"""The runs behind Fig. 1: the same way with each weight of avoidance, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.control import ApproachController

from .fig1_scene import BETAS, TIME_LIMIT, fig1_options, fig1_scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.control import Relaxation

    from .fig1_scene import Fig1Scene

MIDCOURSE = (0.2, 0.8)
"""Shares of the straight way between which the clearance counts as that of mid-course: past the
start, and before the goal, whose own clearance no way can change."""
REST = 1e-5
"""A joint slower than this is at rest, rad/s: the hand is then some micrometres from its end."""
DEFAULT = "default"
"""Name of the run with the safety level on."""
REACHED_MM = 0.1
"""Largest final error of a run that reaches its goal, mm."""
TIMES_CLEARER = 3.0
"""How much farther a dynamic β must stay away in mid-course than β = 0."""


@dataclass(frozen=True, eq=False)
class Fig1Run:
    """One run."""

    name: str
    """``beta 0``, ..., ``dynamic``, ``default``."""
    postures: NDArray[np.float64]
    """Joint angles by cycle (N, 4), rad."""
    hand: NDArray[np.float64]
    """Positions of the hand by cycle (N, 3), m."""
    clearance: NDArray[np.float64]
    """Least distance of all pairs by cycle (N,), m."""
    share: NDArray[np.float64]
    """Share of the straight way gone by cycle (N,)."""
    error: float
    """Distance of the hand from the goal at the end, m."""
    status: str
    """Of the controller, at the end."""

    @property
    def closest(self) -> float:
        """Least distance of all pairs over the whole run, m."""
        return float(self.clearance.min())

    @property
    def midcourse(self) -> float:
        """The same while the hand is in mid-course, m."""
        low, high = MIDCOURSE
        return float(self.clearance[(self.share > low) & (self.share < high)].min())


def run_fig1() -> list[Fig1Run]:
    """Run the scene with every β, and once more with the safety level on."""
    scene = fig1_scene()
    runs = [run_once(scene, beta_name(beta), beta) for beta in BETAS]
    return [*runs, run_once(scene, DEFAULT, "dynamic", safety=True)]


def run_once(scene: Fig1Scene, name: str, beta: Relaxation, *, safety: bool = False) -> Fig1Run:
    """Run the scene once, until the arm is at rest; joints do exactly as they are told."""
    options = fig1_options(beta, safety=safety)
    controller = ApproachController(scene.world, [scene.reach_task], options)
    q, status = scene.start, "moving"
    postures, hand, clearance = [], [], []
    for _ in range(round(TIME_LIMIT / options.dt)):
        cycle = controller.step(q)
        postures.append(q)
        hand.append(scene.world.robot.at(q).position)
        clearance.append(cycle.clearance)
        status = cycle.status
        if np.abs(cycle.velocity).max() < REST:
            break
        q = q + options.dt * cycle.velocity
    way = np.array(hand)
    error = float(np.linalg.norm(way[-1] - scene.goal))
    return Fig1Run(
        name, np.array(postures), way, np.array(clearance), scene.share(way), error, status
    )


def beta_name(beta: Relaxation) -> str:
    """Name of a run: ``beta 0.5``, or ``dynamic``."""
    return beta if isinstance(beta, str) else f"beta {beta:g}"


def fig1_rows(runs: Sequence[Fig1Run]) -> list[dict[str, Any]]:
    """One row a run, for CSV and JSON."""
    return [
        {
            "name": run.name,
            "closest_mm": round(1e3 * run.closest, 2),
            "midcourse_clearance_mm": round(1e3 * run.midcourse, 2),
            "final_error_mm": round(1e3 * run.error, 4),
            "status": run.status,
        }
        for run in runs
    ]


def fig1_faults(runs: Sequence[Fig1Run]) -> list[str]:
    """What does not come out as the paper tells it, one line each."""
    by_name = {run.name: run for run in runs}
    straight, dynamic = by_name["beta 0"], by_name["dynamic"]
    faults = [
        f"{run.name} ends {1e3 * run.error:.3g} mm off its goal, must be below {REACHED_MM} mm"
        for run in (straight, dynamic, by_name[DEFAULT])
        if 1e3 * run.error >= REACHED_MM
    ]
    wanted = TIMES_CLEARER * straight.midcourse
    if dynamic.midcourse < wanted:
        faults.append(
            f"dynamic leaves {1e3 * dynamic.midcourse:.3g} mm in mid-course, must be at least "
            f"{1e3 * wanted:.3g} mm"
        )
    for name in ("beta 1", "beta 2", "beta 5"):
        run = by_name[name]
        if run.midcourse < wanted:
            faults.append(f"{name} does not keep its distance: {1e3 * run.midcourse:.3g} mm")
        if 1e3 * run.error < REACHED_MM:
            faults.append(f"{name} reaches its goal, but a fixed weight must miss it")
    return faults
