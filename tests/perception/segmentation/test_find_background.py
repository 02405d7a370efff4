"""The support alone equals the one of the whole segmentation."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_containers import Block, Tub, tub_frame
from synthetic_solids import Ball, Box, Plate, solid_frame

from eyehand.perception import (
    DepthFrame,
    SegmentationOptions,
    find_support,
    segment,
)

TABLE, BOARD = Plate((-0.4, 0.4), (0.2, 0.8)), Plate((-0.4, 0.4), (0.9, 1.4), 0.3)
CONTENTS = [
    Block((0.0, 0.0, 0.02), (0.06, 0.04, 0.04)),
    Block((0.11, 0.06, 0.03), (0.05, 0.05, 0.06), 0.7),
]


def assert_same_support(frame: DepthFrame, options: SegmentationOptions | None = None):
    found, expected = find_support(frame, options), segment(frame, options).support
    assert found is not None
    assert expected is not None
    assert np.array_equal(found.normal, expected.normal)
    assert (found.offset, found.tolerance) == (expected.offset, expected.tolerance)


@pytest.mark.parametrize("plates", [(TABLE,), (TABLE, BOARD), (Plate(),)])
@pytest.mark.parametrize(
    "options", [None, SegmentationOptions(stride=2), SegmentationOptions(median=False)]
)
def test_support_of_a_table_or_a_shelf(plates, options):
    solids = [Ball(0.0, 0.6, 0.05, 0.05), Box(0.15, 0.6, (0.08, 0.08, 0.1))]
    assert_same_support(solid_frame(solids, plates)[0], options)


@pytest.mark.parametrize("table_height", [0.0, 0.3])
def test_support_at_a_known_height(table_height):
    frame, _ = solid_frame([], (TABLE, BOARD), known_pose=True)
    assert_same_support(frame, SegmentationOptions(table_height=table_height))


@pytest.mark.parametrize("elevation", [0.9, 1.2])
@pytest.mark.parametrize("table", [None, -0.2, -0.5])
@pytest.mark.parametrize("tub", [Tub(), Tub(height=0.16), Tub(height=0.015, thickness=0.008)])
def test_support_in_a_container(tub, table, elevation):
    frame, _, T_world_camera = tub_frame(tub, CONTENTS, table, elevation)
    assert_same_support(frame)
    assert_same_support(replace(frame, T_world_camera=T_world_camera))


def test_floor_of_a_container_high_above_the_table_is_the_support():
    frame, _, T_world_camera = tub_frame(Tub(), CONTENTS, -0.5)
    support = find_support(frame)
    assert support is not None
    assert support.moved(T_world_camera).offset == pytest.approx(0.0, abs=0.003)


def test_frame_without_a_support():
    frame, _ = solid_frame([], (TABLE,), known_pose=True)
    options = SegmentationOptions(table_height=1.0)
    assert find_support(frame, options) is None
    assert segment(frame, options).support is None
