"""The solids of a fit as they are drawn and written to mesh files: vessels with their cavity."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.perception import Superquadric, SuperquadricFit
from eyehand.perception.superquadric import Vessel, feature_curves, mesh, vessel_mesh

from .scene_json import fit_parts


def drawn_solids(fit: SuperquadricFit) -> tuple[Superquadric | Vessel, ...]:
    """Return the solids of a fit, largest first, with the vessel in place of its outer solid."""
    return tuple(
        fit.vessel if fit.vessel is not None and part is fit.vessel.outer else part
        for part in fit_parts(fit)
    )


def solid_mesh(
    solid: Superquadric | Vessel, resolution: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return a closed mesh of a solid: vertices (V, 3), m, and faces (T, 3)."""
    if isinstance(solid, Vessel):
        return vessel_mesh(solid, resolution)
    return mesh(solid, resolution)


def solid_curves(solid: Superquadric | Vessel) -> list[NDArray[np.float64]]:
    """Return the lines (K, 3) that show a shape, m: of a vessel its rim and its outer lines."""
    if not isinstance(solid, Vessel):
        return feature_curves(solid)
    rim = solid.rim.points()
    # The lines at the closed end of the outer solid would cross the opening.
    outer = [
        curve
        for curve in feature_curves(solid.outer)
        if float(solid.heights(curve).max()) < solid.edge_height
    ]
    return [np.vstack([rim, rim[:1]]), *outer]
