"""Tests of candidates that cost time: best first, until none of the rest can be among the best."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..hands import HandBox
from .clearance import COARSE_RANK, FULL_RANK, all_points, coarse_points, hand_clearances
from .depth_error import SMALL_ERROR, depth_error_term
from .filled_space import filled_points
from .kernels import BLOCKED
from .memory import memory_term
from .misplaced import misplaced_term
from .scored import ScoredCandidates, join_scored
from .scoring import clearance_for, clearance_terms
from .selection import MIN_PROBABILITY
from .sunk_depth import sunk_depths
from .symmetry import distinct, repeats, symmetry_axes
from .unseen import HiddenSpace

if TYPE_CHECKING:
    from collections import Counter
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene

    from ..hands import ParallelHand
    from .candidates import Candidates
    from .options import JawOptions
    from .point_blocks import PointBlocks
    from .surface_model import ObjectSurface

STEP = 16
"""Number of candidates of an object that are tested at once with all readings."""
SIDE_CLEARANCE = 0.012
"""Gap on each side of the object if the hand does not open fully, m."""
NARROW_TERM = 0.85
"""Term of a grasp that needs a smaller opening than the full one."""
HIDDEN_COST = 0.25
"""Share of the grasps that fail because a finger enters space that other objects hide."""
FILLED_COST = 0.8
"""The same if the own object hides the space, and its solid would topple."""
BEHIND_WEIGHT = 0.6
"""Weight of the share of a fingertip behind an object whose solid would stand. Only a tip that is
wholly hidden makes its grasp unsafe: the object is then often thicker than its solid."""
CLOSED_GAP = 0.004
"""Opening beyond the object's width at which fingers count as closed, m: what touches the object
there is held with it."""
CLOSING_SHARES = (0.0, 1.0 / 3.0, 2.0 / 3.0)
"""Parts of the way from closed to open at which fingers are tested. Between them they move by less
than their thickness."""
TOUCHING = -0.006
"""Clearance up to which a candidate counts as rejected by a touch, m."""
PALM_YIELD = 0.006
"""Depth of readings in front of the palm at which a guarded arm merely stops earlier, m."""


@dataclass(frozen=True, eq=False)
class SceneTests:
    """What the candidates of a scene are tested with."""

    scene: Scene
    """The scene."""
    surfaces: Sequence[ObjectSurface]
    """The surfaces of its objects."""
    coarse: PointBlocks
    """Its averaged points."""
    readings: PointBlocks
    """All its readings."""
    hidden: HiddenSpace
    """The space that its objects hide."""
    filled: PointBlocks
    """The hidden space that its objects fill."""
    hand: ParallelHand
    """The hand."""
    shell: ParallelHand
    """The hand as far as it must not touch anything."""


def scene_tests(
    scene: Scene, surfaces: Sequence[ObjectSurface], hand: ParallelHand, options: JawOptions
) -> SceneTests:
    """Prepare the tests of a scene with at least one surface."""
    hidden = HiddenSpace(surfaces, scene.view_origin, hand)
    return SceneTests(
        scene,
        surfaces,
        coarse_points(surfaces, scene),
        all_points(surfaces, scene),
        hidden,
        filled_points(surfaces, scene, hidden),
        hand,
        _yielding(hand) if options.guarded else hand,
    )


def best_grasps(
    scored: ScoredCandidates,
    surface: ObjectSurface,
    tests: SceneTests,
    options: JawOptions,
    rejected: Counter[str],
) -> ScoredCandidates | None:
    """Return the best candidates of an object that differ, with all terms; None without any.

    Parameters
    ----------
    scored
        Candidates of one object, with the terms of their contacts and an estimate of that of the
        depth error.
    surface
        The object.
    tests
        The scene and the hand.
    options
        Options.
    rejected
        Numbers of candidates by what rejected them; two are counted here.
    """
    rest = _with_scene_terms(scored, surface, tests, options)
    for side, name in enumerate(("touches the object", "touches others")):
        rejected[name] += int(np.count_nonzero(rest.clearance[:, side] <= TOUCHING))
    axes = symmetry_axes(surface)
    found = None
    rest = _worth_testing(rest, found, axes, options)
    while len(rest.opening):
        part = _checked(rest.take(slice(STEP)), _bar(found, axes, options), surface, tests, options)
        found = part if found is None else join_scored([found, part])
        rest = _worth_testing(rest.take(slice(STEP, None)), found, axes, options)
    if found is None:
        return None
    return found.take(_distinct(found, axes, options))


def _bar(found: ScoredCandidates | None, axes: NDArray[np.float64], options: JawOptions) -> float:
    """Return the probability that a candidate must exceed to be among the best that differ."""
    if found is None:
        return MIN_PROBABILITY
    best = found.total[_distinct(found, axes, options)]
    return float(best[-1]) if len(best) == options.per_object else MIN_PROBABILITY


def _distinct(
    found: ScoredCandidates, axes: NDArray[np.float64], options: JawOptions
) -> NDArray[np.int64]:
    poses = found.candidates
    count = options.per_object
    return distinct(poses.tip, poses.rotation, found.total, axes, count, MIN_PROBABILITY)


def _worth_testing(
    scored: ScoredCandidates,
    found: ScoredCandidates | None,
    axes: NDArray[np.float64],
    options: JawOptions,
) -> ScoredCandidates:
    """Return the candidates that may be among the best that differ, by descending total.

    A candidate that is the same grasp as a better one is left out.
    """
    total = scored.total
    worth = total > MIN_PROBABILITY
    if found is not None:
        best = found.take(_distinct(found, axes, options))
        others = best.candidates.tip, best.candidates.rotation, best.total
        if len(best.opening) == options.per_object:
            worth &= total > others[2][-1]
        worth &= ~repeats(scored.candidates.tip, scored.candidates.rotation, total, others, axes)
    order = np.argsort(-total, kind="stable")
    return scored.take(order[worth[order]])


def _checked(
    part: ScoredCandidates,
    bar: float,
    surface: ObjectSurface,
    tests: SceneTests,
    options: JawOptions,
) -> ScoredCandidates:
    """Test candidates with all readings, and compute the term of the depth error.

    The terms of candidates that cannot exceed the probability ``bar`` are not exact.
    """
    clearance = hand_clearances(
        part.candidates,
        part.opening,
        tests.readings,
        tests.shell,
        FULL_RANK,
        most=part.clearance,
    )
    sunk = sunk_depths(part.candidates, part.opening, tests.readings, tests.shell)
    # The solids of neighbours reach below what the camera sees.
    solid = sunk_depths(part.candidates, part.opening, tests.coarse, tests.shell)
    sunk[:, 1] = np.maximum(sunk[:, 1], solid[:, 1])
    clearance = np.where(sunk > 0.0, np.minimum(clearance, -sunk), clearance)
    clearance[:, 1] = _closing_clearance(part, clearance[:, 1], tests)
    terms = {**part.terms, **clearance_terms(clearance, options)}
    terms["misplaced"] = misplaced_term(part, surface, tests.hand, options)
    others = np.prod([terms[name] for name in terms if name != "depth_error"], axis=0)
    least = bar / np.maximum(others, 1e-9)
    terms["depth_error"], deeper = depth_error_term(
        part, surface, tests.coarse, tests.scene, tests.hand, options, least
    )
    if options.depth_error <= SMALL_ERROR:
        # Then its shifts are like those of a misplaced hand, and not independent of them.
        terms["misplaced"] *= terms["depth_error"]
        terms["depth_error"] = np.ones(len(least))
    return replace(part, clearance=clearance, terms=terms, deeper=deeper)


def _with_scene_terms(
    scored: ScoredCandidates, surface: ObjectSurface, tests: SceneTests, options: JawOptions
) -> ScoredCandidates:
    """Add the terms of averaged points, of hidden space and of the memory.

    The terms of candidates that cannot exceed `MIN_PROBABILITY` are not exact.
    """
    found = _with_clearance(scored, tests, options)
    hidden, behind = tests.hidden.shares(found.candidates, found.opening)
    cost = HIDDEN_COST if surface.stands else FILLED_COST
    found.terms["unseen"] = (1.0 - HIDDEN_COST * hidden).prod(axis=1)
    found.terms["behind"] = (1.0 - cost * behind).prod(axis=1)
    hidden = np.maximum(hidden, behind * (BEHIND_WEIGHT if surface.stands else 1.0))
    found.terms["memory"] = memory_term(found.candidates, tests.surfaces, options.failed)
    return replace(found, hidden=hidden)


def _with_clearance(
    scored: ScoredCandidates, tests: SceneTests, options: JawOptions
) -> ScoredCandidates:
    """Add the terms of the clearance, at the full opening or at a smaller one."""
    total = scored.total
    least = _least_clearance(total, options)
    free = _clearance(scored.candidates, scored.opening, tests, least)
    opening = scored.opening.copy()
    narrow = np.ones(len(opening))
    if not options.full_opening:
        probability = np.where(free.min(axis=1) < least, 0.0, _free_probability(free, options))
        touching = np.flatnonzero(
            (probability < NARROW_TERM) & (NARROW_TERM * total > MIN_PROBABILITY)
        )
        less = np.minimum(scored.contact.width[touching] + 2 * SIDE_CLEARANCE, tests.hand.stroke)
        least = _least_clearance(NARROW_TERM * total[touching], options)
        narrowed = scored.candidates.take(touching)
        closer = _clearance(narrowed, less, tests, least)
        better = NARROW_TERM * _free_probability(closer, options) > probability[touching]
        changed = touching[better]
        opening[changed], narrow[changed] = less[better], NARROW_TERM
        free[changed] = closer[better]
    terms = {**scored.terms, **clearance_terms(free, options), "opening": narrow}
    return replace(scored, opening=opening, terms=terms, clearance=free)


def _closing_clearance(
    part: ScoredCandidates, others: NDArray[np.float64], tests: SceneTests
) -> NDArray[np.float64]:
    """Return the smaller of `others` and the clearance of closing fingers from others, (n,), m.

    Another object between a finger and its own stops the finger, or is pushed.
    """
    closed = np.minimum(part.contact.width + CLOSED_GAP, part.opening)
    for share in CLOSING_SHARES:
        opening = closed + share * (part.opening - closed)
        others = _from_others(part.candidates, opening, tests.coarse, tests, others)
    return others


def _clearance(
    candidates: Candidates,
    opening: NDArray[np.float64],
    tests: SceneTests,
    least: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the clearance from averaged points, and from the space that others fill, (n, 2), m."""
    free = hand_clearances(candidates, opening, tests.coarse, tests.shell, least=least)
    # These points have no noise.
    free[:, 1] = _from_others(candidates, opening, tests.filled, tests, free[:, 1], 1, least)
    return free


def _from_others(
    candidates: Candidates,
    opening: NDArray[np.float64],
    blocks: PointBlocks,
    tests: SceneTests,
    most: NDArray[np.float64],
    rank: int = COARSE_RANK,
    least: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Return the clearance from the points of other objects, at most ``most``, (n,), m."""
    limit = np.stack([np.full(len(most), -np.inf), most], axis=1)
    return hand_clearances(candidates, opening, blocks, tests.shell, rank, least, limit)[:, 1]


def _least_clearance(total: NDArray[np.float64], options: JawOptions) -> NDArray[np.float64]:
    """Return the clearance below which candidates do not exceed `MIN_PROBABILITY`, (n,), m.

    ``total`` (n,) is their probability without touching anything. The clearance is not above
    `TOUCHING`, so that touches are counted.
    """
    least = clearance_for(MIN_PROBABILITY / np.maximum(total, MIN_PROBABILITY), options)
    return np.clip(least, BLOCKED, TOUCHING)


def _free_probability(clearance: NDArray[np.float64], options: JawOptions) -> NDArray[np.float64]:
    terms = clearance_terms(clearance, options)
    return terms["own_clearance"] * terms["clearance"]


def _yielding(hand: ParallelHand) -> ParallelHand:
    """Return the hand with a palm that may be pushed against an object: a guarded arm stops."""
    boxes = []
    for box in hand.palm_boxes:
        depth = min(PALM_YIELD, 0.5 * (box.high[2] - box.low[2]))
        boxes.append(HandBox(box.low, (*box.high[:2], box.high[2] - depth)))
    return replace(hand, palm_boxes=tuple(boxes))
