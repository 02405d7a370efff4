"""Tests of the visible parts of a plane: the kernel equals NumPy; parts are added by evidence."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES, Box, Plate, exact_image, solid_frame

from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.support_extent import (
    BELOW_BANDS,
    BELOW_MIN,
    MIN_DEPTH,
    MIN_SLANT,
    locate_support,
    row_ends,
    weigh_readings,
)

PLANE = SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT, 0.0005)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=15)
def test_readings_are_weighed_as_in_numpy(seed):
    rng = np.random.default_rng(seed)
    rows, columns, offset, spread, angle = 12, 15, 0.6, (0.004, 0.003), 1e-5
    slope_u = rng.uniform(-0.3, 0.3, columns).astype(np.float32)
    slope_v = rng.uniform(-1.0, 0.1, rows).astype(np.float32)
    slope = slope_u.astype(float) + slope_v.astype(float)[:, None]
    hit = np.where(slope < -1e-3, -offset / np.minimum(slope, -1e-3), 1.0)
    depth = (hit * rng.choice([0.0, 0.9, 0.999, 1.0, 1.1], hit.shape)).astype(np.float32)
    z = depth.astype(float)
    seen = (z > 0) & (slope <= -1e-3)
    height, band = z * slope + offset, np.maximum(spread[0] * z**2, spread[1] * z)
    on = seen & (np.abs(height) < band)
    below = seen & ~on & (height < -np.maximum(BELOW_BANDS * band, BELOW_MIN))
    value = angle / np.maximum(hit, MIN_DEPTH) ** 2
    expected = on, value * below, value * on, angle * hit**2 / np.maximum(-slope, MIN_SLANT) * on
    found = weigh_readings(depth, (slope_u, slope_v), offset, spread, angle)
    for one, other in zip(found, expected, strict=True):
        assert np.allclose(one, other, rtol=1e-5)


def test_row_ends_equal_numpy():
    rng = np.random.default_rng(0)
    labels = rng.integers(0, 9, (12, 15)).astype(np.int32)
    rows = [np.flatnonzero(labels[v, 3:11] == 5) + 3 for v in range(2, 10)]
    expected = [(u, v) for v, row in enumerate(rows, 2) if len(row) for u in (row[0], row[-1])]
    assert np.array_equal(row_ends(labels, 5, np.array([2, 3, 10, 11], np.int32)), expected)


def test_area_of_a_plate_is_measured():
    frame, _ = solid_frame([], (Plate((-0.2, 0.2), (0.5, 0.8)),))
    found = locate_support(PLANE, 0.8, exact_image(frame))
    assert found is not None
    assert found.area == pytest.approx(0.12, rel=0.05)


def test_part_behind_a_gap_with_readings_below_is_left_out():
    near, far, floor = Plate((-0.3, 0.3), (0.3, 0.7)), Plate((0.2, 0.3), (1.3, 1.4)), Plate(z=-0.5)
    frame, _ = solid_frame([], (near, far, floor))
    found = locate_support(PLANE, 0.8, exact_image(frame))
    assert found is not None
    assert found.area == pytest.approx(0.24, rel=0.1)
    assert np.ptp(found.hull, axis=0).max() < 0.65
    assert found.score > 0


def test_top_of_two_boxes_scores_less_than_the_table_between():
    boxes = [Box(-0.12, 0.6, (0.1, 0.2, 0.1)), Box(0.12, 0.6, (0.1, 0.2, 0.1))]
    frame, _ = solid_frame(boxes, (Plate(),))
    image = exact_image(frame)
    table = locate_support(PLANE, 0.8, image)
    top = SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT - 0.1, 0.0005)
    tops = locate_support(top, 0.7, image)
    assert table is not None
    assert tops is not None
    assert tops.score < table.score


def test_plane_out_of_view_has_no_parts():
    frame, _ = solid_frame([], (Plate(),))
    away = SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT + 1.0, 0.0005)
    assert locate_support(away, 0.8, exact_image(frame)) is None
