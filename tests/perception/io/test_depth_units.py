"""Tests of converting between integer depth units and metres."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception.io.depth_units import metres_from_units, millimetres_from_metres


def test_scale_of_tenth_millimetre() -> None:
    depth = metres_from_units(np.array([[0, 7820]], dtype=np.uint16), 0.1)
    assert depth.dtype == np.float32
    np.testing.assert_array_equal(depth, np.array([[0, 0.782]], dtype=np.float32))


@given(st.integers(10, 65535))
def test_every_millimetre_round_trips(millimetres: int) -> None:
    raw = np.array([[millimetres]], dtype=np.uint16)
    np.testing.assert_array_equal(millimetres_from_metres(metres_from_units(raw, 1.0)), raw)


def test_scale_in_metres_is_rejected() -> None:
    with pytest.raises(InputError, match=r"median depth is 0\.8 mm at 0\.001 mm per unit"):
        metres_from_units(np.full((2, 2), 800, dtype=np.uint16), 0.001)


def test_depth_beyond_16_bits_error_suggests_npz() -> None:
    with pytest.raises(InputError, match=r"depth reaches 70\.000 m.*write \.npz"):
        millimetres_from_metres(np.array([[70.0]], dtype=np.float32))


def test_readings_rounded_to_zero_are_rejected() -> None:
    with pytest.raises(InputError, match=r"1 readings are under 0\.5 mm"):
        millimetres_from_metres(np.array([[0.0, 0.0004, 0.5]], dtype=np.float32))
