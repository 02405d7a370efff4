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
def test_top_surface_has_zero_distance_and_distance_has_unit_gradient(part: Part) -> None:
    item = TouchObject("thing", (part,))
    x, y = np.random.default_rng(0).uniform(-0.06, 0.06, (2, 400))
    z = top_surface(item, x, y)
    visible = ~np.isnan(z)
    assert 10 < np.count_nonzero(visible) < 400
    on_surface = np.column_stack([x, y, z])[visible]
    assert np.abs(surface_distance(item, on_surface)).max() < 1e-9
    # A step along the negative gradient by the distance leads onto the surface.
    off_surface = on_surface + np.array([0.01, 0.005, 0.02])
    distance = surface_distance(item, off_surface)
    steps = 1e-6 * np.eye(3)
    gradient = np.column_stack(
        [
            (surface_distance(item, off_surface + s) - surface_distance(item, off_surface - s))
            / 2e-6
            for s in steps
        ]
    )
    assert np.linalg.norm(gradient, axis=1) == pytest.approx(1.0, abs=1e-3)
    projections = off_surface - distance[:, None] * gradient
    assert np.abs(surface_distance(item, projections)).max() < 1e-4


def test_distance_on_axes_of_ellipsoid_is_exact() -> None:
    item = TouchObject("egg", (Part("ellipsoid", (0.05, 0.03, 0.02)),))
    points = [[0, 0, 0], [0.06, 0, 0], [0, -0.04, 0], [0, 0, 0.01]]
    assert surface_distance(item, points) == pytest.approx([-0.02, 0.01, 0.01, -0.01], abs=1e-9)


def test_unknown_object_has_ridge_and_block_on_dome() -> None:
    heights = top_surface(unknown_object(), [0.0, -0.04, 0.045, 0.2], [0.0, 0.01, -0.012, 0.0])
    assert heights[:3] == pytest.approx([0.0, 0.0002, 0.0013], abs=1e-9)
    assert np.isnan(heights[3])
