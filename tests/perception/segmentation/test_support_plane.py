"""Tests of support planes: tables, shelves and floors are distinguished."""

import numpy as np
import pytest
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES, Ball, Box, Plate, exact_image, solid_frame

from eyehand.perception import CameraIntrinsics, DepthFrame, SegmentationOptions
from eyehand.perception.segmentation import select_supports
from eyehand.perception.segmentation.frame_noise import noise_profile
from eyehand.perception.segmentation.support_plane import (
    find_supports,
)

OPTIONS = SegmentationOptions()
UP = TABLE_AXES[2]
TABLE = Plate((-0.4, 0.4), (0.2, 0.8))
SHELF = Plate((-0.4, 0.4), (0.9, 1.4), 0.3)


def support_heights(solids, plates, known_pose=False, **options):
    """Detect the supports of an exact frame; return their heights above the table, m."""
    frame, _ = solid_frame(solids, plates, known_pose=known_pose)
    detected = find_supports(exact_image(frame), SegmentationOptions(**options).scaled(320))
    for support in detected:
        assert support.plane.normal @ UP > 0.9999
        assert np.linalg.norm(support.plane.normal) == pytest.approx(1.0)
    return [CAMERA_HEIGHT - support.plane.offset for support in detected]


def test_infinite_table_is_detected():
    assert support_heights([Ball(0.0, 0.7, 0.05, 0.05)], (Plate(),)) == pytest.approx(
        [0.0], abs=1e-4
    )


def test_table_and_shelf_are_supports_nearer_first():
    assert support_heights([], (TABLE, SHELF)) == pytest.approx([0.0, 0.3], abs=1e-3)


def test_small_horizontal_plane_is_no_second_support(monkeypatch):
    box = Box(0.1, 0.55, (0.35, 0.3, 0.1))
    assert support_heights([box], (TABLE,)) == pytest.approx([0.0], abs=1e-3)
    monkeypatch.setattr(select_supports, "MIN_AREA", 0.03)
    assert support_heights([box], (TABLE,)) == pytest.approx([0.0, 0.1], abs=1e-3)


@pytest.mark.parametrize("height", [0.0, 0.3])
def test_table_height_selects_plane(height):
    detected = support_heights([], (TABLE, SHELF), known_pose=True, table_height=height + 0.02)
    assert detected == pytest.approx([height], abs=1e-3)


def test_table_height_without_plane_gives_no_support():
    assert support_heights([], (TABLE, SHELF), known_pose=True, table_height=0.15) == []


def test_floor_below_table_is_no_support():
    table = Plate((-0.3, 0.3), (0.2, 0.7))
    frame, _ = solid_frame([], (table, Plate(z=-0.7)))
    assert 0.2 < np.count_nonzero((frame.depth < 1.0) & frame.valid) / frame.depth.size < 0.45
    assert support_heights([], (table, Plate(z=-0.7))) == pytest.approx([0.0], abs=2e-3)


def test_plane_in_small_part_of_view_is_detected():
    plate = Plate((-0.2, 0.2), (0.45, 0.8))
    frame, _ = solid_frame([], (plate,))
    assert np.count_nonzero(frame.valid) < 0.3 * frame.depth.size
    assert support_heights([Box(0.0, 0.6, (0.1, 0.1, 0.1))], (plate,)) == pytest.approx(
        [0.0], abs=1e-3
    )


def test_parts_that_clutter_separates_belong_to_one_support():
    bar = Box(0.0, 0.6, (0.06, 0.9, 0.1))
    frame, _ = solid_frame([bar], (TABLE,))
    (detected,) = find_supports(exact_image(frame), OPTIONS.scaled(320))
    corners = (detected.hull @ detected.axes) @ TABLE_AXES.T
    assert np.ptp(corners[:, 0]) == pytest.approx(0.8, abs=0.02)


def test_wide_box_top_is_no_support():
    box = Box(0.0, 0.5, (0.36, 0.3, 0.1))
    assert support_heights([box], (TABLE,)) == pytest.approx([0.0], abs=1e-3)


def test_balls_in_air_give_no_support():
    assert support_heights([Ball(0.0, 0.6, 0.1, 0.1)], ()) == []
    assert support_heights([Ball(-0.1, 0.6, 0.1, 0.06), Ball(0.1, 0.8, 0.2, 0.08)], ()) == []


def test_gravity_rejects_wall():
    wall = [Box(0.0, 1.0, (5.0, 0.1, 5.0), base=-2.0)]
    frame, _ = solid_frame(wall, ())
    assert support_heights(wall, (), known_pose=True) == []
    (detected,) = find_supports(exact_image(frame), OPTIONS.scaled(320))
    assert detected.plane.normal @ TABLE_AXES[1] == pytest.approx(-1.0, abs=1e-4)


def test_hull_encloses_visible_table():
    frame, _ = solid_frame([], (Plate((-0.2, 0.2), (0.45, 0.8)),))
    (detected,) = find_supports(exact_image(frame), OPTIONS.scaled(320))
    origin = -detected.plane.offset * detected.plane.normal
    corners = (detected.hull @ detected.axes + origin) @ TABLE_AXES.T + [0.0, 0.0, CAMERA_HEIGHT]
    assert np.allclose(corners.min(axis=0), [-0.2, 0.45, 0.0], atol=0.006)
    assert np.allclose(corners.max(axis=0), [0.2, 0.8, 0.0], atol=0.006)
    assert detected.depth == pytest.approx(np.median(frame.depth[frame.valid]), rel=0.02)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (3, 2), (20, 15)])
def test_tiny_frames_raise_no_error(width, height):
    camera = CameraIntrinsics(width, width, width / 2, height / 2, width, height)
    frame, _ = solid_frame([], (Plate(),), camera)
    assert len(find_supports(exact_image(frame), OPTIONS.scaled(width))) <= 1


@pytest.mark.parametrize("seed", range(12))
def test_search_in_random_depth_terminates(seed):
    rng = np.random.default_rng(seed)
    height, width = rng.integers(1, 41, 2)
    depth = rng.uniform(0.3, 2.0, (height, width)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.3] = 0.0
    camera = CameraIntrinsics(50.0, 50.0, width / 2, height / 2, int(width), int(height))
    image = exact_image(DepthFrame(depth, camera))
    assert len(find_supports(image, SegmentationOptions())) <= 4


def bent_depth(rng, bend):
    """Return the noisy depth of a table, bent by `bend` in disparity at the sides, (240, 320)."""
    rows, columns = np.mgrid[:240, :320]
    bends = bend * (((columns - 160) / 160) ** 2 + ((rows - 120) / 120) ** 2)
    return 1.0 / (1.2 + 0.0015 * rows + bends) + rng.normal(0, 0.0005, rows.shape)


def first_support(depth):
    camera = CameraIntrinsics(270.0, 270.0, 159.5, 119.5, 320, 240)
    frame = DepthFrame(np.ascontiguousarray(depth, np.float32), camera)
    return find_supports(exact_image(frame)._replace(noise=1e-3), OPTIONS.scaled(320))[0]


@pytest.mark.parametrize("seed", range(4))
def test_few_changed_readings_hardly_move_the_plane_of_a_bent_table(seed):
    rng = np.random.default_rng(seed)
    depth = bent_depth(rng, 0.006)
    first = first_support(depth)
    corners = first.hull @ first.axes - first.plane.offset * first.plane.normal
    for _ in range(4):
        moved = depth + rng.choice([-0.001, 0.0, 0.001], depth.shape, p=[0.0025, 0.995, 0.0025])
        assert np.abs(first_support(moved).plane.height(corners)).max() < 0.0005


@pytest.mark.parametrize("seed", [1, 4, 5])
def test_mirrored_image_of_a_bent_table_gives_the_mirrored_plane(seed):
    depth = bent_depth(np.random.default_rng(seed), 0.012)
    first = first_support(depth)
    corners = first.hull @ first.axes - first.plane.offset * first.plane.normal
    mirrored = first_support(depth[:, ::-1]).plane
    assert np.abs(mirrored.height(corners * [-1.0, 1.0, 1.0])).max() < 0.0012


def test_small_table_above_large_floor_is_first_support():
    heights = support_heights([], (Plate((-0.15, 0.15), (0.45, 0.75)), Plate(z=-0.4)))
    assert heights[0] == pytest.approx(0.0, abs=0.002)


def test_boards_far_apart_are_supports_although_small():
    upper, lower = Plate((-0.3, 0.3), (0.8, 1.0), 0.15), Plate((-0.3, 0.3), (0.6, 0.8), -0.15)
    assert sorted(support_heights([], (upper, lower))) == pytest.approx([-0.15, 0.15], abs=0.002)


def test_noisy_near_table_is_proposed():
    top = Plate((-0.15, 0.15), (0.35, 0.65))
    frame, _ = solid_frame([], (top, Plate(z=-0.6)))
    near = frame.depth < 0.9
    noise = np.where(near, 0.015, 0.003) * np.random.default_rng(0).normal(size=frame.depth.shape)
    disparity = 1.0 / np.maximum(frame.depth, 1e-6) + noise
    depth = np.where(frame.valid, 1.0 / disparity, 0.0).astype(np.float32)
    image = exact_image(DepthFrame(depth, frame.intrinsics))
    sigma, profile = noise_profile(image.disparity, 9)
    image = image._replace(noise=sigma)
    (first, *_) = find_supports(image, OPTIONS.scaled(320), profile)
    assert CAMERA_HEIGHT - first.plane.offset == pytest.approx(0.0, abs=0.005)
    (uniform, *_) = find_supports(image, OPTIONS.scaled(320))
    assert CAMERA_HEIGHT - uniform.plane.offset == pytest.approx(-0.6, abs=0.005)
