"""Superquadrics: the shape, its surface, and the fit to one view's points."""

from .canonical import canonical
from .fit import Candidate, SuperquadricFit, fit_superquadric
from .options import FitOptions
from .shape import MAX_EXPONENT, MIN_EXPONENT, PARAMETER_COUNT, Kind, Superquadric
from .surface import mesh, sample_surface

__all__ = [
    "MAX_EXPONENT",
    "MIN_EXPONENT",
    "PARAMETER_COUNT",
    "Candidate",
    "FitOptions",
    "Kind",
    "Superquadric",
    "SuperquadricFit",
    "canonical",
    "fit_superquadric",
    "mesh",
    "sample_surface",
]
