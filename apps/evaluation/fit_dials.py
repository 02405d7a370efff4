"""The dials of the superquadric fit: every one alone, the main ones crossed."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any, get_args, get_type_hints

from eyehand.perception import FitOptions

from .dials import DialBoard

if TYPE_CHECKING:
    from collections.abc import Mapping

POINTS = (100, 200, 300, 500, 1000, 2000, 4000)
"""Points that a fit uses, up to all of a cloud of the chart."""
STARTS = (1, 2, 3, 6, 9)
NO_LADDER = ("superquadric",)
"""Kinds when the simplest solid is not looked for."""


def _present(dials: Mapping[str, tuple[Any, ...]]) -> dict[str, tuple[Any, ...]]:
    names = {one.name for one in fields(FitOptions)}
    return {name: values for name, values in dials.items() if name in names}


_OPTIMISERS = get_args(get_type_hints(FitOptions)["optimiser"])
_DEFAULT = FitOptions()

BOARD = DialBoard(
    default=_DEFAULT,
    dials=_present(
        {
            "points": POINTS,
            "optimiser": _OPTIMISERS,
            "starts": STARTS,
            "silhouette_rays": (_DEFAULT.silhouette_rays, 0),
            "plane_weight": (_DEFAULT.plane_weight, 0.0),
            "kinds": (_DEFAULT.kinds, NO_LADDER),
        }
    ),
    # Points are the main price of every step; what refines in the end and how many starts there
    # are matter less the more of them there are.
    crosses=(
        _present({"points": POINTS, "optimiser": ("lm", "slsqp", "lbfgs")}),
        _present({"points": POINTS, "starts": STARTS, "optimiser": ("lm",)}),
        _present({"points": (100, 200, 300, 500), "starts": (1, 3), "optimiser": ("lbfgs",)}),
        _present({"points": POINTS, "kinds": (NO_LADDER,), "optimiser": ("lm", "slsqp")}),
        _present(
            {
                "points": (100, 300, 1000),
                "optimiser": ("lm",),
                "starts": (1, 3),
                "silhouette_rays": (_DEFAULT.silhouette_rays, 0),
                "plane_weight": (_DEFAULT.plane_weight, 0.0),
            }
        ),
    ),
    quick={"points": (100, 300), "optimiser": ("lm",), "kinds": (NO_LADDER,)},
    words={
        **{("points", points): f"{points} points" for points in POINTS},
        **{("optimiser", name): name for name in _OPTIMISERS},
        **{("starts", n): f"{n} start{'s' if n > 1 else ''}" for n in STARTS},
        ("silhouette_rays", 0): "no rays",
        ("plane_weight", 0.0): "no plane",
        ("kinds", NO_LADDER): "no ladder",
    },
)
"""What the fit's chart turns."""
