"""Regions without readings: those in the middle of a table count, shadows and dropout do not."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from synthetic_solids import T_TABLE_CAMERA, Ball, Box, Plate, solid_frame

from eyehand.perception import CameraIntrinsics, DepthFrame, SegmentationOptions, perceive, segment
from eyehand.perception.segmentation.block_heights import block_heights
from eyehand.perception.segmentation.support_extent import Support
from eyehand.perception.segmentation.unknown_regions import find_unknown
from eyehand.perception.segmentation.working_image import working_image

CAMERA = CameraIntrinsics(520.0, 520.0, 319.5, 239.5, 640, 480)
PROJECTOR_BASELINE = 0.075
"""Distance between camera and projector of the simulated shadows, m."""


def frame_without(solids, transparent=(), seed=0, dropout=0.0, shadow=False):
    """Return a frame of solids, without readings on the transparent ones."""
    frame, labels = solid_frame([*solids, *transparent], (Plate(),), CAMERA, known_pose=True)
    depth = frame.depth.copy()
    glass = labels > len(solids)
    depth[glass] = 0.0
    if shadow:
        table, _ = solid_frame([], (Plate(),), CAMERA)
        width = CAMERA.fx * PROJECTOR_BASELINE * (1 / frame.depth - 1 / table.depth)
        for v, u in np.argwhere((labels > 0) & ~glass):
            for x in range(u, min(u + round(float(width[v, u])) + 1, 640)):
                if labels[v, x] == 0:
                    depth[v, x] = 0.0
    depth[np.random.default_rng(seed).random(depth.shape) < dropout] = 0.0
    return DepthFrame(depth, CAMERA, frame.T_world_camera), glass


@pytest.mark.parametrize("dropout", [0.0, 0.2])
def test_transparent_thing_is_a_bounded_region(dropout):
    glass = Box(0.05, 0.7, (0.07, 0.07, 0.09))
    box = Box(-0.2, 0.75, (0.1, 0.1, 0.08))
    frame, hidden = frame_without([box], [glass], dropout=dropout)
    found = segment(frame)
    (region,) = found.unknown
    rows, columns = np.nonzero(hidden)
    low, high = region.outline.min(axis=0), region.outline.max(axis=0)
    np.testing.assert_allclose(low, [columns.min(), rows.min()], atol=6)
    np.testing.assert_allclose(high, [columns.max(), rows.max()], atol=6)
    corners = T_TABLE_CAMERA.apply(region.corners)
    half = np.array([0.034, 0.034, 0.0])
    thing = [np.array([0.05, 0.7, z]) + half * s for z in (0.003, 0.087) for s in _SIGNS]
    hull = ConvexHull(corners).equations
    assert (np.array(thing) @ hull[:, :3].T + hull[:, 3]).max() < 0.004
    assert region.height < 0.3
    assert corners[:, 2].min() == pytest.approx(0.0, abs=0.003)


def test_shadows_and_dropout_are_no_regions():
    solids = [
        Box(-0.15, 0.7, (0.1, 0.1, 0.15)),
        Ball(0.15, 0.75, 0.05, 0.05),
        Box(0.0, 0.95, (0.06, 0.06, 0.25)),
    ]
    frame, _ = frame_without(solids, dropout=0.1, shadow=True)
    assert np.mean(frame.depth == 0) > 0.1
    assert segment(frame).unknown == ()


def test_scene_holds_the_region_in_the_world():
    frame, _ = frame_without([], [Box(0.0, 0.7, (0.08, 0.08, 0.1))])
    (region,) = perceive(frame).unknown
    half = len(region.outline)
    np.testing.assert_allclose(region.corners[:half, 2], 0.0, atol=0.003)
    np.testing.assert_allclose(region.corners[half:, 2], region.height, atol=0.003)


def test_missing_readings_at_the_border_are_no_region():
    frame, _ = frame_without([Box(0.1, 0.7, (0.1, 0.1, 0.08))])
    depth = frame.depth.copy()
    depth[:60], depth[:, :80] = 0.0, 0.0
    assert segment(DepthFrame(depth, CAMERA)).unknown == ()


def test_thing_before_another_is_a_region_though_the_far_half_shows_no_table():
    back = Box(0.0, 0.8, (0.3, 0.1, 0.3))
    frame, hidden = frame_without([back], [Box(0.0, 0.68, (0.06, 0.06, 0.15))])
    (region,) = segment(frame).unknown
    rows, columns = np.nonzero(hidden)
    np.testing.assert_allclose(region.outline.mean(axis=0), [columns.mean(), rows.mean()], atol=12)


def test_before_walls_the_whole_ring_must_show_the_support():
    back = Box(0.0, 0.8, (0.3, 0.1, 0.3))
    frame, _ = frame_without([back], [Box(0.0, 0.68, (0.06, 0.06, 0.15))])
    plane = segment(frame).support
    assert plane is not None
    axes = np.linalg.svd(plane.normal[None])[2][1:]
    hull = 3 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float32)
    image, support = working_image(frame), Support(plane, hull, axes, 0.7)
    tops = block_heights(image, plane)
    assert len(find_unknown(tops, image, support)) == 1
    assert find_unknown(tops, image, support, walls=True) == ()


@pytest.mark.parametrize("stride", [1, 2])
def test_masked_pixels_are_no_region(stride):
    frame, hidden = frame_without([], [Box(0.0, 0.7, (0.1, 0.1, 0.1))])
    assert segment(frame.without(hidden), SegmentationOptions(stride=stride)).unknown == ()


def test_mask_of_a_size_that_the_stride_does_not_divide():
    camera = CameraIntrinsics(260.0, 260.0, 160.0, 120.0, 321, 241)
    frame, _ = solid_frame([], camera=camera)
    mask = np.zeros(frame.depth.shape, bool)
    mask[100:130, 140:180] = True
    assert segment(frame.without(mask), SegmentationOptions(stride=16)).unknown == ()


def test_outline_is_in_pixels_of_the_frame():
    frame, _ = frame_without([], [Box(0.0, 0.7, (0.08, 0.08, 0.1))])
    (whole,) = segment(frame).unknown
    (coarse,) = segment(frame, SegmentationOptions(stride=2)).unknown
    np.testing.assert_allclose(coarse.outline.mean(axis=0), whole.outline.mean(axis=0), atol=8)


_SIGNS = [np.array([x, y, 0.0]) for x in (-1, 1) for y in (-1, 1)]
