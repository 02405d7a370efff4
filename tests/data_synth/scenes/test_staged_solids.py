"""Meshes of staged solids: closed, oriented outwards, and with the exact volume."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.data_synth.scenes.staged_mesh import tapered_mesh, tube_mesh, turned_mesh
from eyehand.data_synth.scenes.staged_solids import (
    Turned,
    ball,
    bowl,
    box,
    cone,
    cup,
    mug,
    rod,
    superquadric,
    tapered_box,
)
from eyehand.errors import InputError

lengths = st.floats(0.01, 0.2)


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the volume of a closed mesh with faces counter-clockwise from outside, m³."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def assert_closed(faces: np.ndarray):
    """Assert that each edge occurs once in each direction."""
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    forward, backward = edges @ [faces.max() + 1, 1], edges[:, ::-1] @ [faces.max() + 1, 1]
    assert len(np.unique(forward)) == len(forward)
    assert np.array_equal(np.sort(forward), np.sort(backward))


@settings(max_examples=20)
@given(bottom=st.tuples(lengths, lengths), top=st.tuples(lengths, lengths), height=lengths)
def test_tapered_box_has_volume_of_prismatoid(bottom, top, height):
    vertices, faces = tapered_mesh(bottom, top, height)
    assert_closed(faces)
    middle = np.add(bottom, top) / 2
    expected = height / 6 * (np.prod(bottom) + 4 * np.prod(middle) + np.prod(top))
    assert volume(vertices, faces) == pytest.approx(expected, rel=1e-9)


@settings(max_examples=20)
@given(low=lengths, high=lengths, height=lengths)
def test_frustum_has_volume_of_truncated_cone(low, high, height):
    vertices, faces = turned_mesh([(low, 0.0), (high, height)])
    assert_closed(faces)
    expected = np.pi * height / 3 * (low**2 + low * high + high**2)
    assert volume(vertices, faces) == pytest.approx(expected, rel=1e-3)


def test_bent_tube_has_volume_of_length_times_section():
    turn = np.linspace(-np.pi / 2, np.pi / 2, 200)
    path = np.column_stack([0.05 * np.cos(turn), 0.05 * np.sin(turn)])
    vertices, faces = tube_mesh(path, 0.006)
    assert_closed(faces)
    # Pappus's theorem: the area of the section times the path of its centre.
    assert volume(vertices, faces) == pytest.approx(np.pi * 0.006**2 * np.pi * 0.05, rel=0.01)


def test_bowl_has_wall_thickness_and_is_open():
    (part,) = bowl(0.07, 0.05, wall=0.004).parts
    assert isinstance(part, Turned)
    vertices, faces = part.mesh()
    assert_closed(faces)
    filled = 2 / 3 * np.pi * 0.07**2 * 0.05
    hollow = 2 / 3 * np.pi * 0.066**2 * 0.046
    # The flat foot adds a small volume to half an ellipsoid.
    assert filled - hollow < volume(vertices, faces) < 1.15 * (filled - hollow)
    on_axis = vertices[np.hypot(vertices[:, 0], vertices[:, 1]) < 1e-9, 2]
    assert sorted(on_axis) == pytest.approx([0.0, 0.004])


def test_cup_has_volume_of_outside_minus_inside():
    (part,) = cup(0.03, 0.04, 0.1, wall=0.003).parts
    assert isinstance(part, Turned)
    outside = np.pi * 0.1 / 3 * (0.03**2 + 0.03 * 0.04 + 0.04**2)
    inside = np.pi * 0.097 / 3 * (0.027**2 + 0.027 * 0.037 + 0.037**2)
    assert volume(*part.mesh()) == pytest.approx(outside - inside, rel=2e-3)


def test_handle_of_mug_ends_in_wall():
    vessel, handle = mug(0.04, 0.1, wall=0.004).parts
    assert isinstance(vessel, Turned)
    assert not isinstance(handle, type(vessel))
    vertices = handle.mesh()[0]  # pyright: ignore[reportAttributeAccessIssue] # no ball
    across = np.hypot(vertices[:, 0], vertices[:, 1])
    assert across.min() > 0.036
    assert across.max() > 0.06
    assert 0 < vertices[:, 2].min() < vertices[:, 2].max() < 0.1


@pytest.mark.parametrize(
    ("solid", "height"),
    [
        (box(0.1, 0.2, 0.3), 0.3),
        (tapered_box((0.1, 0.1), (0.05, 0.05), 0.07), 0.07),
        (cone(0.05, 0.01, 0.08), 0.08),
        (rod(0.006, 0.15), 0.012),
        (superquadric((0.06, 0.05, 0.07), (0.5, 0.8)), 0.07),
        (mug(0.04, 0.09), 0.09),
    ],
)
def test_solids_extend_from_zero_to_their_height(solid, height):
    z = np.concatenate([part.mesh()[0][:, 2] for part in solid.parts])
    assert z.min() == pytest.approx(0.0, abs=1e-9)
    assert z.max() == pytest.approx(height, abs=1e-9)
    assert solid.height == height


def test_equal_solids_are_equal_and_hashable():
    assert bowl(0.07, 0.05) == bowl(0.07, 0.05)
    assert len({mug(0.04, 0.09), mug(0.04, 0.09), ball(0.03)}) == 2


@pytest.mark.parametrize(
    "make",
    [
        lambda: box(0.1, 0.0, 0.1),
        lambda: ball(float("nan")),
        lambda: cone(0.05, -0.01, 0.08),
        lambda: bowl(0.07, 0.05, wall=0.05),
        lambda: cup(0.03, 0.04, 0.1, wall=0.03),
        lambda: mug(0.04, 0.1, handle_radius=0.0),
        lambda: rod(0.01, float("inf")),
    ],
)
def test_solids_reject_invalid_sizes(make):
    with pytest.raises(InputError):
        make()
