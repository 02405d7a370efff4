"""Household shapes: possible upright axes and extents of each kind."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import TabletopOptions
from eyehand.data_synth.scenes.household_shapes import draw_base_shape, draw_shape, rest_rotation
from eyehand.perception.superquadric import Kind, Superquadric


def upright_axes(kind: Kind, semi_axes: tuple[float, float, float]) -> set[int]:
    """Return the local axes that are vertical in many random draws."""
    solid = Superquadric(np.array(semi_axes), (1.0, 1.0), RigidTransform.identity(), kind)
    rng = np.random.default_rng(0)
    rows = [rest_rotation(solid, rng).as_matrix()[2] for _ in range(60)]
    assert np.allclose(np.abs(rows).max(axis=1), 1.0)
    return {int(np.argmax(row)) for row in rows}


def test_box_stands_on_every_face_unless_slender():
    assert upright_axes("box", (0.04, 0.03, 0.05)) == {0, 1, 2}
    assert upright_axes("box", (0.02, 0.02, 0.08)) == {0, 1}


def test_cylinder_stands_or_lies():
    assert upright_axes("cylinder", (0.03, 0.03, 0.05)) == {0, 2}
    assert upright_axes("cylinder", (0.03, 0.03, 0.02)) == {2}
    assert upright_axes("cylinder", (0.02, 0.02, 0.1)) == {0}


def test_ellipsoid_lies_flat():
    assert upright_axes("ellipsoid", (0.05, 0.02, 0.04)) == {1}


@pytest.mark.parametrize("kind", ["sphere", "cylinder", "ellipsoid", "box", "superquadric"])
def test_extents_lie_in_their_ranges(kind: Kind):
    options, rng = TabletopOptions(), np.random.default_rng(1)
    for _ in range(50):
        solid = draw_shape(kind, options, rng)
        a1, a2, a3 = 2 * solid.semi_axes
        assert options.width_range[0] <= a2 <= a1 <= options.width_range[1]
        lowest = min(options.height_range[0], options.width_range[0])
        assert lowest <= a3 <= options.height_range[1]
        assert solid.kind == kind


def test_base_is_wider_than_high():
    options, rng = TabletopOptions(), np.random.default_rng(1)
    for _ in range(50):
        base = draw_base_shape(options, rng)
        assert base.kind in ("box", "cylinder")
        assert base.semi_axes[2] < base.semi_axes[1]
