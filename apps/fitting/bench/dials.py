"""The dials of the superquadric fit: every one alone, the main ones crossed."""

from __future__ import annotations

from typing import get_args

from eyehand.perception import FitOptions
from eyehand.perception.superquadric import OptimiserName

from ...bench import DialBoard

POINTS = (100, 200, 300, 500, 1000, 2000, 4000)
"""Points that a fit uses, up to all of a cloud of the chart."""
STARTS = (1, 2, 3, 6, 9)
MAX_MINIMA = (1, 2, 3, 5)
FAST_POINTS = (100, 200, 300)
"""Points of fits that tell no kind: what small budgets buy. Those with more are a curve of their
own, since what they save is the answer of the model selection."""
NO_TAPER = ("sphere", "cylinder", "ellipsoid", "box", "superquadric")
"""Kinds when no solid narrows."""
NO_LADDER = ("superquadric",)
"""Kinds when the simplest solid is not looked for."""


_OPTIMISERS = get_args(OptimiserName)
_DEFAULT = FitOptions()

BOARD = DialBoard(
    default=_DEFAULT,
    dials={
        "points": POINTS,
        "optimiser": _OPTIMISERS,
        "starts": STARTS,
        "max_minima": MAX_MINIMA,
        "silhouette_rays": (_DEFAULT.silhouette_rays, 0),
        "plane_weight": (_DEFAULT.plane_weight, 0.0),
        "kinds": (_DEFAULT.kinds, NO_TAPER),
    },
    # Points, starts and kinds are the price of most steps; what refines in the end, and whether
    # rays and plane take part, cost less and matter at every price.
    crosses=(
        {"points": POINTS, "optimiser": ("lm",), "max_minima": (_DEFAULT.max_minima, 1)},
        {"points": POINTS, "optimiser": ("lm",), "kinds": (NO_TAPER,), "starts": (1, 3)},
        {"points": FAST_POINTS, "optimiser": ("lm",), "kinds": (NO_LADDER,), "starts": (1, 3)},
        {
            "points": (100, 300, 1000),
            "optimiser": ("lm",),
            "silhouette_rays": (_DEFAULT.silhouette_rays, 0),
            "plane_weight": (_DEFAULT.plane_weight, 0.0),
        },
    ),
    quick={"points": (100, 300), "optimiser": ("lm",), "kinds": (NO_TAPER,)},
    words={
        **{("points", points): f"{points} points" for points in POINTS},
        **{("optimiser", name): name for name in _OPTIMISERS},
        **{("starts", n): f"{n} start{'s' if n > 1 else ''}" for n in STARTS},
        **{("max_minima", n): f"{n} minim{'a' if n > 1 else 'um'}" for n in MAX_MINIMA},
        ("silhouette_rays", 0): "no rays",
        ("plane_weight", 0.0): "no plane",
        ("kinds", NO_TAPER): "no taper",
        ("kinds", NO_LADDER): "no ladder",
    },
)
"""What the fit's chart turns."""
