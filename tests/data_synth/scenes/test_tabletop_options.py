"""The tabletop options: range checks and their messages."""

from __future__ import annotations

from typing import Any

import pytest

from eyehand.data_synth import TabletopOptions, ViewOptions
from eyehand.errors import InputError


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"family": "heaped"}, "separate, touching, stacked, dropped, piled, got 'heaped'"),
        ({"kinds": ("box", "cone")}, "sphere, cylinder, ellipsoid, box, superquadric, got 'cone'"),
        ({"kinds": ()}, "one or more of sphere"),
        ({"count_range": (-1, 3)}, r"\[0, 15\] objects, got \(-1, 3\)"),
        ({"count_range": (3, 16)}, r"\[0, 15\] objects, got \(3, 16\)"),
        ({"family": "dropped", "count_range": (0, 3)}, r"\[1, 15\] objects, got \(0, 3\)"),
        ({"family": "piled", "count_range": (1, 3)}, r"\[2, 15\] objects, got \(1, 3\)"),
        ({"count_range": (5, 4)}, "two rising values"),
        ({"count_range": (1.5, 4)}, "whole numbers"),
        ({"count_range": (4,)}, "two rising values"),
        ({"family": "touching", "count_range": (1, 3)}, r"\[2, 15\] objects"),
        ({"family": "stacked", "kinds": ("sphere",)}, "flat top, box or cylinder, got sphere"),
        ({"width_range": (0.0, 0.1)}, "width_range"),
        ({"height_range": (0.1, float("nan"))}, "height_range"),
        ({"work_area": (2.0, 0.4)}, "work_area inside it"),
        ({"min_gap": -0.01}, "min_gap must lie in"),
        ({"pile_spread": float("inf")}, "pile_spread must lie in"),
    ],
)
def test_tabletop_options_reject_invalid_values(options: dict[str, Any], message: str):
    with pytest.raises(InputError, match=message):
        TabletopOptions(**options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"image_size": (0, 480)}, "image_size"),
        ({"elevation_range": (0.5, 2.0)}, "elevation_range"),
        ({"distance_range": (1.1, 0.6)}, "distance_range"),
    ],
)
def test_view_options_reject_invalid_values(options: dict[str, Any], message: str):
    with pytest.raises(InputError, match=message):
        ViewOptions(**options)
