"""The rim of an imprint: face boundaries, straight edges, corners and the end of a line."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtr

from eyehand.errors import InputError
from eyehand.tactile import TactileArray, TactileImage
from eyehand.tactile.rim import find_line_end, find_rim, fit_edge, fit_longest_edge, intersect_edges

PAD = TactileArray.flat()
SPREAD = 0.003
"""Standard deviation of the blur by foam and tactels, m."""


def half_plane(angle, offset):
    """Return the relative pressures of a face that ends at a line, blurred by the foam."""
    out = np.array([np.cos(angle), np.sin(angle)])
    return ndtr((offset - PAD.positions[:, :2] @ out) / SPREAD)


@given(st.floats(-np.pi, np.pi), st.floats(-0.02, 0.02), st.integers(0, 99))
def test_edge_position_is_accurate_to_tenth_of_tactel(angle, offset, seed):
    noise = np.random.default_rng(seed).normal(0.0, 8.0, 256)
    image = TactileImage(1000.0 * half_plane(angle, offset) + noise, PAD)
    edge = fit_longest_edge(find_rim(image))
    assert edge is not None
    assert edge.offset == pytest.approx(offset, abs=0.0005)
    assert edge.outward @ [np.cos(angle), np.sin(angle)] > np.cos(np.radians(1.5))
    assert edge.rms < 0.0005
    assert edge.span > 0.04


def test_edge_position_is_unbiased_on_tilted_pad():
    tilted = 1.0 + 7.0 * PAD.positions[:, 1]
    edge = fit_longest_edge(find_rim(TactileImage(1000.0 * tilted * half_plane(0.3, 0.01), PAD)))
    assert edge is not None
    assert edge.offset == pytest.approx(0.01, abs=0.0005)


@given(st.floats(-np.pi, np.pi), st.sampled_from([60.0, 72.0, 90.0]))
def test_intersection_of_edges_is_the_corner(angle, turn):
    other = angle + np.radians(turn)
    face = half_plane(angle, 0.008) * half_plane(other, 0.006)
    rim = find_rim(TactileImage(1000.0 * face, PAD))
    edges = [fit_edge(rim, np.array([np.cos(a), np.sin(a)])) for a in (angle, other)]
    one, two = edges
    assert one is not None
    assert two is not None
    true = np.linalg.solve(
        [[np.cos(angle), np.sin(angle)], [np.cos(other), np.sin(other)]], [0.008, 0.006]
    )
    assert intersect_edges(one, two) == pytest.approx(true, abs=0.0015)
    for edge in edges:
        assert edge is not None
        assert np.linalg.norm(edge.nearest) >= abs(edge.offset) - 1e-9


def test_nearest_point_of_edge_lies_on_measured_rim():
    face = half_plane(0.0, -0.01) + half_plane(np.pi / 2, -0.02)
    edge = fit_edge(find_rim(TactileImage(500.0 * np.minimum(face, 1.0), PAD)), np.array([1.0, 0]))
    assert edge is not None
    assert edge.nearest[0] == pytest.approx(-0.01, abs=0.001)
    assert edge.nearest[1] > -0.021, "the face continues below this point"


@given(st.floats(-np.pi, np.pi), st.floats(0.004, 0.02))
def test_find_line_end_returns_position_of_tip(angle, tip):
    along = np.array([np.cos(angle), np.sin(angle)])
    u, w = PAD.positions[:, :2] @ along, PAD.positions[:, :2] @ [-along[1], along[0]]
    pressures = 2000.0 * np.exp(-0.5 * (w / SPREAD) ** 2) * ndtr((tip - u) / SPREAD)
    assert find_line_end(TactileImage(pressures, PAD), along) == pytest.approx(tip, abs=0.001)


def test_uniform_image_has_no_rim():
    for pressures in (np.zeros(256), np.full(256, 1000.0), np.full(256, 20.0)):
        rim = find_rim(TactileImage(pressures, PAD))
        assert not len(rim.points)
        assert fit_longest_edge(rim) is None


def test_find_rim_rejects_array_without_flat_grid():
    fingertip = TactileArray.fingertip()
    with pytest.raises(InputError, match="flat"):
        find_rim(TactileImage(np.zeros(len(fingertip.positions)), fingertip))
