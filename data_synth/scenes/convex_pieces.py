"""Convex pieces of a collision mesh, as the file has them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

MIN_CONVEXITY = 0.95
"""Minimum ratio of the volume of a piece to that of its hull. Below it, the parts of the mesh are
not meant as convex pieces."""


def connected_parts(
    vertices: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.int64], ...]:
    """Split the triangles (T, 3) of a mesh into its connected parts, each (K, 3)."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(len(vertices),) * 2)
    _, part = connected_components(graph, directed=False)
    numbers = part[faces[:, 0]]
    return tuple(faces[numbers == number] for number in np.unique(numbers))


def convex_pieces(
    vertices: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], ...]:
    """Return the vertices (P, 3) of each convex piece of a mesh, m.

    Each connected part must be a closed convex solid. Otherwise the result is empty: a scanned
    surface has parts that are no solids.
    """
    pieces = []
    for part in connected_parts(vertices, faces):
        corners = vertices[np.unique(part)]
        if len(corners) < 4:
            return ()
        try:
            hull = ConvexHull(corners).volume
        except QhullError:
            return ()
        if abs(_signed_volume(vertices, part)) < MIN_CONVEXITY * hull:
            return ()
        pieces.append(corners)
    return tuple(pieces)


def hull_volume(points: NDArray[np.float64]) -> float:
    """Return the volume of the convex hull of points (N, 3), m³."""
    return float(ConvexHull(points).volume)


def _signed_volume(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> float:
    a, b, c = (vertices[faces[:, k]] - vertices[faces[0, 0]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)
