"""Describe a solid in a few words and numbers, in mm."""

from __future__ import annotations

from eyehand.perception import Superquadric, SuperquadricFit
from eyehand.perception.superquadric import Vessel

from ..scene_json import fit_parts

MAX_NAMED_PARTS = 3
"""Maximum number of parts named. Further parts are counted."""


def headline(fit: SuperquadricFit) -> tuple[str, str]:
    """Return two lines on a fit: kind and size; shape or opening, and spread of the points.

    Without a usable solid the second line gives the reason.
    """
    parts = fit_parts(fit)
    if not parts:
        return "no solid", fit.reason
    if fit.vessel is not None:
        name = "ring" if fit.vessel.through else "vessel"
        title = f"{name}, {_listed([size_text(part) for part in parts])}"
        shape = opening_text(fit.vessel)
    elif len(parts) == 1:
        title = f"{parts[0].kind}, {size_text(parts[0])}"
        shape = shape_text(parts[0])
    else:
        title = _listed([part.kind for part in parts])
        shape = _listed([size_text(part) for part in parts])
    if fit.reason:
        return title, f"cannot be used: {fit.reason}"
    return title, f"{shape}, {spread_text(fit)} over {fit.residuals.size} points"


def size_text(solid: Superquadric) -> str:
    """Return the full extents along its axes: ``80 × 80 × 98.5 mm``; the diameter of a sphere."""
    extents = [f"{2e3 * a:.1f}" for a in solid.semi_axes]
    if solid.kind == "sphere":
        return f"Ø {extents[0]} mm"
    return " × ".join(extents) + " mm"


def shape_text(solid: Superquadric) -> str:
    """Return exponents, and the taper if there is one."""
    text = f"ε {solid.exponents[0]:.2f} {solid.exponents[1]:.2f}"
    if any(solid.taper):
        text += f", taper {solid.taper[0]:.2f} {solid.taper[1]:.2f}"
    return text


def opening_text(vessel: Vessel) -> str:
    """Return the diameters of the rim and the wall: ``rim 80 × 80 mm, wall 3 mm``."""
    rim = " × ".join(f"{2e3 * a:.1f}" for a in vessel.rim.semi_axes)
    wall = "wall unknown" if vessel.wall is None else f"wall {1e3 * vessel.wall:.1f} mm"
    return f"rim {rim} mm, {wall}"


def spread_text(fit: SuperquadricFit) -> str:
    """Return the spread of the used points about the surface."""
    if not fit.residuals.size:
        return "no spread"
    return f"spread {fit.spread * 1e3:.2f} mm"


def _listed(words: list[str]) -> str:
    more = len(words) - MAX_NAMED_PARTS
    return " + ".join(words[:MAX_NAMED_PARTS]) + (f" + {more} more" if more > 0 else "")
