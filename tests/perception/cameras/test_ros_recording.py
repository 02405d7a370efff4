"""Depth frames come out of ROS 2 recordings as they went in; unusable recordings are named."""

from __future__ import annotations

import importlib
import struct
import sys
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.cameras import RosRecording, write_ros_frames
from eyehand.perception.cameras.ros_messages import (
    DEFINITIONS,
    definition,
    ros_header,
    ros_transform,
    ros_writer,
)

pytest.importorskip("mcap_ros2", reason="recordings of ROS 2 need the extra [ros]")

HEIGHT, WIDTH = 48, 64
CAMERA = CameraIntrinsics(60.0, 61.0, 31.5, 23.5, WIDTH, HEIGHT)
TOPIC = "/camera/depth/image_raw"


@pytest.fixture
def depth():
    """Return a tilted plane 0.7 to 1.3 m away in whole mm, with a hole, (H, W) float32."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    millimetres = 700 + 10 * rows + 2 * columns
    millimetres[10:14, 20:24] = 0
    return (millimetres / 1000.0).astype(np.float32)


def camera_info(**changes):
    """Return a CameraInfo of CAMERA."""
    eye = np.eye(3).ravel().tolist()
    return {
        "header": ros_header(0.0, "camera"),
        "height": HEIGHT,
        "width": WIDTH,
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": CAMERA.matrix.ravel().tolist(),
        "r": eye,
        "p": [*np.zeros(12)],
    } | changes


def image(data: np.ndarray, encoding: str, **changes: Any) -> dict[str, Any]:
    """Return an Image with the bytes of `data`, (H, W) or with padded rows."""
    return {
        "header": ros_header(0.0, "camera"),
        "height": HEIGHT,
        "width": WIDTH,
        "encoding": encoding,
        "is_bigendian": 0,
        "step": data.nbytes // len(data),
        "data": data.tobytes(),
    } | changes


def write(path, messages, topic=TOPIC, info=None):
    """Write images, (type, message), after a CameraInfo."""
    with ros_writer(path) as writer:
        if info is not None:
            where = f"{topic.rpartition('/')[0]}/camera_info"
            writer.write(where, "sensor_msgs/CameraInfo", info, 0.0)
        for number, (kind, message) in enumerate(messages):
            writer.write(topic, f"sensor_msgs/{kind}", message, 0.1 * number)
    return path


def only_frame(path, **options) -> DepthFrame:
    (frame,) = RosRecording(path, **options).frames()
    return frame


def test_written_frames_are_read_back_exactly(tmp_path, depth):
    frames = [DepthFrame(depth, CAMERA), DepthFrame(depth * np.float32(0.77), CAMERA)]
    write_ros_frames(tmp_path / "a.mcap", frames)
    read = list(RosRecording(tmp_path / "a.mcap", topic="/camera/depth").frames())
    assert len(read) == 2
    for one, other in zip(read, frames, strict=True):
        np.testing.assert_array_equal(one.depth, other.depth)
        assert one.intrinsics == CAMERA


def test_colour_and_pose_are_read_back(tmp_path, depth):
    rng = np.random.default_rng(0)
    pose = RigidTransform.from_components([0.1, -0.2, 0.9], Rotation.random(rng=rng))
    colours = rng.integers(0, 256, (2, HEIGHT, WIDTH, 3), dtype=np.uint8)
    frames = [DepthFrame(depth, CAMERA, pose, colour) for colour in colours]
    write_ros_frames(tmp_path / "a.mcap", [*frames, DepthFrame(depth, CAMERA)])
    *read, bare = RosRecording(tmp_path / "a.mcap").frames()
    for one, colour in zip(read, colours, strict=True):
        assert one.colour is not None
        assert one.T_world_camera is not None
        np.testing.assert_array_equal(one.colour, colour)
        np.testing.assert_allclose(one.T_world_camera.as_matrix(), pose.as_matrix(), atol=1e-14)
    assert bare.colour is None


def test_static_pose_counts_wherever_it_stands_in_the_file(tmp_path, depth):
    pose = RigidTransform.from_translation([0.1, -0.2, 0.9])
    static = {"transforms": [ros_transform(0.0, "world", "camera", pose)]}
    with ros_writer(tmp_path / "a.mcap") as writer:
        writer.write("/camera/depth/camera_info", "sensor_msgs/CameraInfo", camera_info(), 0.0)
        writer.write(TOPIC, "sensor_msgs/Image", image(depth, "32FC1"), 0.0)
        writer.write("/tf_static", "tf2_msgs/TFMessage", static, 0.1)
    read = only_frame(tmp_path / "a.mcap", topic=TOPIC)
    assert read.T_world_camera is not None
    np.testing.assert_array_equal(read.T_world_camera.as_matrix(), pose.as_matrix())


@pytest.mark.parametrize("slash", ["", "/"])
def test_pose_over_other_frames(tmp_path, depth, slash):
    rng = np.random.default_rng(0)
    base, link, lens = (
        RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
        for _ in range(3)
    )
    chain = [("link", "camera", lens), (f"{slash}world", "base", base), ("base", "link", link)]
    with ros_writer(tmp_path / "a.mcap") as writer:
        messages = [ros_transform(0.0, *one) for one in chain]
        writer.write("/tf_static", "tf2_msgs/TFMessage", {"transforms": messages}, 0.0)
        writer.write("/camera/depth/camera_info", "sensor_msgs/CameraInfo", camera_info(), 0.0)
        writer.write(TOPIC, "sensor_msgs/Image", image(depth, "32FC1"), 0.0)
    read = only_frame(tmp_path / "a.mcap", topic=TOPIC)
    assert read.T_world_camera is not None
    expected = (base * link * lens).as_matrix()
    np.testing.assert_allclose(read.T_world_camera.as_matrix(), expected, atol=1e-12)


def test_folder_of_a_recorder_is_read_if_it_holds_one_file(tmp_path, depth):
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information:\n")
    with pytest.raises(InputError, match="is a folder without a recording"):
        RosRecording(tmp_path)
    write(tmp_path / "bag_0.mcap", [("Image", image(depth, "32FC1"))], info=camera_info())
    np.testing.assert_array_equal(only_frame(tmp_path).depth, depth)
    write(tmp_path / "bag_1.mcap", [("Image", image(depth, "32FC1"))], info=camera_info())
    with pytest.raises(InputError, match=r"name one: .*bag_0\.mcap, .*bag_1\.mcap"):
        RosRecording(tmp_path)


def write_colour(path, depth, pixels, encoding, **changes):
    """Write one colour image and a depth image of the same time."""
    info, colour = camera_info(), image(pixels, encoding, **changes)
    with ros_writer(path) as writer:
        writer.write("/camera/depth/camera_info", "sensor_msgs/CameraInfo", info, 0.0)
        writer.write("/camera/depth/colour", "sensor_msgs/Image", colour, 0.0)
        writer.write(TOPIC, "sensor_msgs/Image", image(depth, "32FC1"), 0.0)
    return path


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "rgba8", "bgra8"])
def test_colours_of_all_orders_with_padded_rows(tmp_path, depth, encoding):
    rgb = np.random.default_rng(0).integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    pixels = np.full((HEIGHT, WIDTH + 2, len(encoding) - 1), 255, np.uint8)
    pixels[:, :WIDTH, :3] = rgb[..., ::-1] if encoding.startswith("bgr") else rgb
    read = only_frame(write_colour(tmp_path / "a.mcap", depth, pixels, encoding), topic=TOPIC)
    assert read.colour is not None
    np.testing.assert_array_equal(read.colour, rgb)


@pytest.mark.parametrize(
    ("encoding", "width", "message"),
    [("yuv422", WIDTH, "encoding 'yuv422', expected rgb8, bgr8"), ("bgr8", 8, "8x48 px, expected")],
)
def test_colour_that_is_not_read_is_refused(tmp_path, depth, encoding, width, message):
    pixels = np.zeros((HEIGHT, width, 3), np.uint8)
    file = write_colour(tmp_path / "a.mcap", depth, pixels, encoding, width=width)
    with pytest.raises(InputError, match=f"image 0 of {TOPIC}.* {message}"):
        only_frame(file, topic=TOPIC)


@pytest.mark.parametrize("order", ["<", ">"])
def test_whole_millimetres_with_padded_rows(tmp_path, depth, order):
    padded = np.zeros((HEIGHT, WIDTH + 5), f"{order}u2")
    padded[:, :WIDTH] = np.rint(1000 * depth)
    message = image(padded, "16UC1", is_bigendian=int(order == ">"))
    read = only_frame(write(tmp_path / "a.mcap", [("Image", message)], info=camera_info()))
    np.testing.assert_array_equal(read.depth, depth)


def test_readings_that_are_not_finite_are_gaps(tmp_path, depth):
    holes = depth.copy()
    holes[0, :3] = (np.nan, np.inf, -np.inf)
    message = image(holes, "32FC1")
    read = only_frame(write(tmp_path / "a.mcap", [("Image", message)], info=camera_info()))
    depth[0, :3] = 0.0
    np.testing.assert_array_equal(read.depth, depth)


def test_compressed_depth_of_both_kinds(tmp_path, depth):
    def packed(pixels, scale=0.0, offset=0.0):
        png = cv2.imencode(".png", pixels)[1].tobytes()
        return struct.pack("<iff", 0, scale, offset) + png

    head = {"header": ros_header(0.0, "camera")}
    # Quantised inverse depth of compressed_depth_image_transport: v = scale / depth + offset.
    scale, offset = 1000.0, 100.0
    inverse = np.zeros_like(depth)
    np.divide(scale, depth, out=inverse, where=depth > 0)
    coded = np.where(depth > 0, np.rint(inverse + offset), 0).astype(np.uint16)
    messages = [
        ("CompressedImage", head | {"format": f"{kind}; compressedDepth png", "data": data})
        for kind, data in (
            ("16UC1", packed(np.rint(1000 * depth).astype(np.uint16))),
            ("32FC1", packed(coded, scale, offset)),
        )
    ]
    path = tmp_path / "a.mcap"
    topic = f"{TOPIC}/compressedDepth"
    with ros_writer(path) as writer:
        writer.write("/camera/depth/camera_info", "sensor_msgs/CameraInfo", camera_info(), 0.0)
        for kind, message in messages:
            writer.write(topic, f"sensor_msgs/{kind}", message, 0.0)
    whole, quantised = RosRecording(path).frames()
    np.testing.assert_array_equal(whole.depth, depth)
    np.testing.assert_allclose(quantised.depth, depth, rtol=1e-3)
    assert (quantised.depth[10:14, 20:24] == 0).all()


def test_lens_distortion_is_corrected(tmp_path):
    lens = np.array([-0.3, 0.1, 0.0, 0.0, 0.0])
    pixels = np.stack(np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)), axis=-1, dtype=np.float64)
    K = CAMERA.matrix
    straight = cv2.undistortPoints(pixels.reshape(-1, 1, 2), K, lens, P=K).reshape(pixels.shape)
    plane = (0.5 + 0.01 * straight[..., 0]).astype(np.float32)
    path = write(
        tmp_path / "a.mcap", [("Image", image(plane, "32FC1"))], info=camera_info(d=lens.tolist())
    )
    read = only_frame(path)
    seen = read.depth > 0
    assert seen.mean() > 0.8
    expected = np.broadcast_to(0.5 + 0.01 * np.arange(WIDTH), seen.shape)
    np.testing.assert_allclose(read.depth[seen], expected[seen], atol=0.0075)


def test_rectified_image_has_the_projection_of_its_camera_info(tmp_path, depth):
    projection = [70.0, 0.0, 30.0, 0.0, 0.0, 71.0, 20.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    info = camera_info(d=[0.2, -0.1, 0.0, 0.0, 0.0], p=projection)
    topic = "/camera/depth/image_rect"
    path = write(tmp_path / "a.mcap", [("Image", image(depth, "32FC1"))], topic, info)
    frame = only_frame(path)
    np.testing.assert_array_equal(frame.depth, depth)
    k = frame.intrinsics
    assert (k.fx, k.fy, k.cx, k.cy) == (70.0, 71.0, 30.0, 20.0)


def test_message_without_the_fields_of_its_type_is_refused(tmp_path, depth, monkeypatch):
    short = "std_msgs/Header header\nuint32 height\nuint32 width"
    monkeypatch.setitem(DEFINITIONS, "sensor_msgs/Image", short)
    path = write(tmp_path / "a.mcap", [("Image", image(depth, "32FC1"))], info=camera_info())
    with pytest.raises(InputError, match="has no attribute 'encoding'"):
        only_frame(path)


def test_camera_file_replaces_camera_info(tmp_path, depth):
    from eyehand.perception.io import write_intrinsics

    path = write(tmp_path / "a.mcap", [("Image", image(depth, "32FC1"))])
    with pytest.raises(InputError, match="no CameraInfo beside /camera/depth/image_raw"):
        RosRecording(path)
    write_intrinsics(tmp_path / "camera.json", CAMERA)
    read = only_frame(path, camera=tmp_path / "camera.json")
    assert read.intrinsics == CAMERA


@pytest.mark.parametrize(
    ("message", "info", "fault"),
    [
        ({"encoding": "rgb8"}, {}, "encoding is 'rgb8', expected 16UC1, mono16, 32FC1"),
        ({"step": 3}, {}, "bytes in rows of 3"),
        ({"height": HEIGHT + 1}, {}, "which are no 64x49 px of 32FC1"),
        ({"width": 2**31}, {}, "px"),
        ({}, {"height": 2 * HEIGHT}, "CameraInfo is of 64x96 px"),
        ({}, {"k": [0.0] * 9}, "CameraInfo k"),
        ({}, {"d": [0.1], "distortion_model": "fisheye"}, "distortion model 'fisheye'"),
    ],
)
def test_unusable_image_is_named(tmp_path, depth, message, info, fault):
    messages = [("Image", image(depth, "32FC1") | message)]
    path = write(tmp_path / "a.mcap", messages, info=camera_info(**info))
    with pytest.raises(InputError, match=fault) as caught:
        only_frame(path)
    assert f"{path}: image 0 of {TOPIC}" in str(caught.value)


@pytest.mark.parametrize(
    ("topic", "fault"),
    [
        ("/none", f"topic /none is not in the recording; topics of images: {TOPIC}"),
        ("/camera/depth/camera_info", "holds sensor_msgs/msg/CameraInfo"),
    ],
)
def test_wrong_topic_is_named_with_the_right_ones(tmp_path, depth, topic, fault):
    path = write(tmp_path / "a.mcap", [("Image", image(depth, "32FC1"))], info=camera_info())
    with pytest.raises(InputError, match=fault):
        RosRecording(path, topic=topic)


def test_truncated_or_changed_recordings_are_refused(tmp_path, depth):
    path = write(tmp_path / "a.mcap", [("Image", image(depth, "32FC1"))] * 3, info=camera_info())
    whole = path.read_bytes()
    broken = tmp_path / "b.mcap"
    rng = np.random.default_rng(0)
    refused = 0
    for _ in range(60):
        data = bytearray(whole[: rng.integers(1, len(whole))] if rng.random() < 0.3 else whole)
        data[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
        broken.write_bytes(data)
        try:
            frames = list(RosRecording(broken).frames())
        except InputError:
            refused += 1
        else:
            np.testing.assert_array_equal(frames[0].depth, depth)
    assert refused > 40


def test_without_the_extra_one_line_says_what_to_install(tmp_path, depth, monkeypatch):
    path = write(tmp_path / "a.mcap", [("Image", image(depth, "32FC1"))], info=camera_info())
    for name in ("mcap.reader", "mcap_ros2.writer"):
        importlib.import_module(name)
        monkeypatch.setitem(sys.modules, name, None)
    for use in (lambda: RosRecording(path), lambda: write_ros_frames(tmp_path / "b.mcap", [])):
        with pytest.raises(InputError, match=r"pip install 'eyehand\[ros\]'"):
            use()
    assert not (tmp_path / "b.mcap").exists()


def test_definition_lists_each_type_once():
    text = definition("visualization_msgs/MarkerArray")
    names = [line.removeprefix("MSG: ") for line in text.splitlines() if line.startswith("MSG: ")]
    assert len(names) == len(set(names)) == 12
    assert "geometry_msgs/Quaternion" in names
