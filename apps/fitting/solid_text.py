"""Describe a solid in a few words and numbers, in mm."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..scene_json import fit_parts

if TYPE_CHECKING:
    from eyehand.perception import Superquadric, SuperquadricFit

MAX_NAMED_PARTS = 3
"""Maximum number of parts named. Further parts are counted."""


def headline(fit: SuperquadricFit) -> tuple[str, str]:
    """Return two lines on a fit: kind and size; shape and spread of the points.

    Without a usable solid the second line gives the reason.
    """
    parts = fit_parts(fit)
    if not parts:
        return "no solid", fit.reason
    if len(parts) == 1:
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


def spread_text(fit: SuperquadricFit) -> str:
    """Return the spread of the used points about the surface."""
    if not fit.residuals.size:
        return "no spread"
    return f"spread {fit.spread * 1e3:.2f} mm"


def _listed(words: list[str]) -> str:
    more = len(words) - MAX_NAMED_PARTS
    return " + ".join(words[:MAX_NAMED_PARTS]) + (f" + {more} more" if more > 0 else "")
