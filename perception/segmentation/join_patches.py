"""Join patches into objects by global evidence on the graph of all patches."""

from __future__ import annotations

import heapq

import cv2
import numpy as np
from numpy.typing import NDArray

from .ambiguity import FLAT, HIDDEN, NEARLY, UncertainJoin
from .label_pixels import pixels_by_label, renumber_labels
from .local_planes import LocalPlanes
from .patch_edges import PatchEdges, patch_edges
from .sliver_pixels import clear_borders, measure_patches, replace_by_nearest
from .working_image import WorkingImage

# Log-odds that two patches are one object, fitted by logistic regression on 1,400 labelled edges:
# Kinect frames of a table, rendered touching, stacked and piled solids, and frames of four other
# sources with annotated points. Both classes and all sources weighed the same. Edges of a left-out
# source were decided right in 76 % (bins) to 100 %. The weights of concave borders, patches apart
# and hidden surfaces were then raised, because errors add up over the many edges of a graph.
PRIOR = 1.8
"""Log-odds without any evidence; the two below and free space are nearly always against it."""
CONTACT_GAIN = -1.1
"""Per unit of contact: a border is evidence only by what it looks like."""
TOUCHING_GAIN = 4.5
"""A long border without a depth step."""
CONCAVITY_GAIN = -4.0
"""A long concave border."""
CONVEX_GAIN = 0.5
"""A long border that is convex by ``CONVEX_ANGLE`` or more."""
CROSSING_GAIN = -6.8
"""All lines between both patches cross free space."""
CONTINUED_GAIN = 2.0
"""The surfaces continue each other behind an occluder."""
APART_GAIN = -2.2
"""The patches do not touch."""
COLOUR_GAIN = 2.2
"""Per unit of evidence of equal colours between patches that touch. Fits without one source in turn
gave 2.2 to 2.4."""
UNLIKE_GAIN = 3.5
"""Per unit of evidence of different colours between patches that touch. With 2.2, 2 more of 128
objects are wrong, 1 each in two of four sources. 5.5 is no better."""
EQUAL_HIDDEN_GAIN = 1.0
"""Per unit of evidence of equal colours between patches apart. Different ones are no evidence: the
parts of a box on both sides of an occluder often show different prints."""
CONVEX_ANGLE = 0.5
"""Convex angle that counts fully, rad."""

SLIVER_WIDTH = 3.6
"""Half width below which a patch is a sliver, px at the reference width."""
SLIVER_AREA = 1200
"""Maximum size of a sliver, px at the reference width."""
SPECK_AREA = 120
"""Patches below this size are slivers of any width, px at the reference width."""
MIN_TOUCHING, MIN_CONTACT = 0.3, 0.3
"""Minimum evidence of a border between joined regions for them to be joined in the second round:
share without a depth step, and contact. Regions that meet at a corner are often neighbours. With
0.5 the halves of a real object flip when a few readings change, with 0.2 neighbours are joined."""
REGION_PRIOR = 0.3
"""Log-odds added in the second round: lines between large regions of one object cross free space
more often. With 0 some bowls stay in halves, with 0.6 solids in a heap are joined."""
EQUAL_COLOUR = 0.6
"""Weight of equal colours in the second round: neighbours in a tote may have one colour. With 0.4
parts of real objects stay apart."""
NEARLY_JOINED = -1.7
"""Log-odds of two regions that touch above which they may be one object."""
BRIDGE = 5
"""Distance over which patches replace the slivers between them, px at the reference width."""
FLAT_ANGLE = 0.06
"""Mean angle of a border below which it cannot be decided if its parts are one object, rad."""
FLAT_SHARE = 0.15
"""Minimum share of an object on either side of such a border."""


def join_patches(
    patches: NDArray[np.int32],
    image: WorkingImage,
    planes: LocalPlanes,
    window: int,
    min_object: int,
    *,
    hidden: bool = True,
) -> tuple[NDArray[np.int32], list[UncertainJoin]]:
    """Join patches (H, W) into objects; parts below `min_object` px are never uncertain.

    With `hidden`, surfaces that continue each other behind an occluder are evidence too.

    Every pair of patches with a common border, or with surfaces that continue each other behind an
    occluder, is an edge of a graph. Its weight is the log-odds that both are one object. The edge
    with the largest weight is contracted, weights of parallel edges are added up, and this goes on
    until no weight is positive (greedy additive edge contraction, Keuper et al. 2015). Then the
    evidence between the joined regions is measured anew, and they are joined in the same way once
    more: a small patch shows little of the surface that it belongs to.

    Slivers, which noise leaves between two objects, must not join these. They are left out at
    first, and their neighbours meet across them. At the end each sliver joins the object to which
    it has the most positive edge.

    Returns
    -------
    labels, uncertain
        Objects (H, W) int32 in arbitrary numbers, 0 stays 0; and the decisions that may be wrong.
    """
    count = int(patches.max(initial=0))
    if count < 2:
        return patches, []
    slivers = find_slivers(patches, image)
    broad = replace_by_nearest(patches, slivers, image.length(BRIDGE)) if slivers.any() else patches
    edges = patch_edges(broad, image, planes, window, hidden=hidden)
    parent = contract_edges(edges.pairs, edge_weights(edges), count)
    uncertain: list[UncertainJoin] = []
    if have_contact(edges, parent):
        regions = renumber_labels(broad, parent)
        joined, uncertain = _join_regions(regions, image, planes, window, count)
        parent = joined[parent]
    if slivers.any():
        # Few pixels have no reliable colour: it changed the score of no annotated frame.
        plain = image._replace(colour=None)
        thin = patch_edges(patches, plain, planes, window, hidden=False, beside=slivers)
        _attach_slivers(thin.pairs, edge_weights(thin), slivers, parent)
    uncertain += _uncertain_joins(patches, edges, parent, min_object)
    return renumber_labels(patches, parent), uncertain


def edge_weights(edges: PatchEdges) -> NDArray[np.float64]:
    """Return the log-odds (K,) that the two patches of each edge are one object."""
    convex = np.clip(np.nan_to_num(-edges.angle) / CONVEX_ANGLE, 0.0, 1.0)
    border = (
        CONTACT_GAIN
        + TOUCHING_GAIN * edges.touching
        + CONCAVITY_GAIN * edges.concavity
        + CONVEX_GAIN * convex
    )
    equal, touching = np.maximum(edges.colour, 0.0), edges.contact > 0
    return (
        PRIOR
        + edges.contact * border
        + CROSSING_GAIN * edges.crossing
        + CONTINUED_GAIN * edges.continued
        + APART_GAIN * ~touching
        + COLOUR_GAIN * equal * touching
        + UNLIKE_GAIN * (edges.colour - equal) * touching
        + EQUAL_HIDDEN_GAIN * equal * ~touching
    )


def contract_edges(
    pairs: NDArray[np.int64], weights: NDArray[np.float64], count: int
) -> NDArray[np.int32]:
    """Contract positive edges, largest first; return the object of each node, (count + 1,).

    Parameters
    ----------
    pairs
        (K, 2) nodes in 1..count, each pair once.
    weights
        (K,) log-odds that both nodes are one object.
    count
        Number of nodes.
    """
    neighbours: list[dict[int, float]] = [{} for _ in range(count + 1)]
    heap = []
    for (a, b), weight in zip(pairs.tolist(), weights.tolist(), strict=True):
        neighbours[a][b] = neighbours[b][a] = weight
        if weight > 0:
            heap.append((-weight, a, b))
    heapq.heapify(heap)
    parent = np.arange(count + 1, dtype=np.int32)
    while heap:
        cost, a, b = heapq.heappop(heap)
        # Entries of edges that have changed since are out of date.
        if neighbours[a].get(b) != -cost:
            continue
        parent[parent == b] = a
        del neighbours[a][b], neighbours[b][a]
        for c, weight in neighbours[b].items():
            del neighbours[c][b]
            total = weight + neighbours[a].get(c, 0.0)
            neighbours[a][c] = neighbours[c][a] = total
            if total > 0:
                heapq.heappush(heap, (-total, min(a, c), max(a, c)))
        neighbours[b] = {}
    return parent


def have_contact(edges: PatchEdges, parent: NDArray[np.int32]) -> bool:
    """Return whether two different objects have contact over at least ``MIN_CONTACT``."""
    first, second = np.sort(parent[edges.pairs], axis=1).T
    apart = first != second
    border = first[apart] * np.int64(len(parent)) + second[apart]
    _, index = np.unique(border, return_inverse=True)
    return bool(np.bincount(index, edges.contact[apart] ** 2).max(initial=0.0) >= MIN_CONTACT**2)


def _join_regions(
    regions: NDArray[np.int32],
    image: WorkingImage,
    planes: LocalPlanes,
    window: int,
    count: int,
) -> tuple[NDArray[np.int32], list[UncertainJoin]]:
    """Join regions (H, W) that touch, by evidence between them.

    Returns (count + 1,) new labels, and the pairs of regions that were nearly joined.
    """
    edges = patch_edges(regions, image, planes, window, hidden=False)
    colour = np.where(edges.colour > 0, EQUAL_COLOUR * edges.colour, edges.colour)
    weights = edge_weights(edges._replace(colour=colour)) + REGION_PRIOR
    loose = (edges.touching < MIN_TOUCHING) | (edges.contact < MIN_CONTACT)
    weights = np.where(loose, np.minimum(weights, 0.0), weights)
    parent = contract_edges(edges.pairs, weights, count)
    near = (weights > NEARLY_JOINED) & ~loose
    order, starts = pixels_by_label(regions, count)
    nearly = [
        UncertainJoin(int(order[starts[a]]), int(order[starts[b]]), NEARLY)
        for a, b in edges.pairs[near].tolist()
        if parent[a] != parent[b]
    ]
    return parent, nearly


def find_slivers(patches: NDArray[np.int32], image: WorkingImage) -> NDArray[np.bool_]:
    """Return the mask (n + 1,) of patches that are narrow or tiny."""
    # Single missing readings do not make a patch narrow.
    kernel = np.ones((3, 3), np.uint8)
    inner = np.asarray(cv2.morphologyEx((patches > 0).astype(np.uint8), cv2.MORPH_CLOSE, kernel))
    clear_borders(patches, inner)
    distance = cv2.distanceTransform(inner, cv2.DIST_L2, 3)
    sizes, half_width = measure_patches(patches, distance, int(patches.max(initial=0)))
    narrow = (half_width < SLIVER_WIDTH * image.scale) & (sizes < image.area(SLIVER_AREA))
    slivers = narrow | (sizes < image.area(SPECK_AREA))
    slivers[0] = False
    return slivers


def _attach_slivers(
    pairs: NDArray[np.int64],
    weights: NDArray[np.float64],
    slivers: NDArray[np.bool_],
    parent: NDArray[np.int32],
) -> None:
    """Set the parents of slivers: first those beside broad patches, then their neighbours."""
    support: dict[int, dict[int, float]] = {}
    between: list[tuple[float, int, int]] = []
    for (a, b), weight in zip(pairs.tolist(), weights.tolist(), strict=True):
        if weight <= 0:
            continue
        if slivers[a] and slivers[b]:
            between.append((-weight, a, b))
        elif slivers[a] or slivers[b]:
            sliver, other = (a, b) if slivers[a] else (b, a)
            totals = support.setdefault(sliver, {})
            owner = int(parent[other])
            totals[owner] = totals.get(owner, 0.0) + weight
    attached = set(support)
    for sliver, totals in support.items():
        parent[sliver] = max(totals, key=lambda owner: totals[owner])
    for _, a, b in sorted(between):
        if (a in attached) != (b in attached):
            free, held = (b, a) if a in attached else (a, b)
            parent[free] = parent[held]
            attached.add(free)


def _uncertain_joins(
    patches: NDArray[np.int32], edges: PatchEdges, parent: NDArray[np.int32], min_object: int
) -> list[UncertainJoin]:
    """Return the joins of large parts across a flat border or behind an occluder."""
    order, starts = pixels_by_label(patches, len(parent) - 1)
    sizes = np.diff(starts)
    whole = np.bincount(parent, weights=sizes)
    uncertain: list[UncertainJoin] = []
    for k, (a, b) in enumerate(edges.pairs.tolist()):
        small = min(sizes[a], sizes[b])
        if parent[a] != parent[b] or small < max(FLAT_SHARE * whole[parent[a]], min_object):
            continue
        flat = abs(edges.angle[k]) <= FLAT_ANGLE and edges.contact[k] > 0
        hidden = edges.contact[k] == 0 and edges.continued[k] > 0
        if flat or hidden:
            reason = FLAT if flat else HIDDEN
            uncertain.append(UncertainJoin(int(order[starts[a]]), int(order[starts[b]]), reason))
    return uncertain
