"""Reading and writing of depth frames: PNG with a camera file, NPZ, organised PCD and PLY."""

from __future__ import annotations

import logging
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..frame import DepthFrame
from .atomic_write import atomic_write
from .depth_units import metres_from_units, millimetres_from_metres
from .frame_npz import read_npz_frame, write_npz_frame
from .input_file import is_file, naming, read_bytes
from .intrinsics import (
    CAMERA_FORM,
    CAMERA_NAMES,
    CameraFile,
    camera_json,
    find_camera_file,
    read_camera_file,
)
from .organised_cloud import cloud_from_frame, frame_from_cloud, has_grid
from .pcd import pcd_bytes, read_pcd
from .ply import ply_bytes, read_ply
from .png import decode_colour, decode_depth, write_png

_log = logging.getLogger("eyehand")

FRAME_SUFFIXES = (".png", ".npz", ".pcd", ".ply")
"""File formats of depth frames."""

PNG_DEPTH_SCALE_MM = 1.0
"""Unit of 16-bit PNG files whose camera file names none: the millimetre of OpenNI, ROS and BOP."""


def read_frame(path: Path | str, camera: Path | str | None = None) -> DepthFrame:
    """Read a depth frame. The suffix defines the format.

    ``.png``: 16-bit greyscale, in mm unless the camera file defines another unit. A camera file is
    required (see `read_intrinsics`). A colour image of the same size in the same folder is
    optional: `<stem>_colour.png`, `<stem>_color.png`, `colour.png` or `color.png`.
    ``.npz``: `depth` in float metres, or integer with `depth_scale_m`; `intrinsics` (fx, fy, cx,
    cy) or `K`; optional `colour`, `color` or `rgb`, and `T_world_camera` (4, 4).
    ``.pcd``, ``.ply``: one point per pixel in the camera's optical frame, NaN = no reading; the
    intrinsics are computed from the points unless `<stem>.json` or `camera` defines them.

    Parameters
    ----------
    path : Path or str
        The file.
    camera : Path or str, optional
        Camera file. It has priority over a camera in the frame's file or folder. If None,
        `<stem>.json`, `camera.json`, `intrinsics.json` and `scene_camera.json` in the file's folder
        are tried.

    Raises
    ------
    InputError
        If the file cannot be used. The message contains the reason and the expected value.
    """
    path = Path(path)
    camera = None if camera is None else Path(camera)
    suffix = _checked_suffix(path)
    if suffix == ".png":
        return _read_png_frame(path, camera)
    if suffix == ".npz":
        return read_npz_frame(path, camera, _camera_beside)
    return _read_cloud_frame(path, camera)


def write_frame(path: Path | str, frame: DepthFrame) -> list[Path]:
    """Write a frame so that `read_frame` can read it. The suffix chooses the format.

    ``.npz`` loses nothing. ``.png`` rounds depth to whole millimetres, and puts the camera in
    `<stem>.json` and colour in `<stem>_colour.png`. ``.pcd`` and ``.ply`` hold float32
    coordinates, NaN = no reading, and put the camera in `<stem>.json` too.

    Parameters
    ----------
    path : Path or str
        The file, replaced if it exists.
    frame : DepthFrame
        The frame to write.

    Returns
    -------
    list of Path
        The files written, `path` first.

    Raises
    ------
    InputError
        If the suffix is unknown, the folder is missing, or depth does not fit a PNG in mm.
    DeviceError
        If the system fails to write.
    """
    path = Path(path)
    suffix = _checked_suffix(path)
    files = [path]
    with ExitStack() as stack, naming(path):
        target = stack.enter_context(atomic_write(path))
        if suffix == ".npz":
            write_npz_frame(target, frame)
            return files
        camera = CameraFile(frame.intrinsics, None, frame.T_world_camera)
        if suffix == ".png":
            write_png(target, millimetres_from_metres(frame.depth))
            colour_path = path.with_name(f"{path.stem}_colour.png")
            if frame.colour is not None:
                write_png(stack.enter_context(atomic_write(colour_path)), frame.colour)
                files.append(colour_path)
            # With colour null, the reader ignores an older colour image beside the file.
            colour_name = "" if frame.colour is None else colour_path.name
            camera = CameraFile(
                frame.intrinsics, PNG_DEPTH_SCALE_MM, frame.T_world_camera, colour_name
            )
        else:
            encode = pcd_bytes if suffix == ".pcd" else ply_bytes
            target.write_bytes(encode(cloud_from_frame(frame)))
        camera_path = path.with_suffix(".json")
        beside = stack.enter_context(atomic_write(camera_path))
        beside.write_text(camera_json(camera), encoding="utf-8")
        files.insert(1, camera_path)
    return files


def _checked_suffix(path: Path) -> str:
    suffix = path.suffix.lower()
    if suffix not in FRAME_SUFFIXES:
        raise InputError(
            f"{path}: suffix {path.suffix!r} is no frame format, expected one of "
            f"{', '.join(FRAME_SUFFIXES)} (.npz with `depth` and `K`, as from "
            "np.savez(path, depth=depth_m, K=K))"
        )
    return suffix


def _read_png_frame(path: Path, camera: Path | None) -> DepthFrame:
    data = read_bytes(path)
    with naming(path):
        raw = decode_depth(data)
    height, width = raw.shape
    camera = camera or _camera_beside(path)
    contents = read_camera_file(camera, width, height, path.stem)
    # The camera file of another image may name the colour of that image.
    own = {path.with_name(name).resolve() for name in (f"{path.stem}.json", CAMERA_NAMES[0])}
    name = contents.colour_name if camera.resolve() in own else None
    colour = _colour_beside(path, raw.shape, name)
    with naming(path):
        depth = metres_from_units(raw, contents.depth_scale_mm or PNG_DEPTH_SCALE_MM)
        return DepthFrame(depth, contents.intrinsics, contents.T_world_camera, colour)


def _read_cloud_frame(path: Path, camera: Path | None) -> DepthFrame:
    table = read_pcd(path) if path.suffix.lower() == ".pcd" else read_ply(path)
    own_file = path.with_suffix(".json")
    if camera is None and is_file(own_file):
        camera = own_file
    contents = None
    if camera is not None:
        size = (table.width, table.height) if has_grid(table) else (0, 0)
        contents = read_camera_file(camera, *size, path.stem)
    with naming(path):
        return frame_from_cloud(table, contents)


def _camera_beside(path: Path) -> Path:
    camera = find_camera_file(path)
    if camera is None:
        names = ", ".join((f"{path.stem}.json", *CAMERA_NAMES))
        raise InputError(
            f"{path}: no camera intrinsics, expected one of {names} beside it, or a camera file "
            f"that --camera (in Python camera=) names, with {CAMERA_FORM}, or the form of "
            "open3d or BOP"
        )
    return camera


def _colour_beside(
    path: Path, shape: tuple[int, ...], declared: str | None
) -> NDArray[np.uint8] | None:
    if declared is not None:
        if not declared:
            return None
        named = path.with_name(declared)
        if not is_file(named):
            raise InputError(f"{named}: no such file, but `colour` of the camera file names it")
        data = read_bytes(named)
        with naming(named):
            colour = decode_colour(data)
            if colour.shape[:2] != shape:
                raise InputError(
                    f"the colour image is {colour.shape[1]}x{colour.shape[0]} px, expected "
                    f"{shape[1]}x{shape[0]} px as {path.name}"
                )
        return colour
    stem = path.stem
    for name in (f"{stem}_colour.png", f"{stem}_color.png", "colour.png", "color.png"):
        candidate = path.with_name(name)
        if candidate == path or not is_file(candidate):
            continue
        data = read_bytes(candidate)
        with naming(candidate):
            colour = decode_colour(data)
        if colour.shape[:2] == shape:
            return colour
        _log.warning(
            "%s is ignored: it has %dx%d px and the depth image %dx%d px",
            candidate,
            *colour.shape[1::-1],
            *shape[::-1],
        )
    return None
