"""The result of a fit: the solid, the candidates it was selected from, and its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eyehand.errors import InputError

from ..perpendicular import perpendicular_pair
from .extents import (
    ExtentModel,
    SideEstimate,
    WidthEstimate,
    estimate_sides,
    estimate_widths,
    extent_model,
    inflated_covariance,
)
from .robust import robust_spread
from .shape import Kind, Superquadric
from .uncertainty import Uncertainty
from .vessel import Vessel
from .view_evidence import ViewEvidence

AMBIGUOUS_MARGIN = 2.0
"""Criteria that differ by less do not distinguish two solids (Kass and Raftery 1995: "not worth
more than a bare mention")."""
SHAPE_TOLERANCE = 3.0
"""Two solids have another shape if their extents differ by more than so many times the noise."""
DOUBTFUL_COVERED, DOUBTFUL_MISSED = 0.03, 0.12
"""Shares of covered and missed pixels above which the outline of a solid differs from that of the
object. On household meshes, all solids with an IoU below 0.5 have larger ones."""

MAX_WIDTH_SIGMA = 0.012
"""Standard deviation above which a width is uncertain, m. An error of 10 mm then has a probability
of 0.4. Chosen on half of the household meshes: 8.5 mm flags 4 to 7 % more views for 0 to 1 % fewer
unusable fits without a flag."""
WIDTH_DIRECTIONS = 6
"""Directions over half a turn in which widths are tested. They are 30° apart."""


@dataclass(frozen=True)
class CandidateSolid:
    """The best solid of one kind."""

    superquadric: Superquadric
    """The fitted solid, in the frame of the cloud."""
    spread: float
    """Robust standard deviation of the points about its surface, m."""
    criterion: float
    """Bayesian information criterion; lower is better."""

    @property
    def kind(self) -> Kind:
        """Kind of the solid."""
        return self.superquadric.kind


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class SuperquadricFit:
    """The result of a fit. ``bool(fit)`` is false if the fit did not converge."""

    superquadric: Superquadric | None
    """The selected solid in the frame of the cloud, of several parts the largest; None if there is
    none."""
    converged: bool
    """Whether the solid can be used."""
    reason: str
    """Why it cannot be used, or an empty string."""
    residuals: NDArray[np.float64]
    """Signed first-order distances of the points used from the solid, or from the union of several
    parts, (M,), m."""
    candidates: tuple[CandidateSolid, ...]
    """One solid per kind that was fitted, best first. Candidates, uncertainty and alternatives are
    those of the largest part."""
    seconds: float
    """Time of the fit, s."""
    uncertainty: Uncertainty | None = None
    """First-order covariance of the parameters, and the sides that the view does not show; None
    without a solid. `sides`, `width` and `covariance` add the error of the model."""
    alternatives: tuple[CandidateSolid, ...] = ()
    """Solids of another shape that explain the points about as well. Where an occluder or the image
    border hides the end of the object, some of them end elsewhere, each in place of one part. Where
    the view does not show the depth, the last ones are the thinnest and the deepest possible
    solid."""
    parts: tuple[Superquadric, ...] = ()
    """Solids of the object, largest first: one unless `max_parts` allows more and they are
    needed."""
    vessel: Vessel | None = None
    """The object as a vessel or ring, if the view shows its opening; `superquadric` is its outer
    solid."""
    covered_share: float = 0.0
    """Share of the pixels of the solids that lie in space seen to be empty, 0-1; see
    :func:`covered_share`. It is 0 for clouds without a :class:`FreeSpace`."""
    evidence: ViewEvidence | None = None
    """The view of the object, which bounds its sides; None for results that no fit made."""
    missed_share: float = 0.0
    """Share of the object's pixels that the solids do not meet, 0-1; see :func:`outline_shares`."""
    constrained: bool = False
    """Whether constraints moved the solid out of space seen to be empty. Then no such solid
    explains both the points and that space."""

    @classmethod
    def rejected(cls, reason: str, seconds: float = 0.0) -> SuperquadricFit:
        """Return a result without a solid."""
        return cls(None, False, reason, np.zeros(0), (), seconds)

    def __bool__(self) -> bool:
        return self.converged

    @property
    def solid(self) -> Superquadric | Vessel | None:
        """The vessel if the object is one, else the superquadric; None if there is none."""
        return self.vessel or self.superquadric

    @property
    def spread(self) -> float:
        """Robust standard deviation of the points about the surface, m; infinite without one."""
        return robust_spread(self.residuals)

    @cached_property
    def sides(self) -> tuple[SideEstimate, ...]:
        """The six sides along the axes of the solid, in the order +x -x +y -y +z -z.

        Of several parts they are the sides of the union, along the axes of the largest part.
        Empty without a solid. Computed once, in about 3 ms.
        """
        return () if self._extents is None else estimate_sides(self._extents)

    def width(self, direction: ArrayLike) -> WidthEstimate | None:
        """Return the width of the union of the parts along a direction (3,); None without a solid.

        Raises
        ------
        InputError
            If the direction is not a vector of 3 finite numbers, or has no length.
        """
        vector = np.asarray(direction, dtype=np.float64)
        length = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
        if not 0.0 < length < np.inf:
            raise InputError(f"direction must be a vector of 3 finite numbers, got {direction}")
        return None if self._extents is None else self.widths(vector[None] / length)[0]

    def widths(self, directions: NDArray[np.float64]) -> tuple[WidthEstimate, ...]:
        """Return the widths along unit directions (K, 3); empty without a solid.

        One call for several directions takes little more time than one direction.
        """
        return () if self._extents is None else estimate_widths(self._extents, directions)

    @cached_property
    def covariance(self) -> NDArray[np.float64] | None:
        """Covariance (13, 13) in the order of PARAMETERS that agrees with the sides' deviations.

        It is the first-order one of `uncertainty`, with the model's error of each side added to
        semi-axes and centre; None without a solid.
        """
        return None if self._extents is None else inflated_covariance(self._extents)

    @cached_property
    def _extents(self) -> ExtentModel | None:
        if self.superquadric is None:
            return None
        return extent_model(
            self.parts or (self.superquadric,),
            self.uncertainty,
            self.evidence,
            tuple(other.superquadric for other in self.alternatives),
        )

    @property
    def runner_up(self) -> CandidateSolid | None:
        """The candidate with the second best criterion."""
        return self.candidates[1] if len(self.candidates) > 1 else None

    @property
    def margin(self) -> float:
        """Criterion of the runner-up minus that of the selected kind; infinite without one."""
        if len(self.candidates) < 2:
            return float("inf")
        return self.candidates[1].criterion - self.candidates[0].criterion

    @property
    def outline_differs(self) -> bool:
        """Whether the outline of the solids differs from that of the object.

        Then the object is no such solid, and its unseen sides may lie elsewhere.
        """
        wrong = self.covered_share > DOUBTFUL_COVERED or self.missed_share > DOUBTFUL_MISSED
        return wrong or self.constrained

    @cached_property
    def width_uncertain(self) -> bool:
        """Whether the deviation of a width along the support plane is above MAX_WIDTH_SIGMA.

        A view from the side hardly shows the depth of an object. False without a support plane.
        Computed once, in about 4 ms.
        """
        if self.evidence is None or self.evidence.plane is None:
            return False
        x, y = perpendicular_pair(self.evidence.plane[:3])
        turns = np.arange(WIDTH_DIRECTIONS) * np.pi / WIDTH_DIRECTIONS
        widths = [self.width(np.cos(turn) * x + np.sin(turn) * y) for turn in turns]
        return any(width is not None and width.sigma > MAX_WIDTH_SIGMA for width in widths)

    @property
    def ambiguous(self) -> bool:
        """Whether a solid of another shape explains the points equally well."""
        return len(self.alternatives) > 0
