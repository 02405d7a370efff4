"""The dials of the superquadric fit: each one alone, and the main ones combined."""

from __future__ import annotations

from typing import get_args

from eyehand.perception import FitOptions
from eyehand.perception.superquadric import OptimiserName

from ...bench import DialBoard

POINTS = (50, 100, 200, 300, 500, 1000, 2000, 4000)
"""Number of points that a fit uses. The clouds of the chart have the largest number."""
STARTS = (1, 2, 3, 6, 9)
MAX_MINIMA = (1, 2, 3, 5)
PARTS = (1, 2, 3, 4)
"""Maximum number of parts."""
ONE_OR_FOUR = (1, 4)
"""The same for small time budgets, in which the search for parts has no place."""
FAST_POINTS = (50, 100, 200, 300)
"""Number of points of fits without model selection, for small time budgets. The chart shows such
fits with more points as a separate curve, because they do not determine the kind."""
NO_TAPER = ("sphere", "cylinder", "ellipsoid", "box", "superquadric")
"""Kinds without tapered solids."""
SUPERQUADRIC_ONLY = ("superquadric",)
"""The only kind of a fit without model selection."""

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
        "max_parts": PARTS,
    },
    # Points, starts and kinds determine most of the time. The other dials cost less, and matter
    # for fast and slow fits alike.
    crosses=(
        {"points": POINTS, "optimiser": ("lm",), "max_minima": (_DEFAULT.max_minima, 1)},
        {
            "points": POINTS,
            "optimiser": ("lm",),
            "kinds": (NO_TAPER,),
            "starts": (1, 3),
            "max_parts": ONE_OR_FOUR,
        },
        {
            "points": FAST_POINTS,
            "optimiser": ("lm",),
            "kinds": (SUPERQUADRIC_ONLY,),
            "starts": (1, 3),
            "max_parts": ONE_OR_FOUR,
        },
        {"points": (300, 1000), "max_parts": PARTS},
        {
            "points": (100, 300, 1000),
            "optimiser": ("lm",),
            "silhouette_rays": (_DEFAULT.silhouette_rays, 0),
            "plane_weight": (_DEFAULT.plane_weight, 0.0),
        },
    ),
    quick={
        "max_parts": ONE_OR_FOUR,
        "points": (100, 300),
        "optimiser": ("lm",),
        "kinds": (NO_TAPER,),
    },
    words={
        **{("points", points): f"{points} points" for points in POINTS},
        **{("optimiser", name): name for name in _OPTIMISERS},
        **{("starts", n): f"{n} start{'s' if n > 1 else ''}" for n in STARTS},
        **{("max_minima", n): f"{n} minim{'a' if n > 1 else 'um'}" for n in MAX_MINIMA},
        **{("max_parts", n): f"{n} part{'s' if n > 1 else ''}" for n in PARTS},
        ("silhouette_rays", 0): "no rays",
        ("plane_weight", 0.0): "no plane",
        ("kinds", NO_TAPER): "no taper",
        ("kinds", SUPERQUADRIC_ONLY): "superquadric only",
    },
)
"""All dials of the chart."""
