"""Extents of geoms against many points on their surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell.geom_extent import extent

ROUNDING = 1e-9
ANGLE = st.floats(-3.0, 3.0)
SURFACES = {
    "sphere": lambda u, z: 0.03 * u,
    "ellipsoid": lambda u, z: np.array([0.03, 0.05, 0.02]) * u,
    "box": lambda u, z: np.array([0.03, 0.05, 0.02]) * np.sign(u),
    "capsule": lambda u, z: 0.03 * u + [0, 0, 1] * (0.05 * z),
    "cylinder": lambda u, z: (
        0.03 * u / np.linalg.norm(u[:, :2], axis=1, keepdims=True) * [1, 1, 0] + [0, 0, 0.05] * z
    ),
}


@pytest.mark.parametrize("kind", SURFACES)
@settings(max_examples=15, deadline=None)
@given(turn=st.tuples(ANGLE, ANGLE, ANGLE), seed=st.integers(0, 99))
def test_extent_bounds_surface_points_tightly(kind, turn, seed):
    mujoco = import_mujoco()
    size = {"sphere": "0.03", "capsule": "0.03 0.05", "cylinder": "0.03 0.05"}
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><worldbody><geom type="{kind}" pos="0.1 0.2 0.3" '
        f'size="{size.get(kind, "0.03 0.05 0.02")}" euler="{turn[0]} {turn[1]} {turn[2]}"/>'
        "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    rng = np.random.default_rng(seed)
    axis, unit_vectors = rng.normal(size=3), rng.normal(size=(8000, 3))
    axis /= np.linalg.norm(axis)
    unit_vectors /= np.linalg.norm(unit_vectors, axis=1, keepdims=True)
    ends = rng.choice([-1.0, 1.0], size=(len(unit_vectors), 1))
    points = SURFACES[kind](unit_vectors, ends) @ data.geom_xmat[0].reshape(3, 3).T + [
        0.1,
        0.2,
        0.3,
    ]

    low, high = extent(model, data, [0], axis)

    assert low - ROUNDING <= (points @ axis).min() <= low + 5e-4
    assert high - 5e-4 <= (points @ axis).max() <= high + ROUNDING


def test_extent_of_mesh_and_of_no_geoms():
    mujoco = import_mujoco()
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><asset><mesh name="m" vertex="0 0 0  0.1 0 0  0 0.2 0  0 0 0.3"/></asset>'
        '<worldbody><geom type="mesh" mesh="m"/></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)

    np.testing.assert_allclose(extent(model, data, [0], np.array([0, 0, 1.0])), [0, 0.3], atol=1e-6)
    assert extent(model, data, [], np.array([0, 0, 1.0])) == (np.inf, -np.inf)
