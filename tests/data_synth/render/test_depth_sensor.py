"""Camera models: shadows, outlines, noise, quantisation and missing contrast on exact views."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eyehand.data_synth import RenderedView
from eyehand.data_synth.render import SENSORS, SensorName, sensor_of
from eyehand.data_synth.render.depth_sensor import matched_disparity, sense_depth, shadow
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics

CAMERA = CameraIntrinsics(525.0, 525.0, 159.5, 119.5, 320, 240)
NAMES: tuple[SensorName, ...] = tuple(SENSORS)
BOX = (slice(80, 160), slice(120, 200))
NEAR_M, FAR_M = 0.7, 1.0


def view_of(depth: np.ndarray, brightness: int = 200) -> RenderedView:
    labels = (depth < 0.9 * FAR_M).astype(np.int32)
    background = np.where(labels > 0, 0, 2).astype(np.uint8)
    colour = np.full((*depth.shape, 3), brightness, np.uint8)
    return RenderedView(depth.astype(np.float32), labels, colour, background)


def box_view() -> RenderedView:
    """Return a view of a square in front of a wall."""
    depth = np.full((240, 320), FAR_M)
    depth[BOX] = NEAR_M
    return view_of(depth)


def sensed(view: RenderedView, name: SensorName, **changes) -> np.ndarray:
    sensor = replace(SENSORS[name], plain_share=0.0, **changes)
    return sense_depth(view, CAMERA, np.random.default_rng(1), sensor)


@pytest.mark.parametrize("name", NAMES)
def test_noise_of_a_wall_follows_the_disparity(name: SensorName):
    sensor = SENSORS[name]
    view = view_of(np.full((240, 320), FAR_M))
    depth = sensed(view, name, two_cameras=False)
    assert np.mean(depth > 0) > 0.99
    per_pixel = FAR_M**2 / (CAMERA.fx * sensor.baseline)
    rounding = sensor.step / np.sqrt(12)
    expected = per_pixel * np.hypot(sensor.noise, rounding)
    assert np.std(depth[depth > 0]) == pytest.approx(expected, rel=0.15)
    levels = CAMERA.fx * sensor.baseline / depth[depth > 0].astype(np.float64) / sensor.step
    assert np.abs(levels - np.rint(levels)).max() < 0.02


@pytest.mark.parametrize("name", NAMES)
def test_shadow_lies_beside_the_object_with_the_width_of_the_disparity_step(name: SensorName):
    sensor = SENSORS[name]
    depth = sensed(box_view(), name, edge_dropout=0.0, noise=0.0)
    step = CAMERA.fx * sensor.baseline * (1 / NEAR_M - 1 / FAR_M)
    row = depth[120]
    left = np.count_nonzero(row[60:120] == 0)
    right = np.count_nonzero(row[200:260] == 0)
    assert left == pytest.approx(step, abs=2 + sensor.window / 2)
    assert right == 0


@pytest.mark.parametrize("name", NAMES)
def test_outline_stays_within_half_a_window(name: SensorName):
    half = SENSORS[name].window // 2
    depth = sensed(box_view(), name, edge_dropout=0.0, noise=0.0)
    rows = np.arange(240)
    nearer = (depth[:, 160] > 0) & (depth[:, 160] < 0.8)
    edge = rows[nearer]
    assert abs(edge.min() - 80) <= half
    assert abs(edge.max() - 159) <= half
    assert half == 0 or np.ptp([np.flatnonzero((c > 0) & (c < 0.8)).min()
                                for c in depth.T[130:190]]) > 0  # fmt: skip


def test_shadow_of_a_plane_is_empty_at_any_slope():
    columns = np.arange(320, dtype=np.float32)
    for slope in (-0.6, -0.2, 0.0, 0.2, 0.6):
        plane = np.tile(60 + slope * (columns - 160) / 2, (4, 1)).astype(np.float32)
        assert not shadow(plane).any()


def test_window_keeps_planes_and_smooths_small_steps():
    rows, columns = np.mgrid[:60, :80].astype(np.float32)
    plane = 40 + 0.05 * columns - 0.03 * rows
    rng = np.random.default_rng(0)
    kept, edge = matched_disparity(plane, 9, 2.0, rng)
    assert np.abs(kept - plane)[5:-5, 5:-5].max() < 1e-4
    assert not edge.any()
    plane[:, 40:] += 1.0
    smooth, edge = matched_disparity(plane, 9, 2.0, rng)
    assert np.abs(np.diff(smooth[30])).max() < 0.3
    assert not edge.any()
    sharp, edge = matched_disparity(plane, 9, 0.5, rng)
    assert np.abs(np.diff(sharp[30])).max() > 0.5


def test_dark_surfaces_lose_readings_and_bright_ones_do_not():
    wall = np.full((240, 320), FAR_M)
    bright, dark = (sensed(view_of(wall, level), "structured-light") for level in (200, 8))
    assert np.mean(bright == 0) < 0.01
    assert 0.3 < np.mean(dark == 0) < 0.9


def test_plain_surfaces_lose_readings_of_a_passive_camera():
    sensor = replace(SENSORS["oak"], plain_share=1.0, two_cameras=False)
    depth = sense_depth(
        view_of(np.full((240, 320), FAR_M)), CAMERA, np.random.default_rng(0), sensor
    )
    assert np.mean(depth == 0) == pytest.approx(sensor.plain_dropout, abs=0.05)


def test_second_camera_does_not_see_the_left_edge():
    depth = sensed(view_of(np.full((240, 320), FAR_M)), "stereo")
    width = CAMERA.fx * SENSORS["stereo"].baseline / FAR_M
    assert np.all(depth[:, : int(width)] == 0)
    assert np.all(depth[:, int(width) + 2 :] > 0)


def test_same_seed_gives_same_readings_and_unknown_name_raises():
    view = box_view()
    one, again = (
        sense_depth(view, CAMERA, np.random.default_rng(4), SENSORS["oak"]) for _ in range(2)
    )
    assert np.array_equal(one, again)
    assert sensor_of("oak") is SENSORS["oak"]
    with pytest.raises(InputError, match="'lidar' is unknown, expected kinect-v1"):
        sensor_of("lidar")
