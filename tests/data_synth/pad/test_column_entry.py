"""The entry of a column along the pad's normal into a solid, against inside-outside tests."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from eyehand.data_synth.pad.column_entry import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    NO_ENTRY,
    SPHERE,
    column_entry,
)
from eyehand.data_synth.pad.contact_window import HIGH_U, HIGH_V, LOW_U, LOW_V, sunken_window

KINDS = (SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX)
HALF = 0.04
"""Half the width of the pad, m."""

kinds = st.sampled_from(KINDS)
sizes = st.tuples(*[st.floats(0.002, 0.05)] * 3).map(np.array)
seeds = st.integers(0, 10**6)


def inside(kind: int, size: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return a mask of the points (..., 3) in the solid's frame that lie inside it."""
    x, y, z = np.moveaxis(points, -1, 0)
    if kind == SPHERE:
        return x**2 + y**2 + z**2 <= size[0] ** 2
    if kind == ELLIPSOID:
        return ((points / size) ** 2).sum(axis=-1) <= 1
    if kind == CYLINDER:
        return (x**2 + y**2 <= size[0] ** 2) & (np.abs(z) <= size[1])
    if kind == CAPSULE:
        beyond = z - np.clip(z, -size[1], size[1])
        return x**2 + y**2 + beyond**2 <= size[0] ** 2
    return np.asarray((np.abs(points) <= size).all(axis=-1))


@given(kind=kinds, size=sizes, seed=seeds)
def test_column_entry_separates_outside_from_inside(kind: int, size: np.ndarray, seed: int) -> None:
    rng = np.random.default_rng(seed)
    direction = Rotation.random(rng=rng).apply([0.0, 0.0, 1.0])
    point = rng.uniform(-1, 1, 3) * size
    entry = column_entry(kind, tuple(size), tuple(point), tuple(direction))
    along = np.linspace(-0.3, 0.3, 4001)
    within = inside(kind, size, point + along[:, None] * direction)
    if entry == NO_ENTRY:
        assert not within.any()
        return
    assert not within[along < entry - 1e-9].any()
    leave = -column_entry(kind, tuple(size), tuple(point), tuple(-direction))
    assert within[(along > entry + 1e-9) & (along < leave - 1e-9)].all()
    assert not within[along > leave + 1e-9].any()


@pytest.mark.parametrize("kind", KINDS)
def test_column_entry_along_axis_is_end_of_solid(kind: int) -> None:
    end = {SPHERE: 0.01, CAPSULE: 0.03, ELLIPSOID: 0.03, CYLINDER: 0.02, BOX: 0.03}[kind]
    size = (0.01, 0.02, 0.03)
    up = (0.0, 0.0, 1.0)
    assert column_entry(kind, size, (0.0, 0.0, 0.5), up) == pytest.approx(-0.5 - end)
    assert column_entry(kind, size, (0.1, 0.0, 0.0), up) == NO_ENTRY


@given(kind=kinds, size=sizes, seed=seeds)
def test_window_contains_all_points_below_pad(kind: int, size: np.ndarray, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(rng=rng).as_matrix()
    position = rng.uniform(-0.03, 0.03, 3)
    window = np.empty(6)
    found = sunken_window(kind, size, rotation, position, HALF, HALF, window)
    x, y, z = np.meshgrid(*[np.linspace(-HALF, HALF, 41)] * 2, np.linspace(-0.15, -1e-6, 61))
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    points = points[inside(kind, size, (points - position) @ rotation)]
    if not found:
        assert len(points) == 0
        return
    u = points[:, :2] @ window[:2]
    v = points[:, :2] @ np.array([-window[1], window[0]])
    assert (u >= window[LOW_U] - 1e-9).all()
    assert (u <= window[HIGH_U] + 1e-9).all()
    assert (v >= window[LOW_V] - 1e-9).all()
    assert (v <= window[HIGH_V] + 1e-9).all()


def test_window_of_flat_box_is_its_face() -> None:
    window = np.empty(6)
    size, position = np.array([0.02, 0.01, 0.005]), np.array([0.003, 0.001, 0.004])
    rotation = Rotation.from_euler("z", 0.5).as_matrix()
    assert sunken_window(BOX, size, rotation, position, HALF, HALF, window)
    assert window[HIGH_U] - window[LOW_U] == pytest.approx(0.04)
    assert window[HIGH_V] - window[LOW_V] == pytest.approx(0.02)
