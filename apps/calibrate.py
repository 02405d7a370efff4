"""`eyehand calibrate`: hand-eye calibration from images of a board."""

from __future__ import annotations

import json as json_format
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from eyehand.errors import InputError
from eyehand.perception.cameras import (
    BoardView,
    CalibrationBoard,
    CameraMount,
    HandEye,
    HandEyeOptions,
    calibrate_hand_eye,
    charuco_board,
    checkerboard,
    detect_board,
)
from eyehand.perception.io import (
    MM_PER_M,
    decode_colour,
    naming,
    pose_from_json,
    pose_to_json,
    read_bytes,
    read_intrinsics,
    write_intrinsics,
)

from .console import print_json, say, show
from .output_files import make_folder, write_picture, write_text

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from rich.table import Table
    from scipy.spatial.transform import RigidTransform


GOOD = (0.3, 1.0, 0.1)
"""Maximum residual, px, and median pose errors, mm and °, of a good calibration. A robot with
errors of 0.5 mm and 0.06° along each axis gives 0.7 mm and 0.1°."""
PRINTED_PX_PER_M = 10_000
"""Resolution of the printed board. It is 254 dots per inch, a whole number, as some programs need;
and squares in steps of 0.1 mm are exact."""
PRINTED_MARGIN = 0.01
"""White margin of the printed board, m. The detector needs it."""


@dataclass(frozen=True)
class BoardFlags:
    """The printed board."""

    squares: tuple[int, int] = (7, 5)
    """Squares along its two sides."""
    square: float = 30.0
    """Side of a square, mm. Measure it on the print."""
    marker: float = 22.0
    """Side of a marker, mm."""
    dictionary: str = "5X5_100"
    """Dictionary of the markers, as in OpenCV: 4X4_50, 5X5_100, 6X6_250 and others."""
    checkered: Annotated[bool, Parameter(negative="")] = False
    """The board is a checkerboard without markers."""

    def board(self) -> CalibrationBoard:
        """Check the values and return the board."""
        if self.checkered:
            return checkerboard(*self.squares, self.square / MM_PER_M)
        sides = self.square / MM_PER_M, self.marker / MM_PER_M
        return charuco_board(*self.squares, *sides, self.dictionary)


def calibrate_command(
    poses: Path | None = None,
    /,
    *,
    camera: Path | None = None,
    camera_on: CameraMount = "world",
    flags: Annotated[BoardFlags | None, Parameter(name="*", group="Board")] = None,
    board: Path | None = None,
    out: Path = Path("out/calibrate"),
    json: bool = False,
) -> int:
    """Calibrate where a camera is mounted, from images of a board at 15 or more robot poses.

    The camera is fixed in the world and the wrist carries the board, or the camera is on the wrist
    and the board lies still. Tilt the wrist by 20° or more about two axes between the images. The
    command writes calibration.json, and for a camera in the world camera.json, a camera file for
    `eyehand perceive --camera`.

    Parameters
    ----------
    poses
        JSON file {"image.png": {"quat_wxyz": [w, x, y, z], "translation_m": [x, y, z]}, …} with
        the pose of the wrist in the world for each image. Images are PNG files beside it.
    camera
        Camera file with the intrinsics of the images, without distortion; default: camera.json
        beside the poses.
    camera_on
        What the camera is fixed to.
    flags
        The board.
    board
        Write the board to this PNG file for a printer (254 dpi), and stop.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    wanted = (flags or BoardFlags()).board()
    if board is not None:
        _print_board(board, wanted)
        return 0
    if poses is None:
        raise InputError("give a file of poses, or --board FILE to print a board")
    images, wrist = _read_poses(poses)
    views, size = _detect(images, wanted)
    intrinsics = read_intrinsics(camera or poses.parent / "camera.json", *size)
    found = calibrate_hand_eye(views, wrist, intrinsics, HandEyeOptions(camera_on))
    show(_table(images, views, found), json_wanted=json)
    if not found:
        reason = found.reason
        if not any(views):
            reason += _likely_board(images, flags or BoardFlags())
        if found.wrong_size:
            likely = wanted.square * found.board_scale * MM_PER_M
            reason += (
                f". A square is likely {likely:.1f} mm, not {wanted.square * MM_PER_M:g} mm: "
                "measure it, and check the focal length"
            )
        raise InputError(f"the camera's pose is not determined: {reason}")
    assert found.camera is not None
    if found.warning:
        say(f"warning: {found.warning}")
    shift, turn = np.nanmedian(found.pose_errors, axis=0) * (MM_PER_M, np.degrees(1.0))
    figures = (found.pixel_error, float(shift), float(turn))
    say(
        f"residual {figures[0]:.2f} px, median pose error {shift:.2f} mm and {turn:.2f}°; good: "
        f"at most {GOOD[0]:g} px, {GOOD[1]:g} mm and {GOOD[2]:g}°"
    )
    if any(value > good for value, good in zip(figures, GOOD, strict=True)):
        say(
            "warning: a figure is not good, and the pose may be wrong by several stated standard "
            "deviations: check the focal length, the flatness of the board, and the robot poses"
        )
    make_folder(out)
    write_text(out / "calibration.json", _report(found, camera_on))
    if camera_on == "world":
        write_intrinsics(out / "camera.json", intrinsics, T_world_camera=found.camera)
    say(
        f"T_{camera_on}_camera: standard deviation {found.position_error * MM_PER_M:.2f} mm and "
        f"{np.rad2deg(found.angle_error):.3f}°, written to {out}"
    )
    if json:
        rows = _rows(images, views, found)
        summary: dict[str, Any] = {
            "position_error_mm": found.position_error * MM_PER_M,
            "angle_error_deg": float(np.rad2deg(found.angle_error)),
            "pixel_error_px": found.pixel_error,
        }
        print_json("calibrate", None, rows, **summary, out=str(out))
    return 0


def _print_board(path: Path, board: CalibrationBoard) -> None:
    if path.suffix.lower() != ".png":
        raise InputError(f"--board must be a .png file, got {path}")
    per_square = round(board.square * PRINTED_PX_PER_M)
    margin = round(PRINTED_MARGIN * PRINTED_PX_PER_M)
    make_folder(path.parent)
    picture = board.image(per_square, margin)
    write_picture(path, picture, pixels_per_metre=round(per_square / board.square))
    say(f"board in {path}: print it at 100 %, glue it to a flat plate, and measure it")


def _read_poses(path: Path) -> tuple[list[Path], list[RigidTransform]]:
    """Read the names of the images and the poses of the wrist."""
    content = read_bytes(path)
    with naming(path):
        try:
            entries = json_format.loads(content)
        except (ValueError, RecursionError) as error:
            raise InputError(f"not a JSON file: {error}") from error
        if not isinstance(entries, dict) or not entries:
            raise InputError('must be {"image.png": {"quat_wxyz": …, "translation_m": …}, …}')
        poses = [pose_from_json(value, name) for name, value in entries.items()]
    return [path.parent / name for name in entries], poses


def _detect(images: list[Path], board: CalibrationBoard) -> tuple[list[BoardView], tuple[int, int]]:
    """Detect the board in all images. Return the views, and width and height of the images."""
    views: list[BoardView] = []
    size: tuple[int, int] | None = None
    for image in images:
        with naming(image):
            pixels: NDArray[np.uint8] = decode_colour(read_bytes(image))
            found = (pixels.shape[1], pixels.shape[0])
            if size is not None and found != size:
                raise InputError(
                    f"is {found[0]}x{found[1]} px, the first image {size[0]}x{size[1]}"
                )
            size = found
            views.append(detect_board(pixels, board))
    assert size is not None
    return views, size


def _likely_board(images: list[Path], flags: BoardFlags) -> str:
    """Return the flag of the swapped board if an image shows it; otherwise empty."""
    across, along = flags.squares
    swapped = replace(flags, squares=(along, across)).board()
    if across != along and any(_detect(images, swapped)[0]):
        return f". They show the board of --squares {along} {across}"
    return ""


def _report(found: HandEye, camera_on: CameraMount) -> str:
    assert found.camera is not None
    assert found.board is not None
    other = "wrist" if camera_on == "world" else "world"
    report = {
        f"T_{camera_on}_camera": pose_to_json(found.camera),
        f"T_{other}_board": pose_to_json(found.board),
        "position_error_m": found.position_error,
        "angle_error_rad": found.angle_error,
        "pixel_error_px": found.pixel_error,
    }
    return json_format.dumps(report, indent=1, allow_nan=False) + "\n"


def _rows(images: list[Path], views: list[BoardView], found: HandEye) -> list[dict[str, object]]:
    """Return one row per image. The corrections are None where no board was used."""
    rows = []
    for i, (image, view) in enumerate(zip(images, views, strict=True)):
        shift, turn = found.pose_errors[i]
        used = bool(np.isfinite(shift))
        rows.append(
            {
                "name": image.name,
                "corners": len(view.pixels),
                "used": used,
                "pose_error_mm": float(shift) * MM_PER_M if used else None,
                "pose_error_deg": float(np.rad2deg(turn)) if used else None,
            }
        )
    return rows


def _table(images: list[Path], views: list[BoardView], found: HandEye) -> Table:
    from rich.table import Table

    table = Table("image", "corners", "pose error, mm", "pose error, °", "", title="Calibration")
    for i, row in enumerate(_rows(images, views, found)):
        note = "contradicts the others: left out" if i in found.left_out else ""
        if not views[i]:
            note = "board not found"
        errors = [
            f"{value:.2f}" if isinstance(value := row[key], float) else "-"
            for key in ("pose_error_mm", "pose_error_deg")
        ]
        table.add_row(images[i].name, str(row["corners"]), *errors, note)
    return table
