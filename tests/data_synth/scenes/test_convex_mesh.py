"""The convex mesh of a superquadric: closed, oriented outwards, and close to the surface."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.scenes.convex_mesh import CHORD_TOLERANCE_M, convex_mesh
from eyehand.perception.superquadric import Superquadric

exponents = st.floats(0.1, 1.5)
lengths = st.floats(0.015, 0.12)


@settings(max_examples=15, deadline=None)
@given(a=st.tuples(lengths, lengths, lengths), e=st.tuples(exponents, exponents))
def test_mesh_is_closed_and_within_twice_chord_tolerance(
    a: tuple[float, float, float], e: tuple[float, float]
):
    solid = Superquadric(np.array(a), e, RigidTransform.identity())
    vertices, faces = convex_mesh(solid)
    corners = vertices[faces]
    weights = np.random.default_rng(0).dirichlet([1, 1, 1], 8)
    inside = np.einsum("kc,fcd->fkd", weights, corners).reshape(-1, 3)

    assert np.allclose(solid.radial_scale(vertices), 1.0, atol=1e-9)
    assert solid.radial_scale(inside).max() <= 1 + 1e-9
    assert np.abs(solid.distance(inside)).max() < 2.5 * CHORD_TOLERANCE_M
    # Each edge occurs once in each direction: the mesh is closed and consistently oriented.
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert {tuple(edge) for edge in edges} == {tuple(edge[::-1]) for edge in edges}
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(solid.volume, rel=0.02)


def test_smaller_tolerance_gives_more_faces():
    solid = Superquadric(np.array([0.05, 0.04, 0.03]), (0.7, 0.9), RigidTransform.identity())
    assert len(convex_mesh(solid, 2e-5)[1]) > 3 * len(convex_mesh(solid, 1e-4)[1])
