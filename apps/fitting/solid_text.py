"""A solid in a few words and numbers for people: mm and two digits of an exponent."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..scene_json import fit_parts

if TYPE_CHECKING:
    from eyehand.perception import Superquadric, SuperquadricFit

NAMED_PARTS = 3
"""More parts than these are counted, not named."""


def headline(fit: SuperquadricFit) -> tuple[str, str]:
    """Two lines on a fit: what it is and how large; its shape and how well the points agree.

    Where there is no solid, or one that cannot be used, the second line says why.
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


def _listed(words: list[str]) -> str:
    more = len(words) - NAMED_PARTS
    return " + ".join(words[:NAMED_PARTS]) + (f" + {more} more" if more > 0 else "")
