"""One control cycle with 30 distance pairs, timed in turns: ours and that of mink."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.control import ApproachController, CollisionOptions, ControlOptions
from eyehand.control.tasks import Position
from eyehand.data_synth.scenes import make_reaching_scene

from .baseline_mink import MinkOptions, _MinkMethod
from .reach_methods import DEFAULT, OWN_METHODS, reaching_world
from .reach_outcome import ReachOptions

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.scenes import ReachingScene

PAIRS = 30
"""Pairs of parts that are near enough to be looked at: a hand's and an arm's worth."""
BOXES = 8
"""Boxes of a posture's scene: with fewer, few parts are near any."""
POSTURES = 8
"""Scenes, one posture in each."""
EARLY_CYCLES = 400
"""The posture is the one of least clearance in so many cycles from the start: there the safety
level has work."""
WIDE_M = 1.5
"""Cut-off that no pair of a scene is beyond, m."""
BURST = 25
"""Cycles of one form before the next has its turn: caches are then warm, as in a control loop."""
ROUNDS = 13
"""Turns of each form at each posture."""
TAKES = 3
"""Times that each turn is taken; a cycle's fastest counts, so that what else runs does not."""

_Step = Callable[[], object]


def cycle_rows(
    seed: int, *, baseline: bool, rounds: int = ROUNDS, postures: int = POSTURES
) -> list[dict[str, Any]]:
    """Time one cycle of each form on the same postures, in turns.

    Every form measures all pairs that can touch, and looks at the 30 nearest; the baseline has the
    same limits: joint ranges, joint speeds, distances.

    Parameters
    ----------
    seed
        Of the first scene that a posture is taken from.
    baseline
        Whether the baseline takes part.
    rounds
        Turns of each form at each posture.
    postures
        How many postures, one per scene.

    Returns
    -------
    list of dict
        Rows `cycle compiled` and, with the baseline, `cycle mink`.
    """
    turns = [_forms(make_reaching_scene(seed + k, boxes=BOXES), baseline) for k in range(postures)]
    for forms in turns:
        for step in forms.values():
            _burst(step)
    times: dict[str, list[float]] = {name: [] for name in turns[0]}
    for _ in range(rounds):
        for forms in turns:
            takes = [{name: _burst(step) for name, step in forms.items()} for _ in range(TAKES)]
            for name in forms:
                times[name] += np.min([take[name] for take in takes], axis=0).tolist()
    return [
        {
            "name": f"cycle {name}",
            "pairs": PAIRS,
            "cycle_p50_us": round(float(np.percentile(taken, 50)), 1),
            "cycle_p99_us": round(float(np.percentile(taken, 99)), 1),
        }
        for name, taken in times.items()
    ]


def _forms(scene: ReachingScene, baseline: bool) -> dict[str, _Step]:
    posture, cut_off = _crowded(scene)
    forms = {"compiled": _own_step(scene, posture, cut_off)}
    if baseline:
        method = _MinkMethod(scene, replace(MinkOptions(), detection=cut_off), ReachOptions().dt)
        forms["mink"] = lambda: method(posture)
    return forms


def _own_step(scene: ReachingScene, posture: NDArray[np.float64], cut_off: float) -> _Step:
    world = reaching_world(scene.obstacles, CollisionOptions(cut_off=cut_off))
    controller = ApproachController(world, (Position(scene.goal),), OWN_METHODS[DEFAULT].options)

    def step() -> None:
        # The arm stands here, and would after a while be told why it is stuck, which takes time.
        controller.restart()
        controller.step(posture)

    return step


def _crowded(scene: ReachingScene) -> tuple[NDArray[np.float64], float]:
    """Posture (7,) of least clearance early on the way; cut-off that leaves 30 pairs, m."""
    world = reaching_world(scene.obstacles)
    options = ControlOptions()
    controller = ApproachController(world, (Position(scene.goal),), options)
    q = best = scene.start
    least = float("inf")
    for _ in range(EARLY_CYCLES):
        cycle = controller.step(q)
        if cycle.clearance < least:
            least, best = cycle.clearance, q
        q = q + options.dt * cycle.velocity
    wide = reaching_world(scene.obstacles, CollisionOptions(cut_off=WIDE_M))
    distances = np.sort(wide.proximity(best).distance)
    return best, float(distances[PAIRS - 1 : PAIRS + 1].mean())


def _burst(step: _Step) -> list[float]:
    taken: list[float] = []
    for _ in range(BURST):
        began = time.perf_counter_ns()
        step()
        taken.append(1e-3 * (time.perf_counter_ns() - began))
    return taken
