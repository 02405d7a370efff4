"""Space around an object that one view shows to be empty."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from eyehand.errors import InputError

from .free_space_kernels import covers_free_space
from .neighbour_kernels import nearest_neighbours
from .parameters import ShapeParameters
from .shape import Superquadric

OCCLUDER_GAP = 0.01
"""A reading this much nearer than the object's edge belongs to an object in front, m."""
STRAIGHT_PITCHES = 1.2
"""Angle to the straight neighbours of a ray, in pitches. The diagonal ones are farther."""
MIN_HOLE_RAYS = 4
"""Minimum number of rays through a hole. Fewer are single pixels."""
NEIGHBOURS = 4
"""Rays of the grid around a direction."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class FreeSpace:
    """The empty space along the rays of one view, on a regular grid around one object.

    Raises
    ------
    InputError
        If the arrays have wrong shapes.
    """

    origin: NDArray[np.float64]
    """(3,) position of the camera, m, in the frame of the object's points."""
    rays: NDArray[np.float64]
    """(K, 3) unit directions from the camera."""
    depth: NDArray[np.float64]
    """(K,) distance along each ray up to which the view shows empty space, m. It is 0 where nothing
    is known, and the distance of the surface that the ray meets elsewhere. A solid may continue
    behind that surface."""
    on_object: NDArray[np.bool_]
    """(K,) whether the surface that the ray meets belongs to the object."""
    pitch: float
    """Angle between neighbouring rays, rad."""

    def __post_init__(self) -> None:
        count = len(self.rays)
        for name, shape in (
            ("origin", (3,)),
            ("rays", (count, 3)),
            ("depth", (count,)),
            ("on_object", (count,)),
        ):
            actual = np.shape(getattr(self, name))
            if actual != shape:
                raise InputError(f"{name} of a free space must have shape {shape}, got {actual}")

    def shifted(self, by: NDArray[np.float64]) -> FreeSpace:
        """Return the same free space in a frame whose origin lies at -`by` (3,), m."""
        return replace(self, origin=self.origin + by)

    def hides(self, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask (M,) of unit directions (M, 3) that carry no information on the outline.

        Such a direction lies beside the grid (outside the image), meets or borders a surface in
        front of the object, or meets the object itself.
        """
        if not len(self.rays):
            return np.ones(len(directions), dtype=bool)
        count = min(NEIGHBOURS, len(self.rays))
        distances, around = nearest_neighbours(self.rays, directions, count)
        outside = distances[:, 0] > 2.0 * np.sin(0.5 * self.pitch)
        inside = self.on_object[around].all(axis=1)
        in_front, _ = self.occluders
        return outside | in_front[around].any(axis=1) | inside

    @property
    def hole_share(self) -> float:
        """Number of rays through holes of the object over that of the rays on it, 0 without one."""
        return float(self.holes.sum() / max(np.count_nonzero(self.on_object), 1))

    @cached_property
    def holes(self) -> NDArray[np.bool_]:
        """Mask (K,) of the rays through holes of the object.

        A hole is a group of rays that meet something behind the object and are enclosed by it.
        """
        found = np.zeros(len(self.rays), dtype=bool)
        outside = np.flatnonzero(~self.on_object)
        if not len(outside) or not self.on_object.any():
            return found
        links = KDTree(self.rays[outside]).query_pairs(
            STRAIGHT_PITCHES * self.pitch, output_type="ndarray"
        )
        graph = coo_array((np.ones(len(links)), links.T), shape=(len(outside), len(outside)))
        count, group = connected_components(graph, directed=False)
        sizes = np.bincount(group, minlength=count)
        behind = (self.depth[outside] > 0) & ~self.occluders[0][outside]
        is_hole = np.bincount(group, weights=behind, minlength=count) == sizes
        is_hole &= (sizes >= MIN_HOLE_RAYS) & (sizes < sizes.max())
        found[outside] = is_hole[group]
        return found

    @cached_property
    def occluders(self) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """Rays that meet something in front of the object, and the angle of all rays to the object.

        The first is a mask (K,) of rays whose surface is nearer than the object's nearest edge. The
        second is the angle (K,) to the nearest ray on the object, rad, infinite without one.
        """
        if not self.on_object.any():
            return np.zeros(len(self.rays), dtype=bool), np.full(len(self.rays), np.inf)
        cosines = self.rays @ self.rays[self.on_object].T
        edge = np.argmax(cosines, axis=1)
        angle = np.arccos(np.minimum(cosines[np.arange(len(edge)), edge], 1.0))
        edge_depth = self.depth[self.on_object][edge]
        in_front = (self.depth > 0) & (self.depth < edge_depth - OCCLUDER_GAP) & ~self.on_object
        return in_front, angle


class OutlineShares(NamedTuple):
    """Wrong pixels of the outline of solids."""

    covered: float
    """Share of the pixels of the solids in space seen to be empty, 0-1."""
    missed: float
    """Share of the pixels of the object that the solids do not meet, 0-1."""
    beside: float
    """Share of the pixels of the solids in such space outside holes of the object, 0-1."""


def covered_share(solids: Iterable[Superquadric], free_space: FreeSpace, tolerance: float) -> float:
    """Return the share of the pixels of a union of solids that lie in space seen to be empty, 0-1.

    Parameters
    ----------
    solids
        Solids in the frame of the free space.
    free_space
        The rays and the empty space along them.
    tolerance
        Length by which a ray may enter a solid too early, m: a multiple of the depth noise.

    Returns
    -------
    float
        Number of rays that enter a solid in empty space over the number of rays that meet a
        solid. It is 0 if no ray meets one.
    """
    return outline_shares(solids, free_space, tolerance).covered


def outline_shares(
    solids: Iterable[Superquadric], free_space: FreeSpace, tolerance: float
) -> OutlineShares:
    """Return the wrong pixels of the outline of a union of solids; see :func:`covered_share`."""
    states = ray_states(solids, free_space, tolerance)
    missed = states[free_space.on_object] == 0
    covered, solid = states > 1, max(np.count_nonzero(states > 0), 1)
    count = np.count_nonzero(covered)
    # Few solids cover enough for the search for holes.
    in_holes = np.count_nonzero(covered & free_space.holes) if count > MIN_HOLE_RAYS else 0
    return OutlineShares(
        covered=float(count / solid),
        missed=float(np.count_nonzero(missed) / max(len(missed), 1)),
        beside=float((count - in_holes) / solid),
    )


def solid_parameters(
    solid: Superquadric, unit: float = 1.0, origin: NDArray[np.float64] | float = 0.0
) -> ShapeParameters:
    """Return the parameters of a solid in a frame with this unit, m, and origin (3,), m."""
    return ShapeParameters(
        log_axes=np.log(solid.semi_axes / unit),
        exponents=np.array(solid.exponents),
        R=np.ascontiguousarray(solid.rotation),
        centre=(solid.centre - origin) / unit,
        taper=np.array(solid.taper),
    )


def ray_states(
    solids: Iterable[Superquadric], free_space: FreeSpace, tolerance: float
) -> NDArray[np.int8]:
    """Return the largest state (K,) of each ray over all solids.

    See :func:`~.free_space_kernels.covers_free_space` for the states.
    """
    states = np.zeros(len(free_space.rays), dtype=np.int8)
    for solid in solids:
        shape = solid_parameters(solid)
        depth = free_space.depth - tolerance
        own = covers_free_space(free_space.rays, depth, free_space.origin, shape)
        np.maximum(states, own, out=states)
    return states
