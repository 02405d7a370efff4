"""The answer of a fitter to one cloud."""

from __future__ import annotations

from dataclasses import dataclass

from eyehand.perception import Superquadric, SuperquadricFit

from ...scene_json import fit_parts

FAILED = 0.5
"""IoU below which a fit has failed, as in the literature."""


@dataclass(frozen=True)
class FitAnswer:
    """The answer of a fitter."""

    parts: tuple[Superquadric, ...]
    """Solids, largest first. Usually one; empty without a solid."""
    reason: str = ""
    """Why there is no solid or it must not be used; empty if it is usable."""
    doubted: bool = False
    """Whether the fitter states a doubt about the shape of a usable solid."""

    @classmethod
    def of(cls, found: Superquadric | SuperquadricFit | None) -> FitAnswer:
        """Return the answer for what a fitter returned."""
        if found is None:
            return cls((), "no solid found")
        if isinstance(found, Superquadric):
            return cls((found,))
        reason = found.reason or ("" if found else "not converged")
        return cls(fit_parts(found), reason, is_doubted(found))

    @property
    def usable_parts(self) -> tuple[Superquadric, ...]:
        """The parts of a usable solid; empty if the fitter gives a reason against it."""
        return () if self.reason else self.parts


def is_doubted(fit: SuperquadricFit) -> bool:
    """Return whether a usable fit states a doubt about its shape."""
    stated = bool(fit.reason) or fit.ambiguous or fit.outline_differs
    return bool(fit) and (stated or fit.width_uncertain)
