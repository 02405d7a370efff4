"""Trays: slots on the floor, distance, and obstacles of the walls."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.grasping.tray import Tray

TRAY = Tray(np.array([0.4, -0.1, 0.01]), (0.2, 0.3), 0.06)


@given(st.integers(0, 50))
def test_every_slot_lies_on_floor(number):
    position = TRAY.slot_position(number)
    assert TRAY.contains(position)
    assert position[2] == TRAY.centre[2]


def test_slots_differ_until_tray_is_full():
    positions = np.array([TRAY.slot_position(k) for k in range(6)])
    apart = np.linalg.norm(positions[:, None] - positions[None], axis=2)[np.triu_indices(6, 1)]
    assert apart.min() == pytest.approx(0.1)
    np.testing.assert_allclose(positions.mean(axis=0), TRAY.centre)
    np.testing.assert_allclose(TRAY.slot_position(6), TRAY.slot_position(0))


def test_distance_is_horizontal_from_edge_of_floor():
    assert TRAY.distance(np.array([0.45, -0.2, 0.5])) == 0.0
    assert TRAY.distance(np.array([0.53, -0.1, 0.0])) == pytest.approx(0.03)
    assert TRAY.distance(np.array([0.53, 0.09, 0.0])) == pytest.approx(0.05)


def test_walls_surround_floor():
    parts = {part.name: part for part in TRAY.obstacles()}
    assert len(parts) == 5
    assert parts["tray +x"].pose.translation[0] == pytest.approx(0.4 + 0.1 + 0.003)
    assert parts["tray floor"].pose.translation[2] == pytest.approx(0.01 - 0.003)


@pytest.mark.parametrize("wrong", [{"size": (0.0, 0.3)}, {"wall_height": -1.0}, {"slots": (0, 2)}])
def test_invalid_trays_are_rejected(wrong):
    given = {"centre": np.zeros(3), "size": (0.2, 0.3), "wall_height": 0.05} | wrong
    with pytest.raises(InputError):
        Tray(**given)
