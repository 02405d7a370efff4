"""Plan grasps of all objects of a scene for parallel jaws, ranked by probability of success."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit

from eyehand.errors import InputError
from eyehand.perception import Scene, map_in_threads, one_blas_thread

from ..fit_uncertainty import width_stds
from ..hands import ParallelHand
from .best_first import best_grasps, scene_tests
from .candidates import Candidates, narrowest_width, solid_candidates
from .contacts import centred_contacts
from .depth_error import sideways_term
from .grasp import GraspList
from .options import JawOptions
from .rim import rim_candidates
from .scored import ScoredCandidates, join_scored
from .scoring import DOUBTFUL_TERM, contact_terms, overhang_term, rejected_terms
from .selection import MIN_PROBABILITY, ranked_grasps, up_direction
from .surface_model import ObjectSurface, object_surface

if TYPE_CHECKING:
    from collections.abc import Collection

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject


BUMP_SIGMAS, BUMP_SCALE = 11.0, 2.0
"""Height of an object in standard deviations of the support at which it is as likely a bump of the
noise, and the width of the transition. Noise in blotches makes bumps of 8."""
MIN_EXISTENCE = 0.2
"""Probability below which an object counts as a bump: its height is 8.2 standard deviations."""
MIN_PLANE_NOISE = 1e-4
"""Minimum standard deviation of the support's readings, m."""
STACKED_TERM = 0.75
"""Term of an object on which another one rests."""
SAME_WIDTH_COSINE = np.cos(np.radians(20.0))
"""Cosine between closing axes whose widths have the same standard deviation."""
AXIS_STEP = 1e-6
"""Components of closing axes that differ by less are equal."""
AXIS_KEY = np.array([1 << 42, 1 << 21, 1])
"""Weights that make one number of a closing axis in these steps."""


@one_blas_thread()
def plan_grasps(
    scene: Scene,
    hand: ParallelHand,
    options: JawOptions | None = None,
    labels: Collection[int] | None = None,
) -> GraspList:
    """Plan grasps of all objects of a scene, the most probable first.

    Parameters
    ----------
    scene
        The perceived scene.
    hand
        The gripper.
    options
        Options; None for the defaults.
    labels
        Labels of the objects to grasp; None for all. The others are neighbours.

    Returns
    -------
    GraspList
        The grasps in the frame of the scene. An empty list is false, and its reason says why.

    Raises
    ------
    InputError
        If `scene` or `hand` is something else.
    """
    if not isinstance(scene, Scene) or not isinstance(hand, ParallelHand):
        raise InputError(
            "plan_grasps needs a Scene, as from perceive, and a ParallelHand, as from load_hand; "
            f"got {type(scene).__name__} and {type(hand).__name__}"
        )
    started = time.perf_counter()
    options = options or JawOptions()
    options = replace(options, depth_error=min(options.depth_error, scene.scale_error))
    up = up_direction(scene)
    items = [item for item in scene.objects if len(item.points)]
    pairs = [(item, object_surface(item, scene)) for item in items]
    known = [(item, surface) for item, surface in pairs if surface is not None]
    rejected: dict[int, Counter[str]] = {item.label: Counter() for item in items}
    for item, surface in pairs:
        if surface is None:
            rejected[item.label][f"only {len(item.points)} points"] += 1
    if not known:
        return _empty(scene, rejected, started)
    surfaces = [surface for _, surface in known]
    tests = scene_tests(scene, surfaces, hand, options)
    carrying = {item.rests_on for item, _ in known}

    def best_of(number: int) -> ScoredCandidates | None:
        item, surface = known[number]
        found = _contact_candidates(item, surface, number, hand, up, scene, options, rejected)
        if found is None:
            return None
        order = STACKED_TERM if item.label in carrying else 1.0
        found.terms["order"] = np.full(len(found.opening), order)
        return best_grasps(found, surface, tests, options, rejected[item.label])

    chosen = [k for k, (item, _) in enumerate(known) if labels is None or item.label in labels]
    found = map_in_threads(best_of, chosen, options.threads)
    best = [one for one in found if one is not None]
    grasps = ranked_grasps(join_scored(best), surfaces, scene, hand, options) if best else []
    if not grasps:
        return _empty(scene, rejected, started)
    counts = {label: dict(reasons) for label, reasons in rejected.items()}
    reason = ""
    if not any(grasp.safe for grasp in grasps):
        forbidding = Counter(grasp.forbidden_by[0] for grasp in grasps)
        reason = f"no grasp is safe: {_listed(forbidding)}"
    return GraspList(tuple(grasps), reason, counts, time.perf_counter() - started)


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
    """Return the candidates of an object with contacts, the best ones."""
    existence = _existence(item, scene)
    if existence < MIN_EXISTENCE:
        rejected[item.label]["as low as bumps of the noise"] += 1
        return None
    parts = [solid_candidates(solid, number, hand, up, options) for solid in surface.solids]
    if surface.vessel is not None:
        parts.append(rim_candidates(surface.vessel, number, hand, up, options))
    found = Candidates.join(parts)
    if not len(found):
        stroke, least = 1e3 * hand.stroke, 1e3 * narrowest_width(surface.solids, up)
        reason = f"{least:.0f} mm wide where jaws reach, wider than the stroke of {stroke:.0f} mm"
        rejected[item.label][reason] += 1
        return None
    found, contact = centred_contacts(found, surface, scene.support, hand)
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
    overhang = overhang_term(contact, found.rotation[:, :, 0], up, options)
    terms["overhang"] = np.ones(len(found)) if item.rests_on else overhang
    terms["object"] = np.full(len(found), DOUBTFUL_TERM if item.doubtful else 1.0)
    terms["existence"] = np.full(len(found), existence)
    opening, unknown = np.full(len(found), hand.stroke), np.zeros((len(found), 2))
    scored = ScoredCandidates(found, contact, opening, terms, unknown, unknown, unknown[:, 0])
    total = scored.total
    for name, term in terms.items():
        rejected[item.label][name] += int(np.count_nonzero(term < MIN_PROBABILITY))
    # An estimate of the term that is computed for the best candidates later.
    terms["depth_error"] = sideways_term(found, contact.width, scene.view_origin, hand, options)
    order = np.argsort(-scored.total, kind="stable")[: options.tested]
    order = order[total[order] > MIN_PROBABILITY]
    if not len(order):
        return None
    scored = scored.take(order)
    if not surface.accepted:
        scored.terms["object"] = rejected_terms(scored, surface, hand)
    return scored


def _existence(item: SceneObject, scene: Scene) -> float:
    """Return the probability that there is an object, and no bump of the support's noise."""
    if scene.support is None:
        return 1.0
    top = float(np.percentile(scene.support.height(item.points), 95))
    noise = max(scene.support.tolerance, MIN_PLANE_NOISE)
    return float(expit((top / noise - BUMP_SIGMAS) / BUMP_SCALE))


def _width_sigma(item: SceneObject, closing: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the standard deviation of the width along each closing axis, (n,), m.

    An axis gets that of a near one, because each estimate takes time.
    """
    if not item.fit:
        return np.full(len(closing), 0.005)
    # One number for each axis: finding distinct rows takes eight times as long.
    grid = np.rint(closing / AXIS_STEP).astype(np.int64)
    _, first, index = np.unique(grid @ AXIS_KEY, return_index=True, return_inverse=True)
    unique = grid[first].astype(np.float64) * AXIS_STEP
    like = np.full(len(unique), -1)
    near = np.abs(unique @ unique.T) >= SAME_WIDTH_COSINE
    for number in range(len(unique)):
        if like[number] < 0:
            like[near[number] & (like < 0)] = number
    estimated, place = np.unique(like, return_inverse=True)
    return width_stds(item.fit, unique[estimated])[place][index]


def _empty(scene: Scene, rejected: dict[int, Counter[str]], started: float) -> GraspList:
    """Return an empty list with its reason."""
    counts = {label: dict(+reasons) for label, reasons in rejected.items()}
    if not scene.objects:
        reason = "the scene has no objects"
    else:
        most = Counter[str]()
        for reasons in rejected.values():
            most.update(reasons)
        common = _listed(most, " candidates")
        reason = f"no grasp is possible: {common}" if common else "no grasp is possible"
    return GraspList((), reason, counts, time.perf_counter() - started)


def _listed(reasons: Counter[str], unit: str = "") -> str:
    """Return the three most frequent reasons with their numbers."""
    return ", ".join(
        name if n == 1 else f"{name} ({n}{unit})" for name, n in reasons.most_common(3) if n
    )
