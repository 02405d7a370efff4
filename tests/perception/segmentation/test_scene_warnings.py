"""Tests of the warnings: each kind occurs where it should, and nowhere else."""

import numpy as np
import pytest
from random_planes import image_of
from synthetic_solids import Ball, Box, Plate, solid_frame

from eyehand.perception import CameraIntrinsics, DepthFrame, segment
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.container import Container
from eyehand.perception.segmentation.scene_warnings import find_warnings, lost_warnings
from eyehand.perception.segmentation.support_extent import Support

SUPPORT = Support(SupportPlane(np.eye(3)[2], 1.0), np.zeros((3, 2), np.float32), np.eye(3)[:2], 1.0)
NOTHING = np.zeros((10, 10), bool)
LABELS = np.zeros((10, 10), np.int32)


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


@pytest.mark.parametrize(("share", "expected"), [(0.02, []), (0.2, ["support_unseen"])])
def test_readings_out_of_reach_are_warned_about(share, expected):
    found = find_warnings(LABELS, {}, [SUPPORT], (), NOTHING, share)
    assert [warning.kind for warning in found] == expected


def test_cut_and_ambiguous_objects_are_named():
    labels = np.zeros((10, 10), np.int32)
    labels[0, 3:5], labels[4:6, 4:6] = 2, 1
    found = find_warnings(labels, {1: "flat"}, [SUPPORT], (), NOTHING, sheets=(2,))
    assert [(warning.kind, warning.label) for warning in found] == [
        ("cut_by_image", 2),
        ("may_be_several", 1),
        ("may_be_background", 2),
    ]


@pytest.mark.parametrize(
    ("box", "expected"),
    [
        (Box(0.0, 0.7, (0.25, 0.004, 0.12)), True),
        (Box(0.0, 0.7, (0.25, 0.06, 0.12)), False),
        (Box(0.0, 0.7, (0.1, 0.004, 0.08)), False),
    ],
)
def test_long_thin_sheet_may_be_background(box, expected):
    frame, _ = solid_frame([box], (Plate(),))
    found = [one for one in segment(frame).warnings if one.kind == "may_be_background"]
    assert [one.label for one in found] == [1] * expected


def test_doubtful_support_names_the_other_plane():
    rival = SUPPORT._replace(plane=SupportPlane(np.eye(3)[2], 0.9), score=0.5, area=0.1)
    support = SUPPORT._replace(score=1.0, runner_up=rival)
    (warning,) = find_warnings(LABELS, {}, [support], (), NOTHING)
    assert warning.kind == "support_doubtful"
    assert warning.plane is rival.plane
    assert "10.0 cm above it has 50 %" in warning.message
    weaker = support._replace(runner_up=rival._replace(score=0.2))
    floor = support._replace(runner_up=rival._replace(plane=SupportPlane(np.eye(3)[2], 1.7)))
    assert find_warnings(LABELS, {}, [weaker], (), NOTHING) == ()
    assert find_warnings(LABELS, {}, [floor], (), NOTHING) == ()
    container = Container(support.plane, (), 0.1)
    (enclosed,) = find_warnings(LABELS, {}, [support], (container,), NOTHING)
    assert enclosed.kind == "container"


@pytest.mark.parametrize(("side", "rise"), [(0.13, 0.5), (0.1, 0.4)])
def test_sheet_high_above_the_floor_makes_the_support_doubtful(side, rise):
    sheet = Plate((-side / 2, side / 2), (0.6, 0.6 + 0.8 * side))
    frame, _ = solid_frame([], (sheet, Plate((-1.5, 1.5), (0.0, 3.0), -rise)))
    found = segment(frame)
    (warning,) = (one for one in found.warnings if one.kind == "support_doubtful")
    assert warning.plane is not None
    assert found.support is not None
    assert found.support.offset - warning.plane.offset == pytest.approx(rise, abs=0.002)


def test_readings_below_the_support_are_warned_about():
    found = find_warnings(LABELS, {}, [SUPPORT._replace(share_below=0.1)], (), NOTHING)
    assert [warning.kind for warning in found] == ["below_support"]


def test_two_equal_tables_make_the_support_doubtful():
    high = Plate((0.05, 0.5), (0.4, 1.0), 0.1)
    frame, _ = solid_frame([], (Plate((-0.5, 0.05), (0.4, 1.0)), high))
    found = segment(frame)
    assert "support_doubtful" in kinds(frame) or len(found.other_supports) == 1


def _odd_frame(kind, rng):
    depth = np.full((240, 320), 1.0)
    v, u = np.mgrid[:240, :320]
    match kind:
        case "noise":
            depth = rng.uniform(0.5, 2.0, depth.shape)
        case "stripes":
            depth[:, ::2] = 0.7
        case "sphere":
            depth = 1.0 - np.sqrt(
                np.maximum(0.3 - ((u - 160) / 320) ** 2 - ((v - 120) / 320) ** 2, 0)
            )
        case "steps":
            depth += 0.05 * (u // 20)
        case "wave":
            depth += 0.1 * np.sin(u / 9) * np.cos(v / 7)
        case "specks":
            depth[rng.random(depth.shape) < 0.97] = 0.0
        case "near":
            depth[60:180, 80:240] = 0.2
        case "patches":
            for _ in range(40):
                y, x = rng.integers(0, 220), rng.integers(0, 300)
                depth[y : y + 20, x : x + 20] -= rng.uniform(0.01, 0.3)
    return DepthFrame(depth.astype(np.float32), CameraIntrinsics(260, 260, 159.5, 119.5, 320, 240))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    "kind", ["noise", "stripes", "sphere", "steps", "wave", "specks", "near", "patches"]
)
def test_no_object_without_a_reason(kind, seed):
    frame = _odd_frame(kind, np.random.default_rng(seed))
    found = segment(frame)
    if found.count == 0 and not found.warnings:
        assert found.support is not None
        heights = found.support.height(frame.points())[frame.valid]
        assert np.mean(np.abs(heights) < 0.01) > 0.9


def test_support_that_continues_outside_its_outline_is_doubtful():
    for continued, kinds in ((1.1, []), (3.0, ["support_doubtful"])):
        found = find_warnings(LABELS, {}, [SUPPORT], (), NOTHING, continued=continued)
        assert [one.kind for one in found] == kinds


@pytest.mark.parametrize(("rows", "expected"), [(12, ["object_missing"]), (8, [])])
def test_large_lost_region_is_named_with_its_place(rows, expected):
    lost = np.zeros((480, 640), bool)
    lost[100 : 100 + rows, 200:220] = True
    found = lost_warnings(lost, image_of(np.ones((480, 640), np.float32)), 2)
    assert [warning.kind for warning in found] == expected
    assert all("column 420, row 212" in warning.message for warning in found)
