"""Supports: the compiled vote equals NumPy's, and tables, shelves and floors are told apart."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solids import EYE, TABLE_AXES, Ball, Box, Plate, exact_image, solid_frame

from eyehand.perception import CameraIntrinsics, DepthFrame, SegmentationOptions
from eyehand.perception.segmentation import support_plane
from eyehand.perception.segmentation.support_plane import (
    MIN_COSINE,
    PlaneSamples,
    find_supports,
    plane_inliers,
    plane_scores,
)

OPTIONS = SegmentationOptions()
UP = TABLE_AXES[2]
TABLE = Plate((-0.4, 0.4), (0.2, 0.8))
SHELF = Plate((-0.4, 0.4), (0.9, 1.4), 0.3)


def supports(solids, plates, known_place=False, **options):
    """Supports of an exact frame, as heights over the table plane."""
    frame, _ = solid_frame(solids, plates, known_place=known_place)
    found = find_supports(exact_image(frame), SegmentationOptions(**options).scaled(320))
    for support in found:
        assert support.plane.normal @ UP > 0.9999
        assert np.linalg.norm(support.plane.normal) == pytest.approx(1.0)
    return [EYE - support.plane.offset for support in found]


def random_vote(seed):
    """Candidates and samples of a few planes, with some outliers and weights of zero."""
    rng = np.random.default_rng(seed)
    count = 80
    rays = np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)), np.ones(count)])
    planes = rng.normal(size=(6, 3)) * 0.1 - [0.0, 0.0, 1.0]
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    offsets = rng.uniform(0.5, 1.5, 6)
    mine = rng.integers(0, 6, count)
    q = -np.einsum("ij,ij->i", planes[mine], rays) / offsets[mine] + 0.02 * rng.normal(size=count)
    normals = planes[mine] + 0.2 * rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    weights = rng.random(count) * (rng.random(count) < 0.8)
    return planes, offsets, q, rays, normals, weights


@given(seed=st.integers(0, 10_000), tolerance=st.floats(0.005, 0.1))
@settings(max_examples=20)
def test_votes_equal_numpys(seed, tolerance):
    planes, offsets, q, rays, normals, weights = random_vote(seed)
    samples = PlaneSamples(q, rays, normals, weights)
    expected = np.abs(rays @ planes.T / offsets + q[:, None]) < tolerance
    expected &= (normals @ planes.T > MIN_COSINE) & (weights[:, None] > 0)
    for k, plane in enumerate(planes):
        assert np.array_equal(plane_inliers(plane, offsets[k], samples, tolerance), expected[:, k])
    scores = plane_scores(planes, offsets, samples, tolerance)
    assert np.allclose(scores, weights @ expected)


def test_an_endless_table_is_found_to_the_millimetre():
    assert supports([Ball(0.0, 0.7, 0.05, 0.05)], (Plate(),)) == pytest.approx([0.0], abs=1e-4)


def test_table_and_shelf_are_both_supports_the_nearer_first():
    assert supports([], (TABLE, SHELF)) == pytest.approx([0.0, 0.3], abs=1e-3)


def test_a_level_plane_that_could_be_a_face_is_no_further_support(monkeypatch):
    box = Box(0.1, 0.55, (0.35, 0.3, 0.1))
    assert supports([box], (TABLE,)) == pytest.approx([0.0], abs=1e-3)
    monkeypatch.setattr(support_plane, "MIN_AREA", 0.03)
    assert supports([box], (TABLE,)) == pytest.approx([0.0, 0.1], abs=1e-3)


@pytest.mark.parametrize("height", [0.0, 0.3])
def test_a_known_height_picks_its_plane(height):
    found = supports([], (TABLE, SHELF), known_place=True, table_height=height + 0.02)
    assert found == pytest.approx([height], abs=1e-3)


def test_at_a_known_height_where_nothing_is_there_is_no_support():
    assert supports([], (TABLE, SHELF), known_place=True, table_height=0.15) == []


def test_a_table_wins_over_a_floor_that_fills_more_of_the_view():
    table = Plate((-0.3, 0.3), (0.2, 0.7))
    frame, _ = solid_frame([], (table, Plate(z=-0.7)))
    assert 0.2 < np.count_nonzero((frame.depth < 1.0) & frame.valid) / frame.depth.size < 0.45
    assert supports([], (table, Plate(z=-0.7))) == pytest.approx([0.0, -0.7], abs=2e-3)


def test_a_plane_that_fills_a_small_part_of_the_view_is_found():
    plate = Plate((-0.2, 0.2), (0.45, 0.8))
    frame, _ = solid_frame([], (plate,))
    assert np.count_nonzero(frame.valid) < 0.3 * frame.depth.size
    assert supports([Box(0.0, 0.6, (0.1, 0.1, 0.1))], (plate,)) == pytest.approx([0.0], abs=1e-3)


def test_round_things_in_the_air_stand_on_nothing():
    assert supports([Ball(0.0, 0.6, 0.1, 0.1)], ()) == []
    assert supports([Ball(-0.1, 0.6, 0.1, 0.06), Ball(0.1, 0.8, 0.2, 0.08)], ()) == []


def test_gravity_leaves_no_wall():
    wall = [Box(0.0, 1.0, (5.0, 0.1, 5.0), base=-2.0)]
    frame, _ = solid_frame(wall, ())
    assert supports(wall, (), known_place=True) == []
    (found,) = find_supports(exact_image(frame), OPTIONS.scaled(320))
    assert found.plane.normal @ TABLE_AXES[1] == pytest.approx(-1.0, abs=1e-4)


def test_the_hull_is_what_was_seen_of_the_table():
    frame, _ = solid_frame([], (Plate((-0.2, 0.2), (0.45, 0.8)),))
    (found,) = find_supports(exact_image(frame), OPTIONS.scaled(320))
    foot = -found.plane.offset * found.plane.normal
    corners = (found.hull @ found.axes + foot) @ TABLE_AXES.T + [0.0, 0.0, EYE]
    assert np.allclose(corners.min(axis=0), [-0.2, 0.45, 0.0], atol=0.006)
    assert np.allclose(corners.max(axis=0), [0.2, 0.8, 0.0], atol=0.006)
    assert found.depth == pytest.approx(np.median(frame.depth[frame.valid]), rel=0.02)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (3, 2), (20, 15)])
def test_tiny_frames_have_a_plane_or_none_but_no_error(width, height):
    camera = CameraIntrinsics(width, width, width / 2, height / 2, width, height)
    frame, _ = solid_frame([], (Plate(),), camera)
    assert len(find_supports(exact_image(frame), OPTIONS.scaled(width))) <= 1


@pytest.mark.parametrize("seed", range(12))
def test_random_depth_ends_the_search(seed):
    rng = np.random.default_rng(seed)
    height, width = rng.integers(1, 41, 2)
    depth = rng.uniform(0.3, 2.0, (height, width)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.3] = 0.0
    camera = CameraIntrinsics(50.0, 50.0, width / 2, height / 2, int(width), int(height))
    image = exact_image(DepthFrame(depth, camera))
    assert len(find_supports(image, SegmentationOptions())) <= 4
