"""Success of grasps when the scale of the depth image is wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit, ndtr

from .contacts import pad_contacts
from .free_travel import ALLOWANCE, free_travel
from .grasp import APPROACH
from .scoring import CLEARANCE_SIGMA, OVERLAP_MIDDLE, OVERLAP_SCALE, SAMPLE_SPACING, TILT_SIGMA

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene

    from ..hands import ParallelHand
    from .candidates import Candidates
    from .options import JawOptions
    from .point_blocks import PointBlocks
    from .scored import ScoredCandidates
    from .surface_model import ObjectSurface

ERRORS, FEW_ERRORS = 0.75 * np.array([0, -1, 1, -2, 2, -3, 3]), 1.5 * np.array([0, -1, 1])
"""Errors that are tried, in standard deviations, the likeliest ones first. Grasps that all succeed
within one standard deviation differ in the tails. Three are enough for a small deviation."""
FIRST_ERRORS = 3
"""Number of errors that are tried for all candidates."""
SMALL_ERROR = 0.01
"""Largest small deviation of the scale."""
STOPPED_TERM = 0.5
"""Probability that an arm that does not stop succeeds although its hand touches something."""
DEEPER = (0.0, 0.012, 0.024)
"""Distances by which a guarded arm may go on along its approach, m. If the object is farther than
it looks, the hand still reaches it; if not, the first contact stops the arm."""
GUARDED_SPREAD = 4.0 / 3.0
"""Factor of a large deviation for a guarded arm. Grasps chosen for more than the deviation fail
less often at large errors: 70 instead of 65 of 89 in development rounds."""
SPREAD_EXPONENT = 0.7
"""Exponent that turns the success under the larger deviation into that under the plain one. Fitted
to 165 grasps of development piles; it lowers the error on four other sources."""
MIN_SHIFT = 1e-4
"""Minimum standard deviation of a shift along the closing axis, m."""
REACHED = 0.002
"""Rest of the approach that counts as reached, m."""


def depth_error_term(
    scored: ScoredCandidates,
    surface: ObjectSurface,
    blocks: PointBlocks,
    scene: Scene,
    hand: ParallelHand,
    options: JawOptions,
    least: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the mean success under errors of the depth scale over that without error, (n,).

    The candidates are those of one object. An error moves the scene along the line of sight. The
    hand then meets the object elsewhere, or touches it, a neighbour or the support on its way. A
    guarded arm stops and closes there. Therefore it may go deeper if the error is large: the second
    result is the best of `DEEPER` for each candidate, (n,), m, and the first one is for it.

    A candidate counts only if its result exceeds ``least`` (n,). Large errors are not tried if it
    would not exceed that with the mean success under the first ones.
    """
    count = len(scored.candidates)
    if options.depth_error <= 0.0 or count == 0:
        return np.ones(count), np.zeros(count)
    few = options.depth_error <= SMALL_ERROR
    sinks = options.guarded and not few
    errors, depths = FEW_ERRORS if few else ERRORS, DEEPER if sinks else DEEPER[:1]
    weights = np.exp(-0.5 * errors**2)
    weights /= weights.sum()
    sigma = options.depth_error * (GUARDED_SPREAD if sinks else 1.0)
    exponent = SPREAD_EXPONENT if sinks else 1.0
    shifts = sigma * errors[:, None, None] * (scored.candidates.tip - scene.view_origin)
    tests = surface, scene, blocks, hand, options
    nominal = np.maximum(scored.terms["friction"] * scored.terms["overlap"], 1e-6)

    def success(some: slice, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the weighted success under some errors, (D, errors, candidates)."""
        # One call for all errors: each would take 0.3 ms.
        tips = scored.candidates.tip[index] + shifts[some][:, index]
        every = np.tile(index, len(tips))
        moved = scored.candidates.take(every).at(tips.reshape(-1, 3))
        found = _success(moved, scored.opening[every], depths, *tests)
        return weights[some][:, None] * found.reshape(len(depths), len(tips), -1)

    first = slice(FIRST_ERRORS)
    part = success(first, np.arange(count))
    mean = part.sum(axis=1)
    beyond = slice(FIRST_ERRORS, None)
    # Beyond the first errors, success is about that under the larger ones of them.
    bound = mean + part[:, 1:].mean(axis=1) * weights[beyond].sum() / weights[1]
    rest = np.flatnonzero(bound.max(axis=0) > least ** (1.0 / exponent) * nominal)
    if len(rest) and len(errors) > FIRST_ERRORS:
        mean[:, rest] += success(beyond, rest).sum(axis=1)
    deeper = np.array(depths)[mean.round(6).argmax(axis=0)]
    return np.clip(mean.max(axis=0) / nominal, 0.0, 1.0) ** exponent, deeper


def sideways_term(
    candidates: Candidates,
    width: NDArray[np.float64],
    view_origin: NDArray[np.float64],
    hand: ParallelHand,
    options: JawOptions,
) -> NDArray[np.float64]:
    """Return the probability that an error of the scale leaves the object between the pads, (n,).

    It costs little, and selects the candidates for which :func:`depth_error_term` is computed.

    Parameters
    ----------
    candidates, width
        Candidates, and their distance between the pads at contact, (n,), m.
    view_origin
        Position of the camera, (3,), m.
    hand, options
        The hand and options; `depth_error` counts.
    """
    sight = candidates.tip - view_origin
    shift = np.abs(np.einsum("ij,ij->i", sight, candidates.rotation[:, :, 0]))
    room = 0.5 * np.maximum(hand.stroke - width, 0.0)
    return 2.0 * ndtr(room / np.maximum(options.depth_error * shift, MIN_SHIFT)) - 1.0


def held_probability(
    stopped: Candidates,
    opening: NDArray[np.float64],
    surface: ObjectSurface,
    hand: ParallelHand,
    options: JawOptions,
) -> NDArray[np.float64]:
    """Return the probability that jaws that close at given poses hold the object, (n,)."""
    columns = pad_contacts(stopped, surface, hand)
    meets = columns[:, 1] > 0.0
    angle = np.arccos(np.clip(columns[:, 2:4], -1.0, 1.0))
    held = ndtr((np.arctan(options.friction) - angle) / TILT_SIGMA).prod(axis=1)
    length = np.maximum(columns[:, 7] - columns[:, 6], 0.0) + SAMPLE_SPACING
    held *= expit((length - OVERLAP_MIDDLE) / OVERLAP_SCALE) * meets
    # The object must lie between the pads, not beside one of them.
    room = 0.5 * (opening - columns[:, 1]) - np.abs(columns[:, 0])
    return held * ndtr(room / np.hypot(CLEARANCE_SIGMA, options.calibration_error))


def _success(
    candidates: Candidates,
    opening: NDArray[np.float64],
    depths: Sequence[float],
    surface: ObjectSurface,
    scene: Scene,
    blocks: PointBlocks,
    hand: ParallelHand,
    options: JawOptions,
) -> NDArray[np.float64]:
    """Return the probability of success of candidates (n,) that go deeper (D,), m: (D, n).

    The depths increase from 0. A deeper approach also starts deeper.
    """
    travel = free_travel(candidates, opening, blocks, scene.support, hand, depths[-1])
    held = np.zeros((len(depths), len(travel)))
    for number, depth in enumerate(depths):
        rest = np.maximum(APPROACH + depth - travel, 0.0)
        free = travel >= depth - ALLOWANCE
        # What stopped the hand before stops it at the same place.
        changed = free.copy()
        if number:
            held[number] = held[number - 1]
            changed &= travel > APPROACH + depths[number - 1]
        index = np.flatnonzero(changed)
        tip = candidates.tip[index]
        tip = tip + (depth - rest[index])[:, None] * candidates.rotation[index][:, :, 2]
        stopped = candidates.take(index).at(tip)
        held[number, index] = held_probability(stopped, opening[index], surface, hand, options)
        held[number, ~free] = 0.0
        if not options.guarded:
            held[number, rest > REACHED] *= STOPPED_TERM
    return held
