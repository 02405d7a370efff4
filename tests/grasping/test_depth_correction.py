"""The depth image corrected from the known height of the support."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.grasping import (
    CORRECTED_SCALE_ERROR,
    JawOptions,
    correct_depth,
    load_hand,
    plan_grasps,
)
from eyehand.perception import CameraIntrinsics, DepthFrame, perceive, read_frame

CAMERA = CameraIntrinsics(270.0, 270.0, 159.5, 119.5, 320, 240)
HEIGHT = 0.35
SAMPLE = Path(__file__).parents[2] / "apps" / "sample" / "depth.png"


def table_frame(tilt=0.0, table=0.0) -> DepthFrame:
    """Return a view of a table with a box, from 60° to the vertical; its pose errs by a tilt."""
    look = Rotation.from_euler("x", 180.0 - 50.0, degrees=True)
    pose = RigidTransform.from_components([0.0, -0.4, HEIGHT + table], look)
    rays = CAMERA.rays() @ look.as_matrix().T
    depth = np.where(rays[..., 2] < -0.1, -HEIGHT / np.minimum(rays[..., 2], -0.1), 0.0)
    hit = np.array([0.0, -0.4, HEIGHT]) + depth[..., None] * rays
    top = (HEIGHT - 0.05) / HEIGHT * depth
    raised = np.array([0.0, -0.4, HEIGHT]) + top[..., None] * rays
    on_box = (np.abs(raised[..., :2] - [0.0, 0.0]) < 0.04).all(axis=2)
    depth = np.where(on_box & (hit[..., 1] > -0.3), top, depth)
    depth[depth > 1.5] = 0.0
    wrong = Rotation.from_euler("y", tilt, degrees=True) * look
    return DepthFrame(
        depth.astype(np.float32), CAMERA, RigidTransform.from_components(pose.translation, wrong)
    )


@pytest.mark.parametrize("scale", [0.93, 1.0, 1.06])
@pytest.mark.parametrize("table", [0.0, 0.7])
def test_scale_is_restored(scale, table):
    true = table_frame(table=table)
    frame, correction = correct_depth(
        replace(true, depth=(true.depth * scale).astype(np.float32)), table
    )
    assert correction
    assert correction.scale == pytest.approx(1.0 / scale, rel=3e-3)
    np.testing.assert_allclose(frame.depth, true.depth, atol=3e-3)


def test_tilt_is_removed():
    frame, correction = correct_depth(table_frame(tilt=2.0), 0.0)
    assert correction
    assert np.degrees(correction.tilt) == pytest.approx(2.0, abs=0.1)
    again = correct_depth(frame, 0.0)[1]
    assert np.degrees(again.tilt) < 0.15


def test_large_corrections_are_refused_and_change_nothing():
    true = table_frame()
    wrong = replace(true, depth=(true.depth * 0.7).astype(np.float32))
    frame, correction = correct_depth(wrong, 0.0)
    assert not correction
    assert "at most 15 %" in correction.reason
    assert frame is wrong
    assert not correct_depth(table_frame(tilt=9.0), 0.0)[1]


def test_input_is_checked():
    frame = table_frame()
    with pytest.raises(InputError, match="T_world_camera"):
        correct_depth(replace(frame, T_world_camera=None), 0.0)
    with pytest.raises(InputError, match="must be a number, m, got '0'"):
        correct_depth(frame, "0")  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match=r"at least 0.05 m below the camera at .* got 2.0 m"):
        correct_depth(frame, 2.0)


def test_grasps_know_that_the_scale_was_corrected():
    true = read_frame(SAMPLE)
    wrong = replace(true, depth=(true.depth * np.float32(1.04)))
    corrected = perceive(correct_depth(wrong, 0.0)[0])
    hand = load_hand("panda")
    known = plan_grasps(corrected, hand)[0].success
    assert known > plan_grasps(perceive(wrong), hand)[0].success + 0.03
    options = JawOptions(depth_error=CORRECTED_SCALE_ERROR)
    assert known == plan_grasps(corrected, hand, options)[0].success


def test_error_of_the_scale_is_checked():
    with pytest.raises(InputError, match=r"scale_error must be at least 0, got -0\.1"):
        replace(table_frame(), scale_error=-0.1)
