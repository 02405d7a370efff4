"""Write and read a synthetic view and its ground truth as files in one folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import DeviceError, InputError
from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.io import (
    atomic_write,
    decode_depth,
    naming,
    number_from_json,
    numbers_from_json,
    pose_from_json,
    pose_to_json,
    read_bytes,
    write_frame,
    write_png,
)
from eyehand.perception.superquadric import Superquadric

from .fixture import BACKGROUND_LEGEND
from .furnished_scene import FurnishedScene
from .mesh_object import MeshObject
from .tabletop_scene import Family, Table, TabletopObject, TabletopScene

SCHEMA = "eyehand.ground_truth/1"
"""Name and version of the format of `ground_truth.json`."""

DEPTH_FILE = "depth.png"
LABELS_FILE = "true_labels.png"
BACKGROUND_FILE = "true_background.png"
GROUND_TRUTH_FILE = "ground_truth.json"

_UNITS = {"length": "m", "mass": "kg", "angle": "rad", "depth_png": "mm", "camera": "px"}


def write_scene(
    folder: Path | str,
    scene: TabletopScene | FurnishedScene,
    frame: DepthFrame,
    labels: NDArray[np.integer],
    background: NDArray[np.uint8] | None = None,
) -> list[Path]:
    """Write a scene's files: `depth.png`, its camera and colour, labels and ground truth.

    Parameters
    ----------
    folder : Path or str
        Folder; created if it does not exist. Existing files of these names are replaced.
    scene : TabletopScene or FurnishedScene
        The scene.
    frame : DepthFrame
        Depth image of the scene.
    labels : NDArray
        (H, W) integers, written as 16 bit: 0 background, k object k-1 of the scene.
    background : NDArray, optional
        (H, W) numbers in `BACKGROUND_LEGEND`, written to `true_background.png` as 16 bit. The
        ground truth holds the legend.

    Returns
    -------
    list of Path
        Paths of the files written.

    Raises
    ------
    InputError
        If the labels do not have the frame's size or contain a number without an object, or the
        folder cannot be created.
    DeviceError
        If the system fails to write.
    """
    folder = Path(folder)
    labels = np.asarray(labels)
    if labels.shape != frame.depth.shape or not np.issubdtype(labels.dtype, np.integer):
        raise InputError(
            f"labels must be {frame.depth.shape} integers, got {labels.shape} {labels.dtype}"
        )
    if labels.min() < 0 or labels.max() > len(scene.objects):
        raise InputError(
            f"labels must lie in 0..{len(scene.objects)}, got {labels.min()}..{labels.max()}"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError, PermissionError) as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror}") from error
    except OSError as error:
        raise DeviceError(f"cannot make the folder {folder}: {error.strerror or error}") from error
    files = write_frame(folder / DEPTH_FILE, frame)
    with atomic_write(folder / LABELS_FILE) as temporary:
        write_png(temporary, labels.astype(np.uint16))
    written = [*files, folder / LABELS_FILE, folder / GROUND_TRUTH_FILE]
    content = _scene_to_json(scene)
    if background is not None:
        content["background"] = {
            "file": BACKGROUND_FILE,
            "legend": {str(number): kind for number, kind in BACKGROUND_LEGEND.items()},
        }
        with atomic_write(folder / BACKGROUND_FILE) as temporary:
            write_png(temporary, background.astype(np.uint16))
        written.append(folder / BACKGROUND_FILE)
    text = json.dumps(content, indent=1) + "\n"
    with atomic_write(folder / GROUND_TRUTH_FILE) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return written


def read_ground_truth(path: Path | str) -> TabletopScene:
    """Read a scene from `ground_truth.json`, or from the folder that contains it.

    Raises
    ------
    InputError
        If the file is missing or does not contain a scene in this format.
    """
    path = Path(path)
    if path.is_dir():
        path = path / GROUND_TRUTH_FILE
    data = read_bytes(path)
    with naming(path):
        try:
            content = json.loads(data)
        except (ValueError, RecursionError) as error:
            raise InputError(f"not JSON ({error}), expected {SCHEMA}") from error
        schema = content.get("schema") if isinstance(content, dict) else None
        if schema != SCHEMA:
            raise InputError(f"schema is {schema!r}, expected {SCHEMA!r}")
        return _scene_from_json(content)


def read_labels(path: Path | str) -> NDArray[np.int32]:
    """Read the label image (H, W) int32 from `true_labels.png`, or from its folder.

    Raises
    ------
    InputError
        If the file is missing or is not a 16-bit greyscale PNG.
    """
    path = Path(path)
    if path.is_dir():
        path = path / LABELS_FILE
    data = read_bytes(path)
    with naming(path):
        return decode_depth(data).astype(np.int32)


def read_background(folder: Path | str) -> NDArray[np.uint8] | None:
    """Read the kinds of background (H, W) of a scene's folder; None if it has no such file.

    Raises
    ------
    InputError
        If the file is not a 16-bit greyscale PNG, or holds a number that is not in
        `BACKGROUND_LEGEND`.
    """
    path = Path(folder) / BACKGROUND_FILE
    if not path.exists():
        return None
    data = read_bytes(path)
    with naming(path):
        numbers = decode_depth(data)
        if numbers.max() > len(BACKGROUND_LEGEND):
            raise InputError(
                f"kinds of background must lie in 0..{len(BACKGROUND_LEGEND)}, got {numbers.max()}"
            )
        return numbers.astype(np.uint8)


def _scene_to_json(scene: TabletopScene | FurnishedScene) -> dict[str, Any]:
    k = scene.intrinsics
    content = {
        "schema": SCHEMA,
        "seed": scene.seed,
        "family": scene.family,
        "units": _UNITS,
        "camera": {
            "fx": float(k.fx),
            "fy": float(k.fy),
            "cx": float(k.cx),
            "cy": float(k.cy),
            "width": int(k.width),
            "height": int(k.height),
            "T_world_camera": pose_to_json(scene.T_world_camera),
        },
        "objects": [
            {"label": label, **_object_to_json(item)}
            for label, item in enumerate(scene.objects, start=1)
        ],
    }
    if isinstance(scene, TabletopScene):
        content["table"] = {
            "size_m": [float(length) for length in scene.table.size],
            "height_m": float(scene.table.height),
            "floor_drop_m": float(scene.table.floor_drop),
        }
    return content


def _object_to_json(item: TabletopObject | MeshObject) -> dict[str, Any]:
    if isinstance(item, MeshObject):
        kind, pose = "mesh", pose_to_json(item.pose)
        shape = {"size_m": np.ptp(item.vertices, axis=0).tolist()}
    else:
        kind, pose = item.kind, pose_to_json(item.shape.pose)
        shape = {
            "semi_axes_m": item.shape.semi_axes.tolist(),
            "exponents": list(item.shape.exponents),
        }
    return {
        "name": item.name,
        "kind": kind,
        **shape,
        "position_m": pose["translation_m"],
        "quat_wxyz": pose["quat_wxyz"],
        "mass_kg": float(item.mass),
        "colour_rgb": [float(share) for share in item.colour],
    }


def _scene_from_json(content: dict[str, Any]) -> TabletopScene:
    family = _entry(content, "family", str)
    if family not in get_args(Family):
        raise InputError(f"family must be one of {', '.join(get_args(Family))}, got {family!r}")
    table, camera = _entry(content, "table", dict), _entry(content, "camera", dict)
    lens = [number_from_json(camera.get(key), f"camera.{key}") for key in ("fx", "fy", "cx", "cy")]
    size_xy = numbers_from_json(table.get("size_m"), 2, "table.size_m")
    return TabletopScene(
        seed=_entry(content, "seed", int),
        family=family,
        objects=tuple(_object_from_json(entry) for entry in _entry(content, "objects", list)),
        table=Table(
            (float(size_xy[0]), float(size_xy[1])),
            number_from_json(table.get("height_m"), "table.height_m"),
            number_from_json(table.get("floor_drop_m"), "table.floor_drop_m"),
        ),
        intrinsics=CameraIntrinsics(
            *lens, width=_entry(camera, "width", int), height=_entry(camera, "height", int)
        ),
        T_world_camera=pose_from_json(camera.get("T_world_camera"), "camera.T_world_camera"),
    )


def _object_from_json(entry: Any) -> TabletopObject:
    if not isinstance(entry, dict):
        raise InputError(f"objects must hold JSON objects, got {type(entry).__name__}")
    name = _entry(entry, "name", str)
    pose = {"quat_wxyz": entry.get("quat_wxyz"), "translation_m": entry.get("position_m")}
    exponents = numbers_from_json(entry.get("exponents"), 2, f"{name}.exponents")
    colour = numbers_from_json(entry.get("colour_rgb"), 3, f"{name}.colour_rgb")
    kind: Any = _entry(entry, "kind", str)
    with naming(name):
        shape = Superquadric(
            numbers_from_json(entry.get("semi_axes_m"), 3, "semi_axes_m"),
            (float(exponents[0]), float(exponents[1])),
            pose_from_json(pose, "pose"),
            kind,
        )
        mass = number_from_json(entry.get("mass_kg"), "mass_kg")
    return TabletopObject(name, shape, mass, (float(colour[0]), float(colour[1]), float(colour[2])))


def _entry(content: dict[str, Any], key: str, kind: type) -> Any:
    value = content.get(key)
    if not isinstance(value, kind) or isinstance(value, bool):
        raise InputError(f"{key} must be a JSON {kind.__name__}, got {value!r}")
    return value
