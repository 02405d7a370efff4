"""Furniture against exact geometry, seen from straight above by rays."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.scenes import furniture
from eyehand.data_synth.scenes.fixture import Fixture
from eyehand.data_synth.scenes.furnished_scene import furnished_spec

GREY = (0.5, 0.5, 0.5)


def heights(parts: list[Fixture], points: np.ndarray) -> np.ndarray:
    """Return the world z of the first surface below (x, y), (N,); NaN where there is none."""
    mujoco = import_mujoco()
    model = furnished_spec((), tuple(parts), free=False).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = []
    hit = np.zeros(1, np.int32)
    for x, y in points:
        start, down = np.array([x, y, 2.0]), np.array([0.0, 0.0, -1.0])
        away = mujoco.mj_ray(model, data, start, down, None, 1, -1, hit, None)
        found.append(2.0 - away if away >= 0 else np.nan)
    return np.array(found)


@pytest.mark.parametrize("degrees", [0.0, 8.0])
def test_container_has_floor_wall_and_lip(degrees: float):
    taper = np.radians(degrees)
    parts = furniture.container((0.4, 0.3), 0.2, GREY, taper=taper, thickness=0.004, lip=0.02)
    half = 0.2 + 0.2 * np.tan(taper)
    points = [[0, 0], [0.199, 0.149], [half + 0.002, 0], [half + 0.019, 0.1], [half + 0.021, 0]]
    found = heights(parts, np.array(points))
    assert np.allclose(found[:4], [0.004, 0.004, 0.204, 0.204], atol=1e-4)
    assert np.isnan(found[4])
    if degrees:
        # Half of the way up, a leaning wall lies half of the way out.
        middle = heights(parts, np.array([[(0.2 + half) / 2, 0.0]]))
        assert middle == pytest.approx(0.104, abs=1e-4)


def test_container_has_no_gap_at_its_corners():
    parts = furniture.container((0.4, 0.3), 0.1, GREY, thickness=0.005, lip=0.01)
    around = np.array([[sx * 0.2 + sx * d, sy * 0.15 + sy * d] for sx in (-1, 1) for sy in (-1, 1)
                       for d in (0.002, 0.008)])  # fmt: skip
    assert np.allclose(heights(parts, around), 0.105, atol=1e-4)


def test_shelf_opens_towards_negative_y():
    parts = furniture.shelf((0.8, 0.3), (0.0, 0.3), 0.6, GREY)
    found = heights(parts, np.array([[0, 0], [0, 0.16], [0.41, 0], [0, -0.16]]))
    assert np.allclose(found[:3], [0.3, 0.6, 0.6], atol=1e-6)
    assert np.isnan(found[3])


def test_tables_have_their_top_at_zero():
    points = np.array([[0, 0], [0.14, 0.09], [0.16, 0.0]])
    square = heights(furniture.table((0.3, 0.2), 0.7, GREY), points)
    disc = heights(furniture.pedestal((0.3, 0.3), 0.5, GREY, turned=True), points)
    assert np.allclose(square[:2], 0.0)
    assert np.isnan(square[2])
    assert disc[0] == pytest.approx(0.0)
    assert np.isnan(disc[1:]).all()
