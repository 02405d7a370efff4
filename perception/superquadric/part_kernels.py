"""Compiled steps of the search for parts: votes of neighbours, seams, and what a part hides."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def vote_parts(gaps, neighbours):
    """Return the part (N,) nearest to most of each point and its neighbours.

    Parameters
    ----------
    gaps
        (P, N) signed distances of the points from each part.
    neighbours
        (N, K) indices of the neighbours of each point.
    """
    parts, n = gaps.shape
    nearest = np.zeros(n, dtype=np.int64)
    for i in range(n):
        for p in range(1, parts):
            if abs(gaps[p, i]) < abs(gaps[nearest[i], i]):
                nearest[i] = p
    labels = np.zeros(n, dtype=np.int64)
    votes = np.empty(parts, dtype=np.int64)
    for i in range(n):
        votes[:] = 0
        votes[nearest[i]] += 1
        for k in neighbours[i]:
            votes[nearest[k]] += 1
        for p in range(1, parts):
            if votes[p] > votes[labels[i]]:
                labels[i] = p
    return labels


@njit(cache=True, nogil=True, error_model="numpy")
def seam_share(labels, neighbours):
    """Return the share of the points (N,) with a neighbour (N, K) of another label."""
    count = 0
    for i in range(labels.size):
        for k in neighbours[i]:
            if labels[k] != labels[i]:
                count += 1
                break
    return count / labels.size


@njit(cache=True, nogil=True, error_model="numpy")
def hides_places(places, points, image, in_part, frame, origin, clearance):
    """Return whether a part hides all of some places from the camera.

    A place is hidden if the nearest point in the image lies within the clearance, in front of the
    place, and on the part.

    Parameters
    ----------
    places, points
        (P, 3), (N, 3).
    image
        (M, 2) positions of the points in the image plane at unit depth, M >= N.
    in_part
        (N,) mask of the points of the part.
    frame, origin
        (3, 3) axes of the image plane and the viewing direction as rows, (3,) camera.
    clearance
        Distance in the image.
    """
    for place in places:
        offset = place - origin
        local = np.zeros(3)
        for k in range(3):
            for j in range(3):
                local[k] += frame[k, j] * offset[j]
        x, y = local[0] / local[2], local[1] / local[2]
        least, nearest = np.inf, 0
        for i in range(points.shape[0]):
            dx, dy = image[i, 0] - x, image[i, 1] - y
            square = dx * dx + dy * dy
            if square < least:
                least, nearest = square, i
        front = points[nearest] - origin
        behind = np.sum(offset * offset) > np.sum(front * front)
        if not (behind and in_part[nearest] and least < clearance * clearance):
            return False
    return True
