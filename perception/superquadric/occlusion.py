"""Solids that end elsewhere behind an occluder or the image border, and explain the view too."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .cost_kernels import distances
from .effective_samples import effective_sample_size
from .free_space import FreeSpace, solid_parameters
from .free_space_kernels import covers_free_space
from .options import FitOptions
from .parameters import N_PARAMETERS, ShapeParameters
from .plane_kernels import plane_gap
from .problem import Observation
from .result import SHAPE_TOLERANCE, CandidateSolid, SuperquadricFit
from .robust import log_square
from .shape import Superquadric
from .unseen_depth import with_depth

MIN_BESIDE = 3
"""Minimum number of rays on an occluder that border the object. Fewer are single pixels."""
BESIDE_PITCHES = 1.6
"""Angle between neighbours on the grid of rays, in pitches. It includes the diagonal."""
MIN_CHANGE = 0.2
"""Change of an extent below which an alternative is no other solid, as a share of the extent."""
MAX_EXTENSION = 1.5
"""Maximum extension of a side, in the longest extent of the solid."""
MAX_SHRINK = 0.95
"""Share of its extent by which a side moves inwards at most."""
MIN_HIDDEN = 0.04
"""Minimum number of hidden rays that an alternative gains or loses, over those on the object."""
MORE_COVERED = 0.02
"""Increase of the share of pixels in empty space up to which an alternative agrees with the view.
The pixels of an edge cause as much."""
MAX_EVIDENCE = 6.0
"""Difference of the criterion up to which points do not refute a solid: less than strong evidence
(Kass and Raftery 1995). The alternatives are not fitted, so that "not worth more than a bare
mention" would refute most of them."""
POINTS = 600
"""Points on which solids are compared."""
HALVINGS = 4
"""Halvings of the range of an extension: to 6 % of it."""
BORDER_STEPS = 20
"""Rays beyond the image border for each ray on it."""


def occlusion_alternatives(
    fit: SuperquadricFit, observation: Observation, options: FitOptions
) -> tuple[CandidateSolid, ...]:
    """Return solids that end elsewhere where the view does not show the end of the object.

    That is so behind a nearer object, and beyond the border of the image. Each side of the solid
    moves outwards until the view or the points refute it, and inwards to the last point seen. The
    criterion of an alternative states its evidence against that of the fit.

    Parameters
    ----------
    fit
        The fit of the object.
    observation
        The data of that fit.
    options
        The options of that fit.

    Returns
    -------
    tuple
        At most two solids per side of each part, in place of that part; none if nothing hides the
        object, or it is a vessel.
    """
    free_space = observation.free_space
    if fit.superquadric is None or free_space is None or fit.vessel or not fit.candidates:
        return ()
    rays = _hidden_rays(free_space)
    if not len(rays):
        return ()
    found: list[CandidateSolid] = []
    for solid in fit.parts or (fit.superquadric,):
        view = _view(fit, solid, rays, observation, options)
        shape = view.shape
        base = _Unmoved(
            view.error(shape), view.hidden_count(shape), view.covered(shape), view.lowest(shape)
        )
        for axis in range(3):
            for outwards in (shape.R[:, axis], -shape.R[:, axis]):
                found += _ends(view, base, axis, outwards)
    return tuple(found)


class _View(NamedTuple):
    """The fit, and the data to compare solids with it. Shapes are in m, in the frame of the fit."""

    selected: CandidateSolid
    """The part whose sides move, with the criterion of the fit."""
    shape: ShapeParameters
    """Its parameters."""
    points: NDArray[np.float64]
    others: NDArray[np.float64]
    """Distances of the points from the other parts of the object."""
    samples: float
    """Effective number of samples in the points."""
    free_space: FreeSpace
    hidden: NDArray[np.float64]
    """(M, 3) rays on which the object may be hidden."""
    object_rays: int
    plane: NDArray[np.float64] | None
    noise: float

    def error(self, shape: ShapeParameters) -> float:
        """Return the log of the robust mean square of the points about a solid and the others."""
        own = np.abs(distances(self.points, shape))
        return log_square(np.minimum(own, self.others), self.noise)

    def hidden_count(self, shape: ShapeParameters) -> int:
        """Return the number of hidden rays that meet a solid."""
        nothing = np.zeros(len(self.hidden))
        states = covers_free_space(self.hidden, nothing, self.free_space.origin, shape)
        return int(np.count_nonzero(states))

    def covered(self, shape: ShapeParameters) -> float:
        """Return the share of the pixels of a solid in empty space."""
        depth = self.free_space.depth - SHAPE_TOLERANCE * self.noise
        states = covers_free_space(self.free_space.rays, depth, self.free_space.origin, shape)
        return np.count_nonzero(states > 1) / max(np.count_nonzero(states), 1)

    def lowest(self, shape: ShapeParameters) -> float:
        """Return the height of the lowest point over the support plane, 0 without one."""
        if self.plane is None:
            return 0.0
        tapered = bool(shape.taper.any())
        return plane_gap(self.plane, shape, tapered, np.empty(N_PARAMETERS), np.empty(3))


class _Unmoved(NamedTuple):
    """The measures of the solid before its sides move; see the methods of :class:`_View`."""

    error: float
    hidden_count: int
    covered: float
    lowest: float


def _view(
    fit: SuperquadricFit,
    solid: Superquadric,
    rays: NDArray[np.float64],
    observation: Observation,
    options: FitOptions,
) -> _View:
    free_space = observation.free_space
    assert free_space is not None
    rng = np.random.default_rng(options.seed)
    points = observation.cloud.points
    points = points[rng.permutation(len(points))[:POINTS]]
    parts = [solid, *(part for part in fit.parts if part is not solid)]
    gaps = np.array([distances(points, solid_parameters(part)) for part in parts])
    nearest = np.argmin(np.abs(gaps), axis=0)
    return _View(
        selected=replace(fit.candidates[0], superquadric=solid),
        shape=solid_parameters(solid),
        points=points,
        others=np.abs(gaps[1:]).min(axis=0, initial=np.inf),
        samples=effective_sample_size(points, gaps[nearest, np.arange(len(points))]),
        free_space=free_space,
        hidden=rays,
        object_rays=int(np.count_nonzero(free_space.on_object)),
        plane=observation.plane,
        noise=options.noise,
    )


def _hidden_rays(free_space: FreeSpace) -> NDArray[np.float64]:
    """Return the rays (M, 3) that meet something in front of the object or leave the image.

    There are none if these rays do not border the object.
    """
    on_object = free_space.on_object
    if not on_object.any():
        return np.zeros((0, 3))
    own = free_space.rays[on_object]
    occluded, angle = free_space.occluders
    beside = occluded & (angle < BESIDE_PITCHES * free_space.pitch)
    found = [free_space.rays[occluded]] if np.count_nonzero(beside) >= MIN_BESIDE else []
    found.append(_beyond_image(own, free_space))
    return np.concatenate(found)


def _beyond_image(own: NDArray[np.float64], free_space: FreeSpace) -> NDArray[np.float64]:
    """Return rays (M, 3) beyond the image border that cuts the object, whose rays are (K, 3).

    The grid of rays surrounds the object, unless the image ends there. Then rays on the object have
    neighbours on one side only.
    """
    near = own @ free_space.rays.T > np.cos(BESIDE_PITCHES * free_space.pitch)
    counts = near.sum(axis=1)
    # All 8 neighbours and the ray itself.
    cut = counts < 9
    if np.count_nonzero(cut) < MIN_BESIDE:
        return np.zeros((0, 3))
    outwards = own[cut] - (near[cut] @ free_space.rays) / counts[cut, None]
    outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-12)
    steps = free_space.pitch * np.arange(1, BORDER_STEPS + 1)
    rays = (own[cut, None] + steps[:, None] * outwards[:, None]).reshape(-1, 3)
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def _ends(
    view: _View, base: _Unmoved, axis: int, outwards: NDArray[np.float64]
) -> list[CandidateSolid]:
    """Return the solids whose side along a direction (3,) ends last and first if hidden."""
    solid = view.selected.superquadric
    extent = 2.0 * float(solid.semi_axes[axis])
    least = max(MIN_CHANGE * extent, SHAPE_TOLERANCE * view.noise)

    def evidence(change: float) -> float | None:
        return _evidence(view, base, _with_extent(view.shape, axis, outwards, change), change)

    found = []
    farther = evidence(least)
    if farther is not None:
        low, high = least, max(MAX_EXTENSION * 2.0 * float(solid.semi_axes.max()), least)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            tried = evidence(middle)
            low, high, farther = (low, middle, farther) if tried is None else (middle, high, tried)
        found.append((low, farther))
    beyond = float(solid.support(outwards)) - float((view.points @ outwards).max())
    # A solid far from its points would have no extent left.
    if least < beyond < MAX_SHRINK * extent and (nearer := evidence(-beyond)) is not None:
        found.append((-beyond, nearer))
    return [
        replace(
            view.selected,
            superquadric=with_depth(solid, axis, -outwards, extent + change),
            criterion=view.selected.criterion + max(against, 0.0),
        )
        for change, against in found
    ]


def _with_extent(
    shape: ShapeParameters, axis: int, outwards: NDArray[np.float64], change: float
) -> ShapeParameters:
    """Return the solid whose side along a direction of an axis has moved outwards by `change`."""
    log_axes = shape.log_axes.copy()
    log_axes[axis] = np.log(np.exp(log_axes[axis]) + 0.5 * change)
    return shape._replace(log_axes=log_axes, centre=shape.centre + 0.5 * change * outwards)


def _evidence(view: _View, base: _Unmoved, shape: ShapeParameters, change: float) -> float | None:
    """Return the evidence against a solid with a moved side; None if it is no alternative.

    A solid is no alternative if the hidden pixels hardly change, or the view or the points refute
    it.
    """
    hidden = (view.hidden_count(shape) - base.hidden_count) * np.sign(change)
    if hidden < MIN_HIDDEN * view.object_rays:
        return None
    if view.lowest(shape) < min(base.lowest, 0.0) - SHAPE_TOLERANCE * view.noise:
        return None
    if view.covered(shape) > base.covered + MORE_COVERED:
        return None
    evidence = view.samples * (view.error(shape) - base.error)
    return evidence if evidence <= MAX_EVIDENCE else None
