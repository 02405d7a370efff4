"""Plan grasps of all objects of a scene for parallel jaws, ranked by probability of success."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit

from ..fit_uncertainty import width_std
from ..hands import HandBox
from .candidates import Candidates, solid_candidates
from .clearance import FULL_RANK, all_points, coarse_points, hand_clearances
from .contacts import centred_contacts
from .depth_error import depth_error_term, sideways_term
from .grasp import GraspList
from .kernels import BLOCKED
from .memory import memory_term
from .options import JawOptions
from .rim import rim_candidates
from .scored import ScoredCandidates, join_scored
from .scoring import clearance_terms, contact_terms
from .selection import MIN_PROBABILITY, select_grasps, up_direction
from .surface_model import ObjectSurface, object_surface
from .unseen import hidden_shares

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject

    from ..hands import ParallelHand
    from .point_blocks import PointBlocks

KEPT = 220
"""Candidates of each object whose clearance is tested, best contacts first."""
TESTED = 30
"""Candidates of each object that are tested with errors of the depth scale."""
SIDE_CLEARANCE = 0.012
"""Gap on each side of the object if the hand does not open fully, m."""
NARROW_TERM = 0.85
"""Term of a grasp that needs a smaller opening than the full one."""
UNFITTED_TERM, DOUBTFUL_TERM = 0.7, 0.95
"""Terms of an object without a solid, and of one whose solid is doubtful."""
BUMP_SIGMAS, BUMP_SCALE = 11.0, 2.0
"""Height of an object in standard deviations of the support at which it is as likely a bump of the
noise, and the width of the transition. Noise in blotches makes bumps of 8."""
MIN_PLANE_NOISE = 1e-4
"""Minimum standard deviation of the support's readings, m."""
STACKED_TERM = 0.75
"""Term of an object on which another one rests."""
SAME_WIDTH_COSINE = np.cos(np.radians(20.0))
"""Cosine between closing axes whose widths have the same standard deviation."""
PALM_YIELD = 0.006
"""Depth of readings in front of the palm at which a guarded arm merely stops earlier, m."""
HIDDEN_COST = 0.25
"""Share of the grasps that fail because a finger enters space that other objects hide."""


def plan_grasps(scene: Scene, hand: ParallelHand, options: JawOptions | None = None) -> GraspList:
    """Plan grasps of all objects of a scene, the most probable first.

    Parameters
    ----------
    scene
        The perceived scene.
    hand
        The gripper.
    options
        Options; None for the defaults.

    Returns
    -------
    GraspList
        The grasps in the frame of the scene. An empty list is false, and its reason says why.
    """
    started = time.perf_counter()
    options = options or JawOptions()
    up = up_direction(scene)
    items = [item for item in scene.objects if len(item.points)]
    pairs = [(item, object_surface(item, scene)) for item in items]
    known = [(item, surface) for item, surface in pairs if surface is not None]
    rejected: dict[int, Counter[str]] = {item.label: Counter() for item in items}
    for item, surface in pairs:
        if surface is None:
            rejected[item.label][f"only {len(item.points)} points"] += 1
    surfaces = [surface for _, surface in known]
    parts = [
        _contact_candidates(item, surface, number, hand, up, scene, options, rejected)
        for number, (item, surface) in enumerate(known)
    ]
    scored = join_scored([part for part in parts if part is not None])
    if scored is None:
        return _empty(scene, rejected, started)
    coarse = coarse_points(surfaces, scene)
    shell = _yielding(hand) if options.guarded else hand
    scored = _with_clearance(scored, surfaces, coarse, shell, options, rejected)
    scored = _best_of_each(scored, _sideways(scored, scene, hand, options))
    _check_all_points(scored, all_points(surfaces, scene), shell, options)
    scored.terms["depth_error"] = depth_error_term(scored, surfaces, coarse, scene, hand, options)
    hidden = hidden_shares(scored.candidates, scored.opening, surfaces, scene.view_origin, hand)
    scored.terms["unseen"] = (1.0 - HIDDEN_COST * hidden).prod(axis=1)
    scored.terms["order"] = _order_term(scored, known)
    scored.terms["memory"] = memory_term(scored.candidates, surfaces, options.failed)
    grasps = select_grasps(scored, hidden, surfaces, scene, hand, options)
    if not grasps:
        return _empty(scene, rejected, started)
    counts = {label: dict(reasons) for label, reasons in rejected.items()}
    return GraspList(tuple(grasps), "", counts, time.perf_counter() - started)


def _contact_candidates(
    item: SceneObject,
    surface: ObjectSurface,
    number: int,
    hand: ParallelHand,
    up: NDArray[np.float64],
    scene: Scene,
    options: JawOptions,
    rejected: dict[int, Counter[str]],
) -> ScoredCandidates | None:
    """Return the candidates of an object with contacts, the best `KEPT`."""
    parts = [solid_candidates(solid, number, hand, up, options) for solid in surface.solids]
    if surface.vessel is not None:
        parts.append(rim_candidates(surface.vessel, number, hand, up, options))
    found = Candidates.join(parts)
    if not len(found):
        rejected[item.label]["wider than the stroke"] += 1
        return None
    found, contact = centred_contacts(found, surface, scene.support, hand, options)
    if not len(found):
        rejected[item.label]["no contact at both pads"] += 1
        return None
    sigma = _width_sigma(item, found.rotation[:, :, 0])
    # The width of a wall does not depend on that of the solid.
    sigma[np.isfinite(found.reach)] = 0.0
    terms = contact_terms(
        contact,
        found.rotation[:, :, 0],
        np.broadcast_to(surface.centre, (len(found), 3)),
        np.full(len(found), surface.volume),
        sigma,
        up,
        hand,
        options,
    )
    terms["object"] = np.full(len(found), _object_term(item, surface, scene))
    opening, unknown = np.full(len(found), hand.stroke), np.zeros((len(found), 2))
    scored = ScoredCandidates(found, contact, opening, terms, unknown)
    total = scored.total
    for name, term in terms.items():
        rejected[item.label][name] += int(np.count_nonzero(term < MIN_PROBABILITY))
    order = np.argsort(-total * _sideways(scored, scene, hand, options), kind="stable")[:KEPT]
    order = order[total[order] > MIN_PROBABILITY]
    return scored.take(order) if len(order) else None


def _object_term(item: SceneObject, surface: ObjectSurface, scene: Scene) -> float:
    """Return the probability that there is an object, and that it is what its solids say."""
    term = UNFITTED_TERM if not surface.fitted else DOUBTFUL_TERM if item.doubtful else 1.0
    if scene.support is not None:
        top = float(np.percentile(scene.support.height(item.points), 95))
        noise = max(scene.support.tolerance, MIN_PLANE_NOISE)
        term *= float(expit((top / noise - BUMP_SIGMAS) / BUMP_SCALE))
    return term


def _width_sigma(item: SceneObject, closing: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the standard deviation of the width along each closing axis, (n,), m.

    An axis gets that of a near one: one estimate takes 0.5 ms.
    """
    if not item.fit:
        return np.full(len(closing), 0.005)
    unique, index = np.unique(np.round(closing, 6), axis=0, return_inverse=True)
    sigma = np.full(len(unique), np.nan)
    for number, axis in enumerate(unique):
        if np.isnan(sigma[number]):
            near = np.isnan(sigma) & (np.abs(unique @ axis) >= SAME_WIDTH_COSINE)
            sigma[near] = width_std(item.fit, axis)
    return sigma[index.ravel()]


def _with_clearance(
    scored: ScoredCandidates,
    surfaces: Sequence[ObjectSurface],
    blocks: PointBlocks,
    hand: ParallelHand,
    options: JawOptions,
    rejected: dict[int, Counter[str]],
) -> ScoredCandidates:
    """Add the terms of the clearance, at the full opening or at a smaller one."""
    free = hand_clearances(scored.candidates, scored.opening, blocks, hand)
    terms = clearance_terms(free, options)
    opening = scored.opening.copy()
    narrow = np.ones(len(opening))
    if not options.full_opening:
        less = np.minimum(scored.contact.width + 2 * SIDE_CLEARANCE, hand.stroke)
        closer = hand_clearances(scored.candidates, less, blocks, hand)
        other = clearance_terms(closer, options)
        gain = NARROW_TERM * other["own_clearance"] * other["clearance"]
        better = gain > terms["own_clearance"] * terms["clearance"]
        opening[better], narrow[better] = less[better], NARROW_TERM
        free[better] = closer[better]
        terms = clearance_terms(free, options)
    for number, surface in enumerate(surfaces):
        mine = scored.candidates.object == number
        for side, name in enumerate(("touches the object", "touches others")):
            count = int(np.count_nonzero(mine & (free[:, side] <= BLOCKED / 2)))
            rejected[surface.label][name] += count
    return ScoredCandidates(
        scored.candidates,
        scored.contact,
        opening,
        {**scored.terms, **terms, "opening": narrow},
        free,
    )


def _check_all_points(
    scored: ScoredCandidates, blocks: PointBlocks, hand: ParallelHand, options: JawOptions
) -> None:
    """Lower the clearance and its terms to that from all readings."""
    full = hand_clearances(scored.candidates, scored.opening, blocks, hand, FULL_RANK)
    np.minimum(scored.clearance, full, out=scored.clearance)
    scored.terms.update(clearance_terms(scored.clearance, options))


def _yielding(hand: ParallelHand) -> ParallelHand:
    """Return the hand with a palm that may be pushed against an object: the arm stops there."""
    boxes = []
    for box in hand.palm_boxes:
        depth = min(PALM_YIELD, 0.5 * (box.high[2] - box.low[2]))
        boxes.append(HandBox(box.low, (*box.high[:2], box.high[2] - depth)))
    return replace(hand, palm_boxes=tuple(boxes))


def _sideways(
    scored: ScoredCandidates, scene: Scene, hand: ParallelHand, options: JawOptions
) -> NDArray[np.float64]:
    return sideways_term(scored.candidates, scored.contact.width, scene.view_origin, hand, options)


def _best_of_each(scored: ScoredCandidates, sideways: NDArray[np.float64]) -> ScoredCandidates:
    """Return the best `TESTED` candidates of each object."""
    order = np.argsort(-scored.total * sideways, kind="stable")
    owner = scored.candidates.object[order]
    rank = np.zeros(len(order), dtype=np.int64)
    for number in np.unique(owner):
        rank[owner == number] = np.arange(np.count_nonzero(owner == number))
    return scored.take(order[rank < TESTED])


def _order_term(
    scored: ScoredCandidates, known: Sequence[tuple[SceneObject, ObjectSurface]]
) -> NDArray[np.float64]:
    """Return a lower term for objects that carry others, (n,)."""
    carrying = {item.rests_on for item, _ in known}
    factor = np.array([STACKED_TERM if item.label in carrying else 1.0 for item, _ in known])
    return factor[scored.candidates.object]


def _empty(scene: Scene, rejected: dict[int, Counter[str]], started: float) -> GraspList:
    """Return an empty list with its reason."""
    counts = {label: dict(+reasons) for label, reasons in rejected.items()}
    if not scene.objects:
        reason = "the scene has no objects"
    else:
        most = Counter[str]()
        for reasons in rejected.values():
            most.update(reasons)
        common = ", ".join(f"{name} ({n})" for name, n in most.most_common(3) if n)
        reason = f"no grasp is possible: {common}" if common else "no grasp is possible"
    return GraspList((), reason, counts, time.perf_counter() - started)
