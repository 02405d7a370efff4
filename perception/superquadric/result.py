"""What a fit says: the solid, the ladder it was chosen from, and what remains unknown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .shape import Kind, Superquadric
    from .uncertainty import Uncertainty

MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""
WITHIN_NOISE = 2.0
"""Criteria that differ by less than this do not tell two solids apart (Kass and Raftery 1995:
"not worth more than a bare mention")."""


@dataclass(frozen=True)
class Candidate:
    """One solid on the ladder."""

    superquadric: Superquadric
    """The fitted solid, in the cloud's frame."""
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
    """What a fit says. False in a condition when it did not converge."""

    superquadric: Superquadric | None
    """The chosen solid in the cloud's frame; None when there is none. Of several parts the
    largest."""
    converged: bool
    """Whether the solid can be used."""
    reason: str
    """Why it cannot, or an empty string."""
    residuals: NDArray[np.float64]
    """Signed first-order distances of the points used, (M,), m; from the union of several
    parts."""
    ladder: tuple[Candidate, ...]
    """One solid per kind tried, best first; of the largest part, as are doubts and alternatives."""
    seconds: float
    """Time the fit took."""
    uncertainty: Uncertainty | None = None
    """How sure each number is, and which sides the view left open; None without a solid."""
    alternatives: tuple[Candidate, ...] = ()
    """Other solids that explain the points as well, to within the noise, and differ in shape."""
    parts: tuple[Superquadric, ...] = ()
    """Solids that make up the object, largest first: one unless more were allowed and needed."""

    @classmethod
    def none(cls, reason: str, seconds: float = 0.0) -> SuperquadricFit:
        """Make the result that holds no solid, with the reason why."""
        return cls(None, False, reason, np.zeros(0), (), seconds)

    def __bool__(self) -> bool:
        return self.converged

    @property
    def spread(self) -> float:
        """Robust standard deviation of the points about the surface, m; infinite without one."""
        return robust_spread(self.residuals)

    @property
    def runner_up(self) -> Candidate | None:
        """Second best kind of solid."""
        return self.ladder[1] if len(self.ladder) > 1 else None

    @property
    def margin(self) -> float:
        """Criterion of the runner-up less that of the chosen kind; infinite without one."""
        if len(self.ladder) < 2:
            return float("inf")
        return self.ladder[1].criterion - self.ladder[0].criterion

    @property
    def ambiguous(self) -> bool:
        """Whether another shape explains the points as well, to within the noise."""
        return len(self.alternatives) > 0


def robust_spread(residuals: NDArray[np.float64]) -> float:
    """Standard deviation of a normal distribution with this median magnitude; inf when empty."""
    if residuals.size == 0:
        return float("inf")
    return float(MAD_TO_SIGMA * np.median(np.abs(residuals)))
