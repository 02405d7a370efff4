"""Superquadrics: the shape, its surface, and the fit to one view's points."""

from .canonical import canonical
from .fit import fit_superquadric
from .options import FitOptions, OptimiserName
from .result import Candidate, SuperquadricFit
from .shape import MAX_EXPONENT, MAX_TAPER, MIN_EXPONENT, PARAMETER_COUNT, Kind, Superquadric
from .surface import mesh, sample_surface
from .uncertainty import PARAMETERS, Uncertainty

__all__ = [
    "MAX_EXPONENT",
    "MAX_TAPER",
    "MIN_EXPONENT",
    "PARAMETERS",
    "PARAMETER_COUNT",
    "Candidate",
    "FitOptions",
    "Kind",
    "OptimiserName",
    "Superquadric",
    "SuperquadricFit",
    "Uncertainty",
    "canonical",
    "fit_superquadric",
    "mesh",
    "sample_surface",
]
