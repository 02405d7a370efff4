"""Solids that end elsewhere behind an occluder or the image border, and explain the view too."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .effective_samples import effective_sample_size
from .free_space import FreeSpace, covered_share, ray_states
from .options import FitOptions
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
        for axis in range(3):
            for outwards in (solid.rotation[:, axis], -solid.rotation[:, axis]):
                found += _ends(view, axis, outwards)
    return tuple(found)


class _View(NamedTuple):
    """The fit, and the data to compare solids with it."""

    selected: CandidateSolid
    """The part whose sides move, with the criterion of the fit."""
    others: tuple[Superquadric, ...]
    """The other parts of the object."""
    points: NDArray[np.float64]
    samples: float
    """Effective number of samples in the points."""
    free_space: FreeSpace
    hidden: FreeSpace
    """The rays on which the object may be hidden, as a free space without any knowledge."""
    object_rays: int
    covered: float
    """Share of the pixels of the fit in empty space."""
    plane: NDArray[np.float64] | None
    noise: float

    def error(self, solid: Superquadric) -> float:
        """Return the log of the robust mean square of the points about a solid and the others."""
        distances = [np.abs(one.distance(self.points)) for one in (solid, *self.others)]
        return log_square(np.min(distances, axis=0), self.noise)

    def hidden_count(self, solid: Superquadric) -> int:
        """Return the number of hidden rays that meet a solid."""
        return int(np.count_nonzero(ray_states([solid], self.hidden, 0.0)))


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
    others = tuple(part for part in fit.parts if part is not solid)
    distances = np.array([one.distance(points) for one in (solid, *others)])
    nearest = np.argmin(np.abs(distances), axis=0)
    residuals = distances[nearest, np.arange(len(points))]
    nothing = np.zeros(len(rays))
    return _View(
        selected=replace(fit.candidates[0], superquadric=solid),
        others=others,
        points=points,
        samples=effective_sample_size(points, residuals),
        free_space=free_space,
        hidden=replace(free_space, rays=rays, depth=nothing, on_object=nothing.astype(bool)),
        object_rays=int(np.count_nonzero(free_space.on_object)),
        covered=covered_share([solid], free_space, SHAPE_TOLERANCE * options.noise),
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


def _ends(view: _View, axis: int, outwards: NDArray[np.float64]) -> list[CandidateSolid]:
    """Return the solids whose side along a direction (3,) ends last and first if hidden."""
    solid = view.selected.superquadric
    extent = 2.0 * float(solid.semi_axes[axis])
    least = max(MIN_CHANGE * extent, SHAPE_TOLERANCE * view.noise)
    base_error, base_hidden = view.error(solid), view.hidden_count(solid)

    def candidate(change: float) -> CandidateSolid | None:
        other = with_depth(solid, axis, -outwards, extent + change)
        hidden = (view.hidden_count(other) - base_hidden) * np.sign(change)
        if hidden < MIN_HIDDEN * view.object_rays or _is_refuted(view, other):
            return None
        evidence = view.samples * (view.error(other) - base_error)
        if evidence > MAX_EVIDENCE:
            return None
        criterion = view.selected.criterion + max(evidence, 0.0)
        return replace(view.selected, superquadric=other, criterion=criterion)

    found = []
    farther = candidate(least)
    if farther is not None:
        low, high = least, max(MAX_EXTENSION * 2.0 * float(solid.semi_axes.max()), least)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            tried = candidate(middle)
            low, high, farther = (middle, high, tried) if tried else (low, middle, farther)
        found.append(farther)
    beyond = float(solid.support(outwards)) - float((view.points @ outwards).max())
    # A solid far from its points would have no extent left.
    if least < beyond < MAX_SHRINK * extent:
        nearer = candidate(-beyond)
        found += [nearer] if nearer is not None else []
    return found


def _is_refuted(view: _View, solid: Superquadric) -> bool:
    """Return whether a solid fills empty space or passes the support plane."""
    tolerance = SHAPE_TOLERANCE * view.noise
    if view.plane is not None:
        normal, offset = view.plane[:3], float(view.plane[3])
        lowest = offset - float(solid.support(-normal))
        before = offset - float(view.selected.superquadric.support(-normal))
        if lowest < min(before, 0.0) - tolerance:
            return True
    covered = covered_share([solid], view.free_space, tolerance)
    return covered > view.covered + MORE_COVERED
