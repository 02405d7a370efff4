"""Tests of reading and writing depth frames, with synthetic, damaged and real files."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.io.depth_frame import read_frame, write_frame
from eyehand.perception.io.intrinsics import write_intrinsics

DATA = Path(__file__).parents[3] / ".." / "shared" / "data"
real_frames = pytest.mark.skipif(
    not (DATA / "frames").is_dir(), reason="third-party frames (../shared/data) are absent"
)

K = CameraIntrinsics(25.5, 26.25, 7.25, 5.5, 16, 12)
POSE = RigidTransform.from_components([0.1, 0.2, 0.9], Rotation.from_rotvec([2.5, 0.1, 0.2]))
RAMP = np.arange(300, 492, dtype=np.uint16).reshape(12, 16)


@st.composite
def frames(draw: st.DrawFn) -> DepthFrame:
    """Draw frames with depth in whole millimetres and missing readings."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    millimetres = rng.integers(100, draw(st.integers(200, 65536)), (12, 16))
    millimetres[rng.random((12, 16)) < draw(st.floats(0, 0.5))] = 0
    millimetres[[0, 11], [0, 15]] = 500
    colour = rng.integers(0, 256, (12, 16, 3), dtype=np.uint8) if draw(st.booleans()) else None
    pose = POSE if draw(st.booleans()) else None
    return DepthFrame((millimetres / 1000).astype(np.float32), K, pose, colour)


def _assert_equal(back: DepthFrame, frame: DepthFrame) -> None:
    np.testing.assert_array_equal(back.depth, frame.depth)
    assert back.depth.dtype == np.float32
    assert back.intrinsics == frame.intrinsics
    assert (back.colour is None) == (frame.colour is None)
    if frame.colour is not None:
        np.testing.assert_array_equal(back.colour, frame.colour)
    assert (back.T_world_camera is None) == (frame.T_world_camera is None)
    if frame.T_world_camera is not None and back.T_world_camera is not None:
        np.testing.assert_allclose(
            back.T_world_camera.as_matrix(), frame.T_world_camera.as_matrix(), atol=1e-12
        )


@pytest.mark.parametrize("suffix", [".png", ".npz", ".pcd", ".ply", ".PNG"])
@settings(deadline=None, max_examples=15)
@given(frame=frames())
def test_frames_in_millimetres_round_trip(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, frame: DepthFrame
) -> None:
    folder = tmp_path_factory.mktemp("frame")
    written = write_frame(folder / f"a{suffix}", frame)
    assert written[0] == folder / f"a{suffix}"
    assert sorted(written) == sorted(folder.iterdir())
    _assert_equal(read_frame(written[0]), frame)


@settings(deadline=None, max_examples=15)
@given(frame=frames(), suffix=st.sampled_from([".pcd", ".ply"]))
def test_cloud_without_camera_file_recovers_intrinsics(
    tmp_path_factory: pytest.TempPathFactory, frame: DepthFrame, suffix: str
) -> None:
    path, camera = write_frame(tmp_path_factory.mktemp("frame") / f"a{suffix}", frame)
    camera.unlink()
    back = read_frame(path)
    np.testing.assert_array_equal(back.depth, frame.depth)
    recovered, expected = ([k.fx, k.fy, k.cx, k.cy] for k in (back.intrinsics, frame.intrinsics))
    np.testing.assert_allclose(recovered, expected, atol=1e-3)


@pytest.mark.parametrize("suffix", [".npz", ".pcd", ".ply"])
def test_formats_except_png_keep_float_depth(tmp_path: Path, suffix: str) -> None:
    depth = np.random.default_rng(1).uniform(0.3, 2, (12, 16)).astype(np.float32)
    path = write_frame(tmp_path / f"a{suffix}", DepthFrame(depth, K))[0]
    np.testing.assert_array_equal(read_frame(path).depth, depth)


def test_png_rounds_to_nearest_millimetre(tmp_path: Path) -> None:
    depth = np.full((12, 16), 0.50061, dtype=np.float32)
    path = write_frame(tmp_path / "a.png", DepthFrame(depth, K))[0]
    np.testing.assert_array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), 501)
    camera = json.loads((tmp_path / "a.json").read_text())
    assert camera["depth_scale_mm"] == 1.0
    assert camera["colour"] is None


def test_stale_colour_image_is_ignored(tmp_path: Path) -> None:
    depth = (RAMP / 1000).astype(np.float32)
    colour = np.full((12, 16, 3), 9, dtype=np.uint8)
    files = write_frame(tmp_path / "a.png", DepthFrame(depth, K, colour=colour))
    assert [f.name for f in files] == ["a.png", "a.json", "a_colour.png"]
    write_frame(tmp_path / "a.png", DepthFrame(depth, K))
    assert read_frame(tmp_path / "a.png").colour is None


def test_depth_beyond_16_bits_writes_nothing(tmp_path: Path) -> None:
    frame = DepthFrame(np.full((12, 16), 70.0, dtype=np.float32), K)
    with pytest.raises(InputError, match=r"a\.png: depth reaches 70\.000 m"):
        write_frame(tmp_path / "a.png", frame)
    assert list(tmp_path.iterdir()) == []


def test_write_reports_formats_and_missing_folder(tmp_path: Path) -> None:
    frame = DepthFrame(np.ones((12, 16), dtype=np.float32), K)
    with pytest.raises(InputError, match=r"suffix '\.tif' is .*one of \.png, \.npz, \.pcd, \.ply"):
        write_frame(tmp_path / "a.tif", frame)
    with pytest.raises(InputError, match=r"there is no folder .*absent"):
        write_frame(tmp_path / "absent" / "a.png", frame)


def _write_png(tmp_path: Path, image: np.ndarray = RAMP, name: str = "depth.png") -> Path:
    assert cv2.imwrite(str(tmp_path / name), image)
    return tmp_path / name


def test_depth_without_scale_is_in_millimetres(tmp_path: Path) -> None:
    write_intrinsics(tmp_path / "intrinsics.json", K)
    frame = read_frame(_write_png(tmp_path))
    np.testing.assert_array_equal(frame.depth, (RAMP / 1000).astype(np.float32))


def test_camera_file_sets_depth_scale(tmp_path: Path) -> None:
    camera = write_intrinsics(tmp_path / "k.json", K, depth_scale_mm=0.25, T_world_camera=POSE)
    frame = read_frame(str(_write_png(tmp_path)), str(camera))
    np.testing.assert_array_equal(frame.depth, (RAMP / 4000).astype(np.float32))
    assert frame.T_world_camera is not None


def test_bop_camera_is_selected_by_image_number(tmp_path: Path) -> None:
    entry = {"cam_K": K.matrix.ravel().tolist(), "depth_scale": 1.0}
    cameras = {"4": entry | {"depth_scale": 9.0}, "12": entry}
    (tmp_path / "scene_camera.json").write_text(json.dumps(cameras))
    frame = read_frame(_write_png(tmp_path, name="000012.png"))
    np.testing.assert_array_equal(frame.depth, (RAMP / 1000).astype(np.float32))


@pytest.mark.parametrize("name", ["depth_colour.png", "depth_color.png", "colour.png", "color.png"])
def test_colour_image_beside_depth_is_read_as_rgb(tmp_path: Path, name: str) -> None:
    write_intrinsics(tmp_path / "camera.json", K)
    bgr = np.zeros((12, 16, 3), dtype=np.uint8)
    bgr[...] = [30, 20, 10]
    _write_png(tmp_path, bgr, name)
    colour = read_frame(_write_png(tmp_path)).colour
    assert colour is not None
    assert colour[0, 0].tolist() == [10, 20, 30]


def test_missing_colour_image_is_reported_with_the_key_that_names_it(tmp_path: Path) -> None:
    frame = DepthFrame((RAMP / 1000).astype(np.float32), K, colour=np.ones((12, 16, 3), np.uint8))
    write_frame(tmp_path / "a.png", frame)
    (tmp_path / "a_colour.png").unlink()
    with pytest.raises(InputError, match=r"a_colour\.png: no such file, but `colour` of the cam"):
        read_frame(tmp_path / "a.png")


def test_colour_image_of_other_size_is_ignored_with_a_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_intrinsics(tmp_path / "camera.json", K)
    _write_png(tmp_path, np.zeros((24, 32, 3), dtype=np.uint8), "colour.png")
    assert read_frame(_write_png(tmp_path)).colour is None
    assert "colour.png is ignored: it has 32x24 px and the depth image 16x12 px" in caplog.text


def test_colour_image_of_a_folder_camera_must_exist(tmp_path: Path) -> None:
    path = write_intrinsics(tmp_path / "camera.json", K)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"color": "absent.png"}))
    with pytest.raises(InputError, match=r"absent\.png: no such file"):
        read_frame(_write_png(tmp_path))


def test_declared_colour_image_must_exist_and_match(tmp_path: Path) -> None:
    colour = np.zeros((12, 16, 3), dtype=np.uint8)
    frame = DepthFrame((RAMP / 1000).astype(np.float32), K, colour=colour)
    path = write_frame(tmp_path / "a.png", frame)[0]
    _write_png(tmp_path, np.zeros((2, 2, 3), dtype=np.uint8), "a_colour.png")
    with pytest.raises(InputError, match=r"a_colour\.png: the colour image is 2x2 px, expected 16"):
        read_frame(path)
    (tmp_path / "a_colour.png").unlink()
    with pytest.raises(InputError, match=r"a_colour\.png: no such file"):
        read_frame(path)


def test_broken_colour_image_is_reported(tmp_path: Path) -> None:
    write_intrinsics(tmp_path / "camera.json", K)
    (tmp_path / "color.png").write_bytes(b"no image")
    with pytest.raises(InputError, match=r"color\.png: not a PNG file"):
        read_frame(_write_png(tmp_path))


def test_missing_intrinsics_report_files_and_formats(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_frame(_write_png(tmp_path))
    message = str(caught.value)
    for part in (
        "depth.png: no camera intrinsics",
        "depth.json, camera.json, intrinsics.json, scene_camera.json",
        "fx, fy, cx, cy, width, height",
        "--camera",
        "open3d or BOP",
    ):
        assert part in message
    assert "\n" not in message
    np.savez(tmp_path / "b.npz", depth=np.ones((12, 16)))
    with pytest.raises(InputError, match=r"b\.npz: no camera intrinsics, expected one of b\.json"):
        read_frame(tmp_path / "b.npz")


def test_invalid_frame_files_are_rejected(tmp_path: Path) -> None:
    camera = write_intrinsics(tmp_path / "camera.json", K)
    small = write_intrinsics(tmp_path / "small.json", CameraIntrinsics(9, 9, 3, 2, 8, 6))
    whole = _write_png(tmp_path).read_bytes()
    cases: list[tuple[str, bytes, Path | None, str]] = [
        (
            "a.tiff",
            whole,
            None,
            r"a\.tiff: suffix '\.tiff' is no frame format, .*as from np\.savez\(path, depth=",
        ),
        ("a", whole, None, r"suffix '' is no frame format, expected one of \.png, \.npz, \.pcd"),
        ("a.png", whole[:-20], None, r"a\.png: the PNG file is truncated"),
        ("a.png", b"", None, r"a\.png: the file is empty"),
        ("a.png", _encoded(RAMP.astype(np.uint8)), None, "is 8-bit greyscale, expected 16-bit"),
        ("a.png", _encoded(np.ones((12, 16, 3), np.uint8)), None, "is 8-bit RGB, expected 16-bit"),
        ("a.png", _encoded(RAMP * 0), None, r"a\.png: depth is 0 everywhere"),
        ("a.png", whole, small, r"small\.json: the camera is 8x6 px but the image is 16x12 px"),
        ("a.png", whole, tmp_path / "no.json", r"no\.json: no such file"),
        ("a.npz", b"PK junk", camera, r"a\.npz: not a whole \.npz archive"),
        ("a.pcd", b"junk\n", None, r"a\.pcd: not a PCD file"),
        ("a.ply", b"junk\n", None, r"a\.ply: not a PLY file"),
    ]
    for name, data, file, message in cases:
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match=message) as caught:
            read_frame(tmp_path / name, file)
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match=r"absent\.png: no such file"):
        read_frame(tmp_path / "absent.png")


def test_cloud_is_checked_against_camera_file(tmp_path: Path) -> None:
    path, camera = write_frame(tmp_path / "a.pcd", DepthFrame(np.ones((12, 16), np.float32), K))
    write_intrinsics(camera, CameraIntrinsics(25.5, 26.25, 1.25, 5.5, 16, 12))
    with pytest.raises(InputError, match=r"a\.pcd: .*points miss their pixels by at least 6 px"):
        read_frame(path)


@settings(deadline=None, max_examples=120)
@given(
    suffix=st.sampled_from([".png", ".npz", ".pcd", ".ply"]),
    at=st.floats(0, 1, exclude_max=True),
    value=st.binary(min_size=0, max_size=3),
    keep=st.floats(0, 1),
)
def test_damaged_file_gives_frame_or_input_error(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, at: float, value: bytes, keep: float
) -> None:
    depth = (RAMP / 1000).astype(np.float32)
    path = write_frame(tmp_path_factory.mktemp("fuzz") / f"a{suffix}", DepthFrame(depth, K))[0]
    data = bytearray(path.read_bytes())
    where = int(at * len(data))
    data[where : where + 1] = value
    path.write_bytes(data[: int(keep * len(data))] if keep < 0.5 else data)
    try:
        frame = read_frame(path)
    except InputError:
        return
    assert np.isfinite(frame.depth).all()


@real_frames
def test_organised_kinect_cloud_recovers_intrinsics() -> None:
    frame = read_frame(DATA / "frames/pcl/milk_cartoon_all_small_clorox.pcd")
    k = frame.intrinsics
    np.testing.assert_allclose([k.fx, k.fy, k.cx, k.cy], [525, 525, 319.5, 239.5], atol=1e-4)
    assert np.count_nonzero(frame.valid) == 307200 - 65793
    # The floor is nearer at the bottom of the image.
    assert np.median(frame.depth[460:][frame.valid[460:]]) < 0.7
    assert np.median(frame.depth[:100][frame.valid[:100]]) > 1.0
    assert frame.colour is not None
    blue_cap = frame.colour[83, 449].astype(int)
    assert blue_cap[2] > blue_cap[0] + 50
    yellow_cap = frame.colour[160, 120].astype(int)
    assert min(yellow_cap[:2]) > yellow_cap[2] + 50


@real_frames
def test_organised_stereo_cloud_recovers_intrinsics() -> None:
    frame = read_frame(DATA / "frames/pcl/table_scene_mug_stereo_textured.pcd")
    k = frame.intrinsics
    np.testing.assert_allclose(
        [k.fx, k.fy, k.cx, k.cy], [964.36, 964.36, 319.81, 223.36], atol=0.01
    )
    assert np.count_nonzero(frame.valid) == 307200 - 97920
    # The mug stands on the table, in front of the wall.
    assert frame.depth[330, 390] < frame.depth[60, 450]


@real_frames
def test_cropped_cloud_error_suggests_fit() -> None:
    with pytest.raises(
        InputError, match=r"milk_color\.pcd: the cloud has no pixel grid .*`eyehand"
    ):
        read_frame(DATA / "frames/pcl/milk_color.pcd")


@real_frames
def test_realsense_png_reads_camera_and_colour() -> None:
    frame = read_frame(DATA / "frames/graspnet/depth.png")
    assert (frame.intrinsics.width, frame.intrinsics.height) == (1280, 720)
    assert frame.depth.max() == np.float32(1.59)
    assert frame.colour is not None
    assert frame.colour.shape == (720, 1280, 3)


@real_frames
def test_kinect_archive_reads_camera_and_unit_from_file() -> None:
    path = DATA / "mosd_learn/learn0.npz"
    raw = np.load(path)["depth"]
    frame = read_frame(path, DATA / "mosd_learn/camera.json")
    np.testing.assert_array_equal(frame.depth, (raw / 1e4).astype(np.float32))
    assert frame.intrinsics.fx == 525.0
    assert frame.colour is not None
    _assert_equal(read_frame(path), frame)


@real_frames
def test_kinect_archive_without_unit_is_rejected(tmp_path: Path) -> None:
    camera = write_intrinsics(
        tmp_path / "k.json", CameraIntrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)
    )
    with pytest.raises(InputError, match=r"learn0\.npz: depth is uint16 and its unit is not given"):
        read_frame(DATA / "mosd_learn/learn0.npz", camera)


def _encoded(image: np.ndarray) -> bytes:
    return cv2.imencode(".png", image)[1].tobytes()
