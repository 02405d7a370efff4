"""Evidence that two patches are one object: their border, free space, and hidden continuation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .border_votes import (
    BEND_REACH,
    BEND_SIGMAS,
    CONCAVITY,
    CONTACT,
    PAIRS,
    WEIGHT,
    BorderLimits,
    border_votes,
    sum_border_votes,
)
from .continuation_votes import AGREEING, REACHING, continuation_limits, continuation_votes
from .convexity import HOLLOW, region_convexity
from .free_space import count_free_lines
from .label_pixels import LINES, pixels_by_label
from .local_planes import CREASE_SIGMAS, STEP_SIGMAS, LocalPlanes
from .patch_colours import colour_evidence
from .working_image import WorkingImage

LONG_CONTACT = 40
"""Contact from which a border counts with full weight, px at the reference width."""
MIN_AGREEING = 5
"""Minimum number of pixels that continue behind an occluder, for two patches to have an edge."""
MILD_ANGLE, FULL_ANGLE = 0.35, 0.61
"""Mean concave angle of a border from which it counts, and from which it counts fully, rad. Seams
inside objects are concave by up to 20°."""
FULL_BENDS = 6.0
"""Weight of the bends of a border from which its angle is reliable, px."""


class PatchEdges(NamedTuple):
    """The K pairs of patches with evidence for or against being one object."""

    pairs: NDArray[np.int64]
    """(K, 2) patch numbers, the smaller one first."""
    contact: NDArray[np.float64]
    """(K,) root of the length in contact over ``LONG_CONTACT``, at most 1; 0 without contact."""
    touching: NDArray[np.float64]
    """(K,) share of the border without a depth step, 0-1."""
    concavity: NDArray[np.float64]
    """(K,) concave angle of the border, from 0 at ``MILD_ANGLE`` to 1 at ``FULL_ANGLE``."""
    angle: NDArray[np.float64]
    """(K,) mean angle of the border, rad, > 0 where it is concave; NaN where it is unknown."""
    crossing: NDArray[np.float64]
    """(K,) share of the lines between both patches that cross free space, 0-1."""
    continued: NDArray[np.float64]
    """(K,) agreement of the surfaces behind an occluder, 0-1."""
    colour: NDArray[np.float64]
    """(K,) log-likelihood ratio of the colours; 0 in an image without colour."""


def patch_edges(
    patches: NDArray[np.int32],
    image: WorkingImage,
    planes: LocalPlanes,
    window: int,
    *,
    hidden: bool,
    beside: NDArray[np.bool_] | None = None,
) -> PatchEdges:
    """Measure the evidence between all patches that touch or continue each other.

    Parameters
    ----------
    patches
        Labels 1..n (H, W), 0 = no patch.
    image
        Their image.
    planes
        Its local planes.
    window
        Side of the windows of the plane fit, px.
    hidden
        Whether to look for surfaces that continue each other behind an occluder.
    beside
        (n + 1,) bool: patches whose borders are measured. Default: all.
    """
    count = int(patches.max(initial=0))
    if beside is None:
        beside = np.ones(count + 1, np.bool_)
    borders = _sum_votes(patches, beside, image, planes)
    votes = None
    found = set(borders)
    if hidden:
        limits = continuation_limits(image, window)
        votes = continuation_votes(patches, image.disparity, planes, count, limits)
        votes = votes + votes.transpose(1, 0, 2)
        continued = np.argwhere(np.triu(votes[..., AGREEING] >= MIN_AGREEING, 1))
        found.update((a, b) for a, b in continued.tolist())
    pairs = np.array(sorted(found), np.int64).reshape(-1, 2)
    pixels = pixels_by_label(patches, count)
    hollow = region_convexity(patches, image, planes, pixels) < HOLLOW
    crossing = count_free_lines(patches, pairs, hollow, image, pixels) / LINES
    none = np.zeros(4)
    sums = np.array([borders.get((a, b), none) for a, b in pairs.tolist()]).reshape(-1, 4)
    reaching = agreeing = np.zeros(len(pairs))
    if votes is not None:
        reaching, agreeing = (votes[pairs[:, 0], pairs[:, 1], k] for k in (REACHING, AGREEING))
    long = LONG_CONTACT * image.scale
    bends = sums[:, WEIGHT]
    angle = sums[:, CONCAVITY] / np.maximum(bends, 1e-6)
    steepness = np.clip((angle - MILD_ANGLE) / (FULL_ANGLE - MILD_ANGLE), 0.0, 1.0)
    colour = np.zeros(len(pairs))
    if image.colour is not None:
        colour = colour_evidence(patches, image.colour, pairs)
    return PatchEdges(
        pairs,
        contact=np.sqrt(np.minimum(sums[:, CONTACT] / long, 1.0)),
        touching=sums[:, CONTACT] / np.maximum(sums[:, PAIRS], 1.0),
        concavity=steepness * np.minimum(bends / FULL_BENDS, 1.0),
        angle=np.where(bends > 0, angle, np.nan),
        crossing=crossing,
        continued=np.minimum(agreeing / long, 1.0) * agreeing / np.maximum(reaching, 1.0),
        colour=colour,
    )


def _sum_votes(
    patches: NDArray[np.int32],
    beside: NDArray[np.bool_],
    image: WorkingImage,
    planes: LocalPlanes,
) -> dict[tuple[int, int], NDArray[np.float64]]:
    """Sum the votes of the pixel pairs over each border."""
    limits = BorderLimits(
        np.float32(STEP_SIGMAS * image.noise),
        np.float32(CREASE_SIGMAS * image.noise),
        np.float32(BEND_SIGMAS * image.noise),
        image.length(BEND_REACH),
    )
    pairs, votes = border_votes(patches, beside, image.disparity, planes, image.pinhole, limits)
    summed, sums = sum_border_votes(pairs, votes, len(beside) - 1)
    return {(a, b): row for (a, b), row in zip(summed.tolist(), sums, strict=True)}
