"""Generate and evaluate all candidate grasps of an object."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .grasp_geometry import GraspGeometry, turned
from .grasp_scoring import GraspContext, GraspEvaluation, clearance_term, evaluate_grasp
from .hand_clearance import BACKGROUND, hand_boxes, hand_clearance
from .low_clearance import low_clearance_grasps
from .palm_placement import PalmPlacement, TipDepth, place_palm
from .prototypes import (
    CLEARANCE,
    CROWDED_PINCER_LENGTH,
    CROWDED_PINCER_WIDTH,
    FINGER_GAP,
    MAX_OPENING,
    PUSH_DEPTH,
    SIDE_CLEARANCE,
    TIGHT_CLEARANCE,
    Approach,
    Prototype,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric


USUAL_GRASPS: tuple[tuple[Prototype, Approach], ...] = (
    ("pincer", "top"),
    ("power", "side"),
    ("power", "top"),
    ("precision", "top"),
    ("precision", "side"),
)
"""Usual combinations of prototype and approach."""
LOW_CLEARANCE_GRASPS: tuple[tuple[Prototype, float], ...] = (
    ("precision", 0.030),
    ("precision", 0.010),
    ("pincer", 0.010),
)
"""Prototypes of the low-clearance grasps, and their openings beyond the object's width, m."""
TIGHT_WEIGHT = 0.9
"""Weight of a grasp that opens the hand less than `CLEARANCE` beyond the object's width."""
VARIANT_WEIGHT = 0.5
"""Additional weight of a low-clearance variant."""
TURNS = 12
"""Number of horizontal directions that are tried for an object that has neighbours and whose
symmetry leaves the direction free."""
MIN_APPROACH_ANGLE = 0.14
"""Minimum value of `GraspGeometry.max_approach_angle`, rad. It applies if only one or two adjacent
directions are free of neighbours."""


@dataclass(frozen=True)
class GraspCandidate:
    """A candidate grasp with its evaluation."""

    prototype: Prototype
    """Prototype of the grasp."""
    geometry: GraspGeometry
    """Directions and sizes of the grasp."""
    opening: float
    """Opening of the hand before it closes, m."""
    placement: PalmPlacement
    """Place of the palm."""
    evaluation: GraspEvaluation
    """Reason for rejection, or score terms."""
    depth: TipDepth
    """Wanted depth of the fingertips."""
    pushed_label: int = 0
    """Label of the neighbour that the fingers push; 0 for none."""

    @property
    def name(self) -> str:
        """Approach and prototype."""
        return f"{self.geometry.approach} {self.prototype}"


def usual_candidates(
    geometries: Sequence[GraspGeometry], context: GraspContext
) -> Iterator[GraspCandidate]:
    """Yield the usual grasps for every geometry, also the impossible ones with the reason.

    Near neighbours, more candidates are added. They have a smaller opening, or a pincer on an
    object that is too wide for the usual pincer.
    """
    crowded = len(context.neighbours.points) > 0
    for prototype, approach in USUAL_GRASPS:
        for geometry in geometries:
            if geometry.approach != approach:
                continue
            extra_opening = SIDE_CLEARANCE if approach == "side" else CLEARANCE
            usual = _candidate(prototype, geometry, context, extra_opening)
            candidates = tuple(_between_neighbours(usual, context))
            yield from candidates
            if all(one.evaluation.terms.get("room") == 1.0 for one in candidates):
                continue
            if crowded and not usual.evaluation.refusal:
                tight = _candidate(prototype, geometry, context, TIGHT_CLEARANCE)
                yield from _between_neighbours(tight, context)
            elif crowded and prototype == "pincer":
                pincer = _candidate(prototype, geometry, context, TIGHT_CLEARANCE, wide_pincer=True)
                yield from _between_neighbours(pincer, context)


def low_clearance_candidates(
    geometries: Sequence[GraspGeometry],
    solid: Superquadric,
    context: GraspContext,
    *,
    push: bool = False,
) -> Iterator[GraspCandidate]:
    """Yield the possible top grasps that need less free space.

    With `push`, they may push a neighbour aside.
    """
    for geometry in geometries:
        if geometry.approach != "top":
            continue
        for variant, depth, weight in low_clearance_grasps(geometry, solid, context.narrowest):
            for prototype, extra_opening in LOW_CLEARANCE_GRASPS:
                if prototype == "pincer" and _too_wide_for_pincer(variant):
                    continue
                found = _candidate(
                    prototype, variant, context, extra_opening, depth=depth, wide_pincer=True
                )
                if found.evaluation.refusal:
                    continue
                boxes = hand_boxes(context.hand, prototype, found.opening, variant.width)
                found = _with_clearance(found, variant, context, boxes, push=push)
                if found.evaluation.refusal:
                    continue
                terms = {**found.evaluation.terms, "variant": VARIANT_WEIGHT * weight}
                yield replace(found, evaluation=replace(found.evaluation, terms=terms))


def _too_wide_for_pincer(geometry: GraspGeometry) -> bool:
    return geometry.width > CROWDED_PINCER_WIDTH or geometry.length > CROWDED_PINCER_LENGTH


def _candidate(
    prototype: Prototype,
    geometry: GraspGeometry,
    context: GraspContext,
    extra_opening: float,
    *,
    depth: TipDepth | None = None,
    wide_pincer: bool = False,
) -> GraspCandidate:
    """Place the palm for a grasp and evaluate it without neighbours.

    `extra_opening` is the opening beyond the object's width, m.
    """
    depth = depth or TipDepth()
    hand = context.hand
    wanted = geometry.width + extra_opening + 2.0 * geometry.width_std
    opening = float(min(wanted, MAX_OPENING, hand.max_opening))
    placement = place_palm(geometry, prototype, opening, hand, depth)
    evaluation = evaluate_grasp(prototype, geometry, placement, context, wide_pincer=wide_pincer)
    if extra_opening < CLEARANCE:
        terms = {**evaluation.terms, "opening": TIGHT_WEIGHT}
        evaluation = replace(evaluation, terms=terms)
    return GraspCandidate(prototype, geometry, opening, placement, evaluation, depth)


def _between_neighbours(found: GraspCandidate, context: GraspContext) -> Iterator[GraspCandidate]:
    """Evaluate the distance to neighbours in all directions that symmetry leaves free.

    If neighbours block some of them, the free directions remain: a limited approach angle for
    freedom "around", else the best two directions, both fixed.
    """
    if found.evaluation.refusal or not len(context.neighbours.points):
        yield found
        return
    geometry = found.geometry
    boxes = hand_boxes(context.hand, found.prototype, found.opening, geometry.width)
    if geometry.freedom == "none":
        yield _with_clearance(found, geometry, context, boxes)
        return
    turns = turned(geometry, TURNS)
    gaps = [hand_clearance(turn, found.placement, boxes, context.neighbours)[0] for turn in turns]
    clear = [gap >= FINGER_GAP for gap in gaps]
    terms = np.array([clearance_term(gap) for gap in gaps])
    if all(clear):
        # All directions stay allowed, so the worst one determines the score.
        yield _with_clearance(found, turns[int(terms.argmin())], context, boxes)
    elif not any(clear):
        yield _with_clearance(found, turns[0], context, boxes)
    elif geometry.freedom == "around":
        first, count = _longest_run(clear)
        turn = turns[(first + count // 2) % TURNS]
        middle = _with_clearance(found, turn, context, boxes)
        angle = max((count - 1) * np.pi / TURNS, MIN_APPROACH_ANGLE)
        # An even run has no middle direction: `middle` is half a step off, nearer to one end.
        if count % 2 == 0:
            angle -= np.pi / TURNS
        limited = replace(middle.geometry, max_approach_angle=max(angle, MIN_APPROACH_ANGLE))
        yield replace(middle, geometry=limited)
    else:
        for number in np.argsort(-terms * clear, kind="stable")[:2]:
            fixed = replace(turns[number], freedom="none")
            placement = place_palm(fixed, found.prototype, found.opening, context.hand, found.depth)
            one = replace(found, geometry=fixed, placement=placement)
            yield _with_clearance(one, fixed, context, boxes)


def _with_clearance(
    found: GraspCandidate,
    geometry: GraspGeometry,
    context: GraspContext,
    boxes: NDArray[np.float64],
    *,
    push: bool = False,
) -> GraspCandidate:
    """Return a candidate at a geometry, with the score term of its distance to neighbours.

    ``boxes`` are those of :func:`hand_boxes`.
    """
    gap, label = hand_clearance(geometry, found.placement, boxes, context.neighbours)
    refusal = found.evaluation.refusal
    fixed = {context.label: "another part of the object", BACKGROUND: "something that is no object"}
    if gap < (-PUSH_DEPTH if push and label not in fixed else FINGER_GAP):
        name = fixed.get(label, f"object {label}")
        refusal = refusal or f"{name} is in the way of the hand"
    terms = {**found.evaluation.terms, "room": clearance_term(gap)}
    return replace(
        found,
        geometry=geometry,
        evaluation=replace(found.evaluation, refusal=refusal, terms=terms),
        pushed_label=label if gap < FINGER_GAP else 0,
    )


def _longest_run(clear: list[bool]) -> tuple[int, int]:
    """Return start and length of the longest cyclic run of True in a list with both values."""
    count = len(clear)
    best = (0, 0)
    for first in range(count):
        length = 0
        while length < count and clear[(first + length) % count]:
            length += 1
        if length > best[1]:
            best = (first, length)
    return best
