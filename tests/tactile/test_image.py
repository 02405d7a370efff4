"""Tactile arrays: flat pads, curved patches and fingertips."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.tactile import TactileArray
from eyehand.tactile.image import tangents

ARRAYS = {
    "flat": TactileArray.flat(),
    "curved": TactileArray.curved(),
    "fingertip": TactileArray.fingertip(),
}


@pytest.mark.parametrize("array", ARRAYS.values(), ids=ARRAYS)
def test_normals_have_unit_length_and_top_is_at_origin(array):
    assert np.allclose(np.linalg.norm(array.normals, axis=1), 1.0)
    assert array.positions[:, 2].max() == pytest.approx(0.0, abs=1e-3)
    assert array.areas.mean() == pytest.approx(array.area)


def test_curved_pad_lies_on_cylinder():
    array = TactileArray.curved(rows=9, columns=4, pitch=0.004, radius=0.03)
    from_axis = array.positions + np.array([0.0, 0.0, 0.03])
    assert np.allclose(np.hypot(from_axis[:, 1], from_axis[:, 2]), 0.03)
    assert np.allclose(from_axis[:, 1:] / 0.03, array.normals[:, 1:])
    steps = np.diff(np.arctan2(from_axis[::4, 1], from_axis[::4, 2])) * 0.03
    assert np.allclose(steps, 0.004)


def test_curved_pad_of_large_radius_equals_flat_pad():
    flat, curved = TactileArray.flat(), TactileArray.curved(radius=1e4)
    assert np.allclose(curved.positions, flat.positions, atol=1e-6)
    assert np.array_equal(curved.neighbours, flat.neighbours)


def test_fingertip_has_12_tactels_on_cylinder_with_spherical_end():
    tip = ARRAYS["fingertip"]
    assert len(tip.positions) == 12
    inside = tip.positions - 0.008 * tip.normals
    assert np.allclose(inside[:, [0, 2]], [0.0, -0.008])
    assert tip.normals[9:, 1].min() > 0.5
    assert np.allclose(tip.normals[:9, 1], 0.0)
    assert len(np.unique(tip.areas.round(12))) == 2


def test_border_is_outer_ring_of_tactels():
    ring = np.ones((16, 16), bool)
    ring[1:-1, 1:-1] = False
    assert np.array_equal(ARRAYS["flat"].border, ring.ravel())
    assert np.array_equal(ARRAYS["curved"].border, ring.ravel())
    assert not ARRAYS["fingertip"].border[4]
    assert ARRAYS["fingertip"].border[[0, 1, 2, 9, 10, 11]].all()


@given(
    st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda n: np.hypot(n[0], n[1]) > 1e-3)
)
def test_tangents_and_normal_form_right_handed_frame(normal):
    normal = np.array(normal) / np.linalg.norm(normal)
    x, y = tangents(normal)
    assert np.allclose(np.linalg.norm([x, y], axis=1), 1.0)
    assert np.allclose(np.cross(x, y), normal)


def test_tangents_of_z_normal_are_x_and_y():
    assert np.array_equal(tangents(np.array([0.0, 0.0, 1.0])), np.eye(3)[:2])
    assert np.array_equal(tangents(np.array([0.0, 0.0, -1.0])), [[1, 0, 0], [0, -1, 0]])


def flat_array_with(**fields) -> TactileArray:
    defaults = {name: getattr(ARRAYS["flat"], name) for name in ("positions", "normals", "area")}
    return TactileArray(**{**defaults, "neighbours": ARRAYS["flat"].neighbours, **fields})


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"normals": np.zeros((256, 3))}, "unit"),
        ({"positions": np.full((256, 3), np.nan)}, "finite"),
        ({"area": 0.0}, "area"),
        ({"area": 4.7**2}, "pitch and positions must be in m"),
        ({"positions": 1000 * ARRAYS["flat"].positions}, "within 1 m"),
        ({"areas": np.ones(3)}, "areas"),
        ({"areas": np.full(256, 0.002)}, "mean"),
        ({"neighbours": np.array([[0, 256]])}, "different tactels"),
        ({"grid": (3, 4)}, "grid"),
    ],
)
def test_array_rejects_invalid_fields(fields, message):
    with pytest.raises(InputError, match=message):
        flat_array_with(**fields)


def test_curved_pad_rejects_more_than_half_a_cylinder():
    with pytest.raises(InputError, match="half a cylinder"):
        TactileArray.curved(radius=0.02)


def test_description_is_printed_in_a_line():
    assert repr(TactileArray.flat(2, 3)) == "TactileArray(area=2.5e-05, grid=(2, 3))"
