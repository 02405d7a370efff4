"""Tests of the warnings: each kind occurs where it should, and nowhere else."""

import numpy as np
import pytest
from synthetic_solids import Ball, Box, Plate, solid_frame

from eyehand.perception import segment
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.scene_warnings import find_warnings
from eyehand.perception.segmentation.support_extent import Support

SUPPORT = Support(SupportPlane(np.eye(3)[2], 1.0), np.zeros((3, 2), np.float32), np.eye(3)[:2], 1.0)
NOTHING = np.zeros((10, 10), bool)


def kinds(frame):
    return [warning.kind for warning in segment(frame).warnings]


def test_ordinary_scene_has_no_warning():
    frame, _ = solid_frame([Ball(0.0, 0.65, 0.05, 0.05)], (Plate(),))
    assert kinds(frame) == []


def test_scene_without_support_is_warned_about():
    frame, _ = solid_frame([Ball(0.0, 0.6, 0.1, 0.1)], ())
    assert kinds(frame) == ["no_support"]


def test_walls_around_a_floor_make_a_container():
    walls = [
        Box(-0.21, 0.7, (0.02, 0.44, 0.1)),
        Box(0.21, 0.7, (0.02, 0.44, 0.1)),
        Box(0.0, 0.49, (0.4, 0.02, 0.02)),
        Box(0.0, 0.91, (0.4, 0.02, 0.1)),
    ]
    ball = Ball(0.0, 0.7, 0.05, 0.05)
    frame, labels = solid_frame([*walls, ball], (Plate((-0.22, 0.22), (0.48, 0.92)),))
    found = segment(frame)
    assert len(found.containers) == 1
    assert [warning.kind for warning in found.warnings] == ["container"]
    assert found.count == 1
    overlap = (found.labels == 1) & (labels == 5)
    assert overlap.sum() > 0.9 * ((found.labels == 1) | (labels == 5)).sum()


@pytest.mark.parametrize(("share", "expected"), [(0.0, []), (0.5, ["nothing_found"])])
def test_empty_result_with_unexplained_readings_is_warned_about(share, expected):
    above = NOTHING.copy()
    above[: round(10 * share)] = True
    found = find_warnings(np.zeros((10, 10), np.int32), {}, [SUPPORT], (), above)
    assert [warning.kind for warning in found] == expected


def test_cut_and_ambiguous_objects_are_named():
    labels = np.zeros((10, 10), np.int32)
    labels[0, 3:5], labels[4:6, 4:6] = 2, 1
    found = find_warnings(labels, {1: "flat"}, [SUPPORT], (), NOTHING)
    assert [(warning.kind, warning.label) for warning in found] == [
        ("cut_by_image", 2),
        ("may_be_several", 1),
    ]
