"""Distances to the true surface of objects, and their height from above."""

import numpy as np
import pytest

from eyehand.data_synth.pad import Part, TouchObject, surface_distance, top_surface, unknown_object

PARTS = (
    Part("sphere", (0.03,), (0.01, 0.0, 0.0)),
    Part("capsule", (0.01, 0.03), (0.0, 0.01, 0.0), (0.8, 0.6, 0.0, 0.0)),
    Part("ellipsoid", (0.05, 0.03, 0.02), (0.0, 0.0, 0.01), (0.5, 0.5, 0.5, 0.5)),
    Part("cylinder", (0.02, 0.01), (0.0, 0.0, 0.0), (0.6, 0.0, 0.8, 0.0)),
    Part("box", (0.02, 0.03, 0.01), (0.0, 0.0, 0.0), (0.6, 0.0, 0.0, 0.8)),
)


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.kind)
def test_points_seen_from_above_lie_on_the_surface_and_distance_grows_with_slope_one(
    part: Part,
) -> None:
    thing = TouchObject("thing", (part,))
    x, y = np.random.default_rng(0).uniform(-0.06, 0.06, (2, 400))
    z = top_surface(thing, x, y)
    seen = ~np.isnan(z)
    assert 10 < np.count_nonzero(seen) < 400
    on = np.column_stack([x, y, z])[seen]
    assert np.abs(surface_distance(thing, on)).max() < 1e-9
    # The distance's gradient points to the surface: following it leads onto it.
    away = on + np.array([0.01, 0.005, 0.02])
    distance = surface_distance(thing, away)
    steps = 1e-6 * np.eye(3)
    gradient = np.column_stack(
        [
            (surface_distance(thing, away + s) - surface_distance(thing, away - s)) / 2e-6
            for s in steps
        ]
    )
    assert np.linalg.norm(gradient, axis=1) == pytest.approx(1.0, abs=1e-3)
    feet = away - distance[:, None] * gradient
    assert np.abs(surface_distance(thing, feet)).max() < 1e-4


def test_middle_of_an_ellipsoid_and_points_on_its_axes_are_exact() -> None:
    thing = TouchObject("egg", (Part("ellipsoid", (0.05, 0.03, 0.02)),))
    points = [[0, 0, 0], [0.06, 0, 0], [0, -0.04, 0], [0, 0, 0.01]]
    assert surface_distance(thing, points) == pytest.approx([-0.02, 0.01, 0.01, -0.01], abs=1e-9)


def test_the_unknown_object_has_a_ridge_and_a_block_on_its_dome() -> None:
    heights = top_surface(unknown_object(), [0.0, -0.04, 0.045, 0.2], [0.0, 0.01, -0.012, 0.0])
    assert heights[:3] == pytest.approx([0.0, 0.0002, 0.0013], abs=1e-9)
    assert np.isnan(heights[3])
