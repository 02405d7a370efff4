"""Split an object that no one solid explains into few that do."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from .canonical import canonical
from .cost_kernels import distances
from .effective_samples import readings_of
from .part_assignment import (
    FEWEST,
    Shares,
    box_behind,
    buried_points,
    log_square,
    merged,
    nearest_parts,
    robust_cost,
    split_further,
)
from .part_cloud import PartCloud, Seen, part_cloud
from .problem import Guess
from .shape import PARAMETER_COUNT, Superquadric
from .validity import misses

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions
    from .result import Candidate, SuperquadricFit

EXPLAINED = 0.8
"""Share of the expected noise within which points are explained: surfaces have waves of their
own."""
MARGIN = 10.0
"""Parts must lower the criterion by more than this: very strong evidence (Kass and Raftery 1995),
and what a choice among many cuts finds by luck."""
BURIED_SHARE = 0.02
"""Share of points inside parts from which they are fitted again."""
PLANE_PARAMETERS = 3
"""Of a plane, where no one solid beats it."""
WORTH = PARAMETER_COUNT["box"]
"""Parameters that a further part must be worth before it is looked for."""
LEAST_PARAMETERS = PARAMETER_COUNT["sphere"]
"""Of the simplest part: where rough parts gain nothing even so, they are not fitted."""
ROUGH_PARAMETERS = PARAMETER_COUNT["superquadric"]
"""Of every rough part, while it is open how many there are."""
THINNEST = 0.1
"""Least extent of the first guess about a flat cloud, as a share of its largest."""


class FitOne(Protocol):
    """Fits one solid to a cloud."""

    def __call__(self, seen: Seen, options: FitOptions, /) -> SuperquadricFit:
        """Fit one solid, however many parts the options allow."""
        ...


class _Model(NamedTuple):
    """What explains a cloud, about its middle."""

    solids: tuple[Superquadric, ...]
    """Largest first; none where a plane stands for them."""
    fit: SuperquadricFit
    """Where the largest comes from."""
    residuals: NDArray[np.float64]
    """(N,) signed distances of the cloud's points from the union, m."""
    parameters: int
    """Numbers spent, the parts' shares of the points included."""


def in_parts(
    whole: SuperquadricFit, seen: Seen, options: FitOptions, fit_one: FitOne
) -> SuperquadricFit:
    """Split what one solid leaves unexplained, at most into ``options.max_parts``.

    Rough solids share the points out, one more at a time; then the numbers of parts compete by
    solids fitted in earnest to their shares. More parts stand if they lower the Bayesian
    information criterion clearly, on as many readings as their residuals leave.

    Parameters
    ----------
    whole
        The fit of one solid; without a solid where a plane explains the points as well.
    seen
        What that was fitted to.
    options
        The same, with ``max_parts``.
    fit_one
        Fits each part, with the rays that neither pass another part nor end on it.

    Returns
    -------
    SuperquadricFit
        Of the largest part by volume, with all parts and the residuals of their union; `whole`
        where they explain no more.
    """
    cloud = part_cloud(seen, options)
    one = _one_part(whole, cloud)
    chain, tried = _chain(one, cloud, options)
    best = one
    for shares in chain:
        model = _fitted(shares, cloud, options, fit_one)
        if model is not None and _better(model, best, cloud, options):
            best = model
    if best is not one:
        return _result(best, cloud)
    if whole or not tried:
        return whole
    return replace(whole, reason=f"{whole.reason} (no better in {tried} parts)")


def _one_part(whole: SuperquadricFit, cloud: PartCloud) -> _Model:
    if whole.superquadric is None:
        _, _, rows = np.linalg.svd(cloud.points, full_matrices=False)
        return _Model((), whole, cloud.points @ rows[2], PLANE_PARAMETERS)
    solid = _shifted(whole.superquadric, -cloud.centre)
    return _Model((solid,), whole, solid.distance(cloud.points), solid.parameter_count)


def _chain(one: _Model, cloud: PartCloud, options: FitOptions) -> tuple[list[Shares], str]:
    """Rough solids, few first, where they may be best; and which numbers were tried.

    One more at a time, while points are left to explain. A split that gains nothing yet may be on
    the way to one that does.
    """
    guess = _guess(one.solids[0]) if one.solids else _flat_guess(cloud)
    labels = np.zeros(len(cloud.points), dtype=np.int64)
    shares = Shares((guess,), labels, one.residuals, log_square(one.residuals, options))
    chain: list[Shares] = []
    while len(shares.guesses) < options.max_parts:
        splits = [
            split_further(shares, index, cloud, options)
            for index in range(len(shares.guesses))
            if _open(shares, index, cloud, options)
        ]
        found = [split for split in splits if split is not None]
        if not found:
            break
        shares = min(found, key=lambda split: split.score)
        chain.append(shares)
    if not chain:
        return [], ""
    # A first cut in the wrong place is mended by a later one, and then one part is too many.
    for index in range(len(chain) - 1, 0, -1):
        fewer = merged(chain[index], cloud, options)
        if fewer.score < chain[index - 1].score:
            chain[index - 1] = fewer
    tried = " or ".join(str(len(shares.guesses)) for shares in chain)
    readings = readings_of(cloud.points, chain[-1].residuals, options)

    def rough(shares: Shares, each: int) -> float:
        numbers = (each + 1) * len(shares.guesses)
        return _criterion(shares.residuals, numbers, readings, options)

    limit = _criterion(one.residuals, one.parameters, readings, options)
    hopeful = [shares for shares in chain if rough(shares, LEAST_PARAMETERS) < limit]
    leading = min((rough(shares, ROUGH_PARAMETERS) for shares in hopeful), default=0.0)
    near = leading + options.prune
    return [shares for shares in hopeful if rough(shares, ROUGH_PARAMETERS) <= near], tried


def _open(shares: Shares, index: int, cloud: PartCloud, options: FitOptions) -> bool:
    """Whether a further solid in one part could be worth its numbers.

    Not where the points lie within the expected noise already, nor where they would still be as
    far from any surface as they are from their neighbours.
    """
    if 2.0 * robust_cost(shares.residuals, options) < (EXPLAINED * options.noise) ** 2:
        return False
    best = np.where(shares.labels == index, cloud.waviness, shares.residuals)
    n = options.effective_points
    gain = n * (log_square(shares.residuals, options) - log_square(best, options))
    return gain > WORTH * np.log(n) + MARGIN


def _fitted(
    shares: Shares, cloud: PartCloud, options: FitOptions, fit_one: FitOne
) -> _Model | None:
    """Fit every part in earnest; None where one of them is none."""
    gaps = [distances(cloud.points, *guess) for guess in shares.guesses]
    labels = nearest_parts(gaps, cloud)
    model = _fitted_to(labels, len(gaps), cloud, options, fit_one)
    if model is None:
        return None
    # A part that reaches through another ends at the latest where the points lie that it buries.
    gaps = [solid.distance(cloud.points) for solid in model.solids]
    buried = buried_points(gaps, options)
    if np.mean(buried) < BURIED_SHARE:
        return model
    labels = np.where(buried, np.argmin(gaps, axis=0), nearest_parts(gaps, cloud))
    again = _fitted_to(labels, len(gaps), cloud, options, fit_one)
    if again is None:
        return model
    return min(model, again, key=lambda one: log_square(one.residuals, options))


def _fitted_to(
    labels: NDArray[np.int64], parts: int, cloud: PartCloud, options: FitOptions, fit_one: FitOne
) -> _Model | None:
    if np.bincount(labels, minlength=parts).min() < FEWEST:
        return None
    found: list[tuple[Superquadric, SuperquadricFit | None]] = []
    for index in range(parts):
        part = cloud.part(labels, index, options)
        fit = fit_one(part, options)
        if fit.superquadric is not None and fit:
            found.append((fit.superquadric, fit))
            continue
        guess = box_behind(part, options) if fit.superquadric is None else None
        if guess is None:
            return None
        found.append((_box(guess), None))
    found.sort(key=lambda one: -one[0].volume)
    solids = tuple(solid for solid, _ in found)
    largest = found[0][1]
    # How deep a single face reaches is a guess: it may not be what the object is.
    if largest is None:
        return None
    residuals = np.min([solid.distance(cloud.points) for solid in solids], axis=0)
    numbers = sum(solid.parameter_count + 1 for solid in solids) - 1
    return _Model(solids, largest, residuals, numbers)


def _better(model: _Model, than: _Model, cloud: PartCloud, options: FitOptions) -> bool:
    if misses(model.residuals, cloud.unit, options):
        return False
    origin = cloud.seen.origin
    if origin is not None and any(solid.contains(origin) for solid in model.solids):
        return False
    n = readings_of(cloud.points, model.residuals, options)
    after = _criterion(model.residuals, model.parameters, n, options)
    return after + MARGIN < _criterion(than.residuals, than.parameters, n, options)


def _criterion(
    residuals: NDArray[np.float64], parameters: int, readings: float, options: FitOptions
) -> float:
    """As :func:`ladder.criterion`, in m and of the points alone."""
    return readings * log_square(residuals, options) + parameters * float(np.log(readings))


def _result(model: _Model, cloud: PartCloud) -> SuperquadricFit:
    parts = tuple(_shifted(solid, cloud.centre) for solid in model.solids)

    def back(candidate: Candidate) -> Candidate:
        return replace(candidate, superquadric=_shifted(candidate.superquadric, cloud.centre))

    return replace(
        model.fit,
        superquadric=parts[0],
        residuals=model.residuals,
        ladder=tuple(back(candidate) for candidate in model.fit.ladder),
        alternatives=tuple(back(candidate) for candidate in model.fit.alternatives),
        parts=parts,
    )


def _guess(solid: Superquadric) -> Guess:
    return Guess(
        np.log(solid.semi_axes),
        np.array(solid.exponents),
        np.ascontiguousarray(solid.rotation),
        solid.centre.copy(),
        np.array(solid.taper),
    )


def _flat_guess(cloud: PartCloud) -> Guess:
    """An ellipsoid over the cloud's spread."""
    _, sizes, rows = np.linalg.svd(cloud.points, full_matrices=False)
    rows[2] *= np.linalg.det(rows)
    axes = np.log(np.maximum(sizes, THINNEST * sizes[0]) / np.sqrt(len(cloud.points)))
    return Guess(axes, np.ones(2), np.ascontiguousarray(rows.T), np.zeros(3))


def _box(guess: Guess) -> Superquadric:
    pose = RigidTransform.from_components(guess.c, Rotation.from_matrix(guess.R))
    exponents = (float(guess.eps[0]), float(guess.eps[1]))
    return canonical(Superquadric(np.exp(guess.axes), exponents, pose, "box"))


def _shifted(solid: Superquadric, by: NDArray[np.float64]) -> Superquadric:
    return replace(solid, pose=RigidTransform.from_translation(by) * solid.pose)
