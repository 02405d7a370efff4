"""Superquadrics: the shape, its surface, and the fit to the points of one view."""

from .canonical import canonical
from .extents import SideEstimate, WidthEstimate
from .fit import fit_superquadric
from .free_space import FreeSpace, covered_share, outline_shares
from .kinds import EDGE_EXPONENT
from .options import FORMAT as FRONT_FORMAT
from .options import MAX_PARTS, STORED_FRONT, FitOptions, OptimiserName
from .result import CandidateSolid, SuperquadricFit
from .shape import MAX_EXPONENT, MAX_TAPER, MIN_EXPONENT, PARAMETER_COUNT, Kind, Superquadric
from .surface import mesh, sample_surface
from .uncertainty import PARAMETERS, Uncertainty
from .validity import MIN_POINTS
from .vessel import Rim, Vessel
from .vessel_mesh import vessel_mesh
from .view_evidence import ViewEvidence
from .wireframe import feature_curves

__all__ = [
    "EDGE_EXPONENT",
    "FRONT_FORMAT",
    "MAX_EXPONENT",
    "MAX_PARTS",
    "MAX_TAPER",
    "MIN_EXPONENT",
    "MIN_POINTS",
    "PARAMETERS",
    "PARAMETER_COUNT",
    "STORED_FRONT",
    "CandidateSolid",
    "FitOptions",
    "FreeSpace",
    "Kind",
    "OptimiserName",
    "Rim",
    "SideEstimate",
    "Superquadric",
    "SuperquadricFit",
    "Uncertainty",
    "Vessel",
    "ViewEvidence",
    "WidthEstimate",
    "canonical",
    "covered_share",
    "feature_curves",
    "fit_superquadric",
    "mesh",
    "outline_shares",
    "sample_surface",
    "vessel_mesh",
]
