"""`eyehand calibrate` finds the camera in rendered images, and refuses what it cannot use."""

import json
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.main import main
from eyehand.perception import CameraIntrinsics
from eyehand.perception.cameras import charuco_board
from eyehand.perception.io import pose_from_json, pose_to_json, read_camera_file, write_intrinsics
from eyehand.perception.io.png import check_png

from ..file_schema import check_file

CAMERA = CameraIntrinsics(600.0, 600.0, 319.5, 239.5, 640, 480)
BOARD = charuco_board(7, 5, 0.03, 0.022)
T_WORLD_CAMERA = RigidTransform.from_components(
    [1.0, 0.0, 0.8], Rotation.from_euler("xyz", [-130.0, 0.0, 90.0], degrees=True)
)


def run(*words) -> int:
    with pytest.raises(SystemExit) as exit_info:
        main(["calibrate", *map(str, words)])
    assert isinstance(exit_info.value.code, int)
    return exit_info.value.code


def rendered(T_camera_board: RigidTransform) -> np.ndarray:
    """Draw the board as the camera sees it."""
    drawn = BOARD.image(60, 40)
    corners = np.array([[0, 0], [7, 0], [7, 5], [0, 5]], dtype=float)
    x, y, z = T_camera_board.apply(np.column_stack([corners * BOARD.square, np.zeros(4)])).T
    target = np.column_stack([600.0 * x / z + 319.5, 600.0 * y / z + 239.5])
    warp = cv2.getPerspectiveTransform(
        (corners * 60 + 39.5).astype(np.float32), (4 * target + 1.5).astype(np.float32)
    )
    large = cv2.warpPerspective(drawn, warp, (2560, 1920), borderValue=(110,))
    return cv2.resize(large, (640, 480), interpolation=cv2.INTER_AREA)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return a folder with 10 images of a board on the wrist, their poses, and a camera file."""
    path = tmp_path_factory.mktemp("calibrate")
    rng = np.random.default_rng(1)
    wrist_board = RigidTransform.from_components(
        [0.02, 0.0, 0.1], Rotation.from_rotvec([0, 0, 0.5])
    )
    middle = RigidTransform.from_translation([-0.105, -0.075, 0.0])
    poses = {}
    for number in range(10):
        T_camera_board = (
            RigidTransform.from_components(
                rng.uniform([-0.05, -0.04, 0.4], [0.05, 0.04, 0.5]),
                Rotation.from_rotvec(rng.uniform(-0.5, 0.5, 3)),
            )
            * middle
        )
        name = f"{number:02d}.png"
        cv2.imwrite(str(path / name), rendered(T_camera_board))
        poses[name] = pose_to_json(T_WORLD_CAMERA * T_camera_board * wrist_board.inv())
    (path / "poses.json").write_text(json.dumps(poses))
    write_intrinsics(path / "camera.json", CAMERA)
    return path


def test_rendered_images_give_the_pose_within_its_stated_error(folder, tmp_path, capsys):
    assert run(folder / "poses.json", "--out", tmp_path / "out", "--json") == 0
    said = capsys.readouterr()
    assert "good: at most 0.3 px, 1 mm and 0.1°" in said.err
    assert "warning" not in said.err
    report = json.loads(said.out)
    assert report["schema"] == "eyehand.calibrate/1"
    assert all(row["used"] for row in report["rows"])
    check_file(folder / "poses.json", "poses")
    check_file(tmp_path / "out" / "calibration.json", "calibration")
    check_file(tmp_path / "out" / "camera.json", "camera")
    written = json.loads((tmp_path / "out" / "calibration.json").read_text())
    error = T_WORLD_CAMERA.inv() * pose_from_json(written["T_world_camera"], "pose")
    assert np.linalg.norm(error.translation) < 1e-3
    assert error.rotation.magnitude() < np.deg2rad(0.1)
    assert np.linalg.norm(error.translation) < 4 * written["position_error_m"]
    camera = read_camera_file(tmp_path / "out" / "camera.json", 640, 480)
    assert camera.T_world_camera is not None


@pytest.mark.parametrize(
    ("square", "pixels", "resolution"),
    [(30, 300, 10_000), (12.5, 125, 10_000), (29.97, 300, 10_010)],
)
def test_board_is_written_for_a_printer(tmp_path, square, pixels, resolution):
    """At the resolution in the file, the squares have the size that was asked for."""
    path = tmp_path / "board.png"
    assert run("--board", path, "--square", square, "--marker", 0.7 * square) == 0
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    assert image is not None
    assert image.shape == (5 * pixels + 200, 7 * pixels + 200)
    data = path.read_bytes()
    check_png(data)
    assert struct.unpack_from(">IIB", data, data.index(b"pHYs") + 4) == (resolution, resolution, 1)
    assert 1e3 * pixels / resolution == pytest.approx(square, rel=5e-5)


def test_images_of_another_board_are_refused_without_files(folder, tmp_path, capsys):
    words = [folder / "poses.json", "--out", tmp_path / "out"]
    for flags, advice in (
        (["--dictionary", "4X4_50"], "check the number and order of the squares, and the dict"),
        (["--squares", 5, 7], "They show the board of --squares 7 5"),
    ):
        assert run(*words, *flags) == 2
        said = capsys.readouterr().err
        assert "the board is visible in 0 of 10 images" in said
        assert advice in said
    assert not (tmp_path / "out").exists()


def refusal(folder, tmp_path, capsys, *words) -> str:
    """Return the line of a calibration that must end without files."""
    assert run(*words, "--camera", folder / "camera.json", "--out", tmp_path / "out") == 2
    assert not (tmp_path / "out").exists()
    return capsys.readouterr().err.strip().splitlines()[-1]


def test_forgotten_mount_is_refused_without_files(folder, tmp_path, capsys):
    error = refusal(folder, tmp_path, capsys, folder / "poses.json", "--camera-on", "wrist")
    assert "the images do not fit the robot poses: residual" in error
    assert "the order of the quaternion (w, x, y, z), the direction of the poses" in error
    assert "They fit with --camera-on world, or with inverted poses" in error


def test_wrong_square_is_refused_with_the_likely_one(folder, tmp_path, capsys):
    words = [folder / "poses.json", "--square", "25", "--marker", "18"]
    error = refusal(folder, tmp_path, capsys, *words)
    assert "A square is likely 30.0 mm, not 25 mm" in error


def test_poses_in_millimetres_are_refused_without_files(folder, tmp_path, capsys):
    poses = json.loads((folder / "poses.json").read_text())
    for name, pose in poses.items():
        pose["translation_m"] = [1e3 * value for value in pose["translation_m"]]
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "poses.json").write_text(json.dumps(poses))
    assert "in mm" in refusal(folder, tmp_path, capsys, tmp_path / "poses.json")


def test_inaccurate_robot_is_warned_about(folder, tmp_path, capsys):
    poses, rng = json.loads((folder / "poses.json").read_text()), np.random.default_rng(0)
    for name, pose in poses.items():
        pose["translation_m"] = (pose["translation_m"] + rng.normal(0.0, 2e-3, 3)).tolist()
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "poses.json").write_text(json.dumps(poses))
    words = ["--camera", folder / "camera.json", "--out", tmp_path / "out"]
    assert run(tmp_path / "poses.json", *words) == 0
    assert "warning: a figure is not good" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[]", "image.png"),
        ("{", "not a JSON file"),
        ('{"00.png": 3}', "00.png must be"),
        ('{"missing.png": {"quat_wxyz": [1, 0, 0, 0], "translation_m": [0, 0, 0]}}', "missing.png"),
    ],
)
def test_bad_poses_are_named_in_one_line(content, message, tmp_path, capsys):
    (tmp_path / "poses.json").write_text(content)
    assert run(tmp_path / "poses.json") == 2
    error = capsys.readouterr().err
    assert message in error
    assert len(error.strip().splitlines()) == 1


def test_missing_poses_are_named_as_such(tmp_path, capsys):
    assert run(tmp_path / "poses.json") == 2
    assert capsys.readouterr().err == f"eyehand: {tmp_path / 'poses.json'}: no such file\n"


def test_command_without_input_names_what_it_needs(capsys):
    assert run() == 2
    assert "--board" in capsys.readouterr().err
