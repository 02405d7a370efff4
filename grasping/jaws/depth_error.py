"""Success of grasps when the scale of the depth image is wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit, ndtr

from .candidates import Candidates
from .clearance import hand_clearances, lowest_height
from .contacts import pad_contacts
from .grasp import APPROACH
from .scoring import (
    CLEARANCE_SIGMA,
    OVERLAP_MIDDLE,
    OVERLAP_SCALE,
    SAMPLE_SPACING,
    TILT_SIGMA,
    TOUCH_ALLOWANCE,
    clearance_terms,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene

    from ..hands import ParallelHand
    from .options import JawOptions
    from .point_blocks import PointBlocks
    from .scored import ScoredCandidates
    from .surface_model import ObjectSurface

SIGMAS = (-1.2, 1.2)
"""Errors that are tried, in standard deviations."""
MIDDLE_WEIGHT = 0.4
"""Weight of no error. The three have the variance of a normal distribution within 14 %."""
TABLE_TERM = 0.5
"""Probability that a grasp succeeds although the hand touches the support on its way."""


def depth_error_term(
    scored: ScoredCandidates,
    surfaces: Sequence[ObjectSurface],
    blocks: PointBlocks,
    scene: Scene,
    hand: ParallelHand,
    options: JawOptions,
) -> NDArray[np.float64]:
    """Return the mean success under errors of the depth scale over that without error, (n,).

    An error moves the scene along the line of sight. The hand then meets the object elsewhere, or
    touches it, a neighbour or the support on its way.
    """
    if options.depth_error <= 0.0 or len(scored.candidates) == 0:
        return np.ones(len(scored.candidates))
    sight = scored.candidates.tip - scene.view_origin
    terms = scored.terms
    nominal = terms["friction"] * terms["overlap"] * terms["own_clearance"] * terms["clearance"]
    mean = MIDDLE_WEIGHT * nominal
    for sigma in SIGMAS:
        tip = scored.candidates.tip + sigma * options.depth_error * sight
        moved = Candidates(scored.candidates.rotation, tip, scored.candidates.object)
        success = _success(moved, scored.opening, surfaces, scene, blocks, hand, options)
        mean += 0.5 * (1.0 - MIDDLE_WEIGHT) * success
    return np.clip(mean / np.maximum(nominal, 1e-6), 0.0, 1.0)


def _success(
    candidates: Candidates,
    opening: NDArray[np.float64],
    surfaces: Sequence[ObjectSurface],
    scene: Scene,
    blocks: PointBlocks,
    hand: ParallelHand,
    options: JawOptions,
) -> NDArray[np.float64]:
    """Return the probability of success of candidates at given poses, (n,)."""
    columns = np.zeros((len(candidates), 9))
    for number, surface in enumerate(surfaces):
        mine = candidates.object == number
        if mine.any():
            columns[mine] = pad_contacts(candidates.take(mine), surface, hand)
    meets = columns[:, 1] > 0.0
    angle = np.arccos(np.clip(columns[:, 2:4], -1.0, 1.0))
    held = ndtr((np.arctan(options.friction) - angle) / TILT_SIGMA).prod(axis=1)
    length = np.maximum(columns[:, 7] - columns[:, 6], 0.0) + SAMPLE_SPACING
    held *= expit((length - OVERLAP_MIDDLE) / OVERLAP_SCALE) * meets
    free = clearance_terms(hand_clearances(candidates, opening, blocks, hand), options)
    held *= free["own_clearance"] * free["clearance"]
    if scene.support is not None:
        height = lowest_height(candidates, scene.support, hand)
        sigma = np.hypot(CLEARANCE_SIGMA, options.calibration_error)
        above = ndtr((height + TOUCH_ALLOWANCE) / sigma)
        back = candidates.rotation[:, :, 2] @ scene.support.normal
        at_start = ndtr((height - APPROACH * back + TOUCH_ALLOWANCE) / sigma)
        held *= at_start * (TABLE_TERM + (1.0 - TABLE_TERM) * above)
    return held
