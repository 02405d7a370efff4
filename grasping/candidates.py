"""All grasps of an object that a hand could try, each judged."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .grasp_geometry import Grip, turned
from .grasp_scoring import Judgement, judge, room_term
from .hand_clearance import finger_room
from .low_clearance import roomier
from .palm_placement import GraspDepths, Stance, stance
from .prototypes import ROOMIER, TIGHT

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from eyehand.perception import Superquadric

    from .hand_clearance import Neighbours
    from .hand_model import HandModel
    from .prototypes import Approach, GraspPurpose, Prototype, PrototypeLimits

KINDS_OF_GRASP: tuple[tuple[Prototype, Approach], ...] = (
    ("pincer", "top"),
    ("power", "side"),
    ("power", "top"),
    ("precision", "top"),
    ("precision", "side"),
)
"""Prototypes with where the palm comes from."""
CROWDED_WAYS: tuple[tuple[Prototype, float], ...] = (
    ("precision", 0.030),
    ("precision", 0.010),
    ("pincer", 0.010),
)
"""Prototypes and openings beyond the width, m, that are tried for want of room."""
TURNS = 12
"""Directions about up that are tried where symmetry leaves them free and neighbours do not."""
NARROWEST_CONE = 0.14
"""Half the angle left to the hand where only one direction is free of neighbours, rad."""


@dataclass(frozen=True)
class Candidate:
    """One grasp, judged."""

    prototype: Prototype
    """How the hand closes."""
    grip: Grip
    """Where it takes hold."""
    opening: float
    """Free width of the open hand, m."""
    stance: Stance
    """Where the palm is."""
    judgement: Judgement
    """Refusal or score."""
    depths: GraspDepths
    """By which the palm was placed."""
    pushes: int = 0
    """Label of the neighbour that the fingers push; 0 for none."""

    @property
    def name(self) -> str:
        """Approach and prototype."""
        return f"{self.grip.approach} {self.prototype}"


@dataclass(frozen=True)
class Circumstances:
    """What is the same for all grasps of one object."""

    hand: HandModel
    """The hand."""
    near: Neighbours
    """Its neighbours."""
    mass: float
    """Likely mass, kg."""
    visible: float
    """Visible share of the outline, 0-1."""
    narrowest: float
    """Smallest horizontal width, m."""
    purpose: GraspPurpose
    """What follows."""
    limits: PrototypeLimits
    """Sizes that the prototypes suit."""
    depths: GraspDepths
    """Where the object is to be in the hand."""


def candidates(ways: Sequence[Grip], given: Circumstances) -> Iterator[Candidate]:
    """Give every prototype in every grip, refused ones with the reason.

    Among neighbours also those that suit less and need less room: opened less, by two fingers.
    """
    limits = given.limits
    crowded = len(given.near.points) > 0
    for prototype, approach in KINDS_OF_GRASP:
        for grip in ways:
            if grip.approach != approach:
                continue
            clearance = limits.side_clearance if approach == "side" else limits.clearance
            usual = _candidate(prototype, grip, given, clearance)
            found = tuple(_between_neighbours(usual, given))
            yield from found
            if all(one.judgement.terms.get("room") == 1.0 for one in found):
                continue
            if crowded and not usual.judgement.refusal:
                tight = _candidate(prototype, grip, given, limits.tight_clearance)
                yield from _between_neighbours(tight, given)
            elif crowded and prototype == "pincer":
                pinch = _candidate(prototype, grip, given, limits.tight_clearance, makeshift=True)
                yield from _between_neighbours(pinch, given)


def crowded_candidates(
    ways: Sequence[Grip], solid: Superquadric, given: Circumstances, *, push: bool = False
) -> Iterator[Candidate]:
    """Give the grasps from above that need less room, or push a neighbour; no refused ones."""
    for grip in ways:
        if grip.approach != "top":
            continue
        for place, depths, worth in roomier(grip, solid, given.narrowest, given.depths):
            here = replace(given, depths=depths)
            for prototype, clearance in CROWDED_WAYS:
                if prototype == "precision" or not _wide_for_two(place, given):
                    found = _candidate(prototype, place, here, clearance, makeshift=True)
                    if found.judgement.refusal:
                        continue
                    found = _with_room(found, place, here, push=push)
                    if found.judgement.refusal:
                        continue
                    terms = {**found.judgement.terms, "roomier": ROOMIER * worth}
                    yield replace(found, judgement=Judgement("", terms))


def _wide_for_two(grip: Grip, given: Circumstances) -> bool:
    width, length = given.limits.crowded_pincer
    return grip.width > width or grip.length > length


def _candidate(
    prototype: Prototype,
    grip: Grip,
    given: Circumstances,
    clearance: float,
    *,
    makeshift: bool = False,
) -> Candidate:
    limits, hand = given.limits, given.hand
    wanted = grip.width + clearance + 2.0 * grip.doubt
    opening = float(min(wanted, limits.opening, hand.widest))
    place = stance(grip, prototype, opening, hand, given.depths)
    judgement = judge(
        prototype,
        grip,
        place,
        hand,
        mass=given.mass,
        visible=given.visible,
        narrowest=given.narrowest,
        purpose=given.purpose,
        limits=limits,
        makeshift=makeshift,
    )
    if clearance < limits.clearance:
        terms = {**judgement.terms, "opening": TIGHT}
        judgement = Judgement(judgement.refusal, terms)
    return Candidate(prototype, grip, opening, place, judgement, given.depths)


def _between_neighbours(found: Candidate, given: Circumstances) -> Iterator[Candidate]:
    """Judge the room for the fingers; where neighbours take some, hold what symmetry left free."""
    if found.judgement.refusal or not len(given.near.points):
        yield found
        return
    grip = found.grip
    if grip.freedom == "none":
        yield _with_room(found, grip, given)
        return
    tries = [_with_room(found, turn, given) for turn in turned(grip, TURNS)]
    clear = [not one.judgement.refusal for one in tries]
    if all(clear) or not any(clear):
        yield min(tries, key=lambda one: one.judgement.total) if all(clear) else tries[0]
    elif grip.freedom == "around":
        first, count = _longest_run(clear)
        middle = tries[(first + count // 2) % TURNS]
        cone = max((count - 1) * np.pi / TURNS, NARROWEST_CONE)
        if count % 2 == 0:
            cone -= np.pi / TURNS
        yield replace(middle, grip=replace(middle.grip, cone=max(cone, NARROWEST_CONE)))
    else:
        fixed = sorted(tries, key=lambda one: -one.judgement.total)[:2]
        for one in fixed:
            grip = replace(one.grip, freedom="none")
            place = stance(grip, one.prototype, one.opening, given.hand, given.depths)
            yield _with_room(replace(one, grip=grip, stance=place), grip, given)


def _with_room(
    found: Candidate, grip: Grip, given: Circumstances, *, push: bool = False
) -> Candidate:
    gap, label = finger_room(
        grip, found.prototype, found.stance, found.opening, given.hand, given.near
    )
    refusal = found.judgement.refusal
    if gap < (-given.limits.push_depth if push else given.limits.finger_gap):
        refusal = refusal or f"object {label} stands where the hand goes"
    terms = {**found.judgement.terms, "room": room_term(gap, given.limits)}
    pushes = label if gap < given.limits.finger_gap else 0
    return replace(found, grip=grip, judgement=Judgement(refusal, terms), pushes=pushes)


def _longest_run(clear: list[bool]) -> tuple[int, int]:
    """First place and length of the longest run of true values around a circle that has both."""
    count = len(clear)
    best = (0, 0)
    for first in range(count):
        length = 0
        while length < count and clear[(first + length) % count]:
            length += 1
        if length > best[1]:
            best = (first, length)
    return best
