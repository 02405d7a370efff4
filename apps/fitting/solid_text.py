"""A solid in a few words and numbers for people: mm and two digits of an exponent."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from eyehand.perception import Superquadric, SuperquadricFit


def size_text(solid: Superquadric) -> str:
    """Full extents along its axes: ``80 x 80 x 98.5 mm``; of a sphere the diameter."""
    extents = [f"{2e3 * a:.1f}" for a in solid.semi_axes]
    if solid.kind == "sphere":
        return f"Ø {extents[0]} mm"
    return " × ".join(extents) + " mm"


def shape_text(solid: Superquadric) -> str:
    """Exponents, and the taper where there is one."""
    text = f"ε {solid.exponents[0]:.2f} {solid.exponents[1]:.2f}"
    if any(solid.taper):
        text += f", taper {solid.taper[0]:.2f} {solid.taper[1]:.2f}"
    return text


def spread_text(fit: SuperquadricFit) -> str:
    """Spread of the points used about the surface."""
    if not fit.residuals.size:
        return "no spread"
    return f"spread {fit.spread * 1e3:.2f} mm"
