"""Camera files: intrinsics, depth unit and camera pose of a depth image."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from ..frame import CameraIntrinsics, check_image_size
from .atomic_write import atomic_write
from .input_file import is_file, naming, read_bytes
from .misspelt_keys import refuse_distortion, refuse_misspelt_keys
from .pose_json import number_from_json, numbers_from_json, pose_from_json, pose_to_json

CAMERA_NAMES = ("camera.json", "intrinsics.json", "scene_camera.json")
"""Camera files that apply to a whole folder. They are tried after `<stem>.json`, in this order."""

CAMERA_FORM = "{fx, fy, cx, cy, width, height[, depth_scale_mm, T_world_camera]}"
"""The form of eyehand."""
CAMERA_FORMS = (
    CAMERA_FORM + ", open3d's {width, height, intrinsic_matrix: 9 column-major}, "
    "{width, height, K: 9 row-major or 3 rows}, "
    "or BOP's {cam_K: 9 row-major, depth_scale} alone or keyed by image number"
)
"""The accepted JSON forms, as error messages list them."""
OPTIONAL_KEYS = ("depth_scale_mm", "T_world_camera", "colour", "color")
"""Optional keys of a camera file. A misspelt one must not count as missing."""


@dataclass(frozen=True)
class CameraFile:
    """Contents of a camera file for one image."""

    intrinsics: CameraIntrinsics
    """The pinhole camera."""
    depth_scale_mm: float | None = None
    """Millimetres per unit of an integer depth image; None when the file has no entry."""
    T_world_camera: RigidTransform | None = None
    """Maps camera coordinates to world coordinates; None when the file has no entry."""
    colour_name: str | None = None
    """Name of the colour image in the same folder; empty when the file says that there is none,
    None when it does not say."""


def read_intrinsics(path: Path | str, width: int, height: int) -> CameraIntrinsics:
    """Read camera intrinsics from a JSON file, for images of `width` x `height` px.

    Forms: ``{fx, fy, cx, cy, width, height}``; open3d's ``{width, height, intrinsic_matrix}``
    with nine values column by column; ``{width, height, K}`` with nine values row by row, or
    three rows; BOP's ``{cam_K, depth_scale}`` with nine values row by row, alone or as the only
    entry of a ``scene_camera.json``. A matrix whose last row is not 0, 0, 1 under the order that
    its key stands for is refused: it was written the other way round.

    Parameters
    ----------
    path : Path or str
        The JSON file.
    width, height : int
        Size of the images, px.

    Raises
    ------
    InputError
        If the file is missing, not JSON, of no known form, for another image size, its values
        make no pinhole camera, or a key is misspelt.
    """
    return read_camera_file(path, width, height).intrinsics


def write_intrinsics(
    path: Path | str,
    intrinsics: CameraIntrinsics,
    *,
    depth_scale_mm: float | None = None,
    T_world_camera: RigidTransform | None = None,
) -> Path:
    """Write a camera file. `read_intrinsics` and `read_frame` read it back exactly.

    Parameters
    ----------
    path : Path or str
        The JSON file, replaced if it exists.
    intrinsics : CameraIntrinsics
        The camera.
    depth_scale_mm : float, optional
        Millimetres per unit of the integer depth images that the file goes with.
    T_world_camera : RigidTransform, optional
        Pose of the camera, written as `quat_wxyz` and `translation_m`.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.
    """
    path = Path(path)
    text = camera_json(CameraFile(intrinsics, depth_scale_mm, T_world_camera))
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def read_camera_file(path: Path | str, width: int, height: int, stem: str = "") -> CameraFile:
    """Read the whole content of a camera file for one image of `width` x `height` px.

    If both are 0, the size is that of the file, which must have it. `stem` is the image's file
    name without suffix: the number in it picks the entry of a ``scene_camera.json``. Raises as
    `read_intrinsics`.
    """
    data = read_bytes(path)
    with naming(path):
        try:
            content = json.loads(data)
        except (ValueError, RecursionError) as error:
            raise InputError(f"not JSON ({error}), expected {CAMERA_FORMS}") from error
        if not isinstance(content, dict):
            raise InputError(f"holds a JSON {type(content).__name__}, expected {CAMERA_FORMS}")
        return _camera_from_json(content, width, height, stem)


def find_camera_file(image: Path) -> Path | None:
    """Find the camera file beside an image: `<stem>.json`, else the first of `CAMERA_NAMES`."""
    for name in (f"{image.stem}.json", *CAMERA_NAMES):
        candidate = image.with_name(name)
        if is_file(candidate):
            return candidate
    return None


def camera_json(camera: CameraFile) -> str:
    """Return the text of a camera file in the flat form of eyehand."""
    k = camera.intrinsics
    content: dict[str, Any] = {
        "width": int(k.width),
        "height": int(k.height),
        "fx": float(k.fx),
        "fy": float(k.fy),
        "cx": float(k.cx),
        "cy": float(k.cy),
    }
    if camera.depth_scale_mm is not None:
        content["depth_scale_mm"] = float(camera.depth_scale_mm)
    if camera.T_world_camera is not None:
        content["T_world_camera"] = pose_to_json(camera.T_world_camera)
    if camera.colour_name is not None:
        content["colour"] = camera.colour_name or None
    return json.dumps(content, indent=1) + "\n"


def intrinsics_from_matrix(K: NDArray, width: int, height: int, name: str) -> CameraIntrinsics:
    """Convert a camera matrix (3, 3), row-major, to a pinhole camera.

    Raises
    ------
    InputError
        If the matrix is not ((fx, 0, cx), (0, fy, cy), (0, 0, 1)). `name` says which it is and in
        which order its values were taken.
    """
    if K.shape != (3, 3) or K.dtype.kind not in "fiu":
        raise InputError(f"{name} must be a (3, 3) number matrix, got {K.shape} {K.dtype}")
    K = K.astype(np.float64)
    if not np.array_equal(K[2], [0.0, 0.0, 1.0]):
        raise InputError(
            f"{name}: the matrix has last row {K[2].tolist()}, expected [0, 0, 1]; "
            "check whether its values go row by row or column by column"
        )
    if K[0, 1] != 0 or K[1, 0] != 0:
        raise InputError(
            f"{name}: the matrix has skew {K[0, 1]:g} and {K[1, 0]:g}, expected 0 and 0"
        )
    fx, fy, cx, cy = (float(x) for x in (K[0, 0], K[1, 1], K[0, 2], K[1, 2]))
    return CameraIntrinsics(fx, fy, cx, cy, width, height)


def _camera_from_json(content: dict[str, Any], width: int, height: int, stem: str) -> CameraFile:
    if "intrinsic_matrix" in content:
        width, height = _image_size(content, width, height)
        values = numbers_from_json(content["intrinsic_matrix"], 9, "intrinsic_matrix")
        K = values.reshape(3, 3).T
        intrinsics = intrinsics_from_matrix(K, width, height, "intrinsic_matrix (column-major)")
    elif keys := [key for key in ("cam_K", "K", "k") if key in content]:
        width, height = _image_size(content, width, height, required=keys[0] != "cam_K")
        K = numbers_from_json(_joined(content[keys[0]]), 9, keys[0]).reshape(3, 3)
        intrinsics = intrinsics_from_matrix(K, width, height, f"{keys[0]} (row-major)")
    elif content.keys() & {"fx", "fy", "cx", "cy"}:
        width, height = _image_size(content, width, height)
        missing = [key for key in ("fx", "fy", "cx", "cy") if key not in content]
        if missing:
            raise InputError(f"lacks {', '.join(missing)}, expected {CAMERA_FORMS}")
        fx, fy, cx, cy = (number_from_json(content[key], key) for key in ("fx", "fy", "cx", "cy"))
        intrinsics = CameraIntrinsics(fx, fy, cx, cy, width, height)
    elif content and all(isinstance(v, dict) and "cam_K" in v for v in content.values()):
        return _camera_from_json(_entry_of_image(content, stem), width, height, stem)
    else:
        keys = ", ".join(list(content)[:8]) or "no keys"
        raise InputError(f"has {keys}, expected {CAMERA_FORMS}")
    # BOP's depth_scale resembles depth_scale_mm, and is no error.
    refuse_misspelt_keys(content.keys() - {"depth_scale"}, OPTIONAL_KEYS)
    refuse_distortion(content)
    return CameraFile(
        intrinsics, _depth_scale_mm(content), _world_pose(content), _colour_name(content)
    )


def _joined(rows: Any) -> Any:
    """Return the rows of a matrix one after the other; other values unchanged."""
    nested = isinstance(rows, list) and all(isinstance(row, list) for row in rows)
    return [value for row in rows for value in row] if nested else rows


def _image_size(
    content: dict[str, Any], width: int, height: int, *, required: bool = True
) -> tuple[int, int]:
    missing = [key for key in ("width", "height") if key not in content]
    if missing:
        if required or not width:
            raise InputError(f"lacks {', '.join(missing)}, expected {CAMERA_FORMS}")
        return width, height
    size = tuple(number_from_json(content[key], key) for key in ("width", "height"))
    if not width:
        width, height = map(int, size)
        check_image_size(width, height)
    if size != (width, height):
        raise InputError(
            f"the camera is {size[0]:g}x{size[1]:g} px but the image is {width}x{height} px: "
            "give the intrinsics of this image size"
        )
    return width, height


def _entry_of_image(content: dict[str, Any], stem: str) -> dict[str, Any]:
    by_number = {int(key): entry for key, entry in content.items() if re.fullmatch(r"\d+", key)}
    in_stem = {int(digits) for digits in re.findall(r"\d+", stem)}
    matches = [by_number[number] for number in sorted(in_stem & by_number.keys())]
    if len(matches) == 1:
        return matches[0]
    if not in_stem and len(content) == 1:
        return next(iter(content.values()))
    keys = list(content)
    shown = ", ".join(keys[:5]) + (", …" if len(keys) > 5 else "")
    raise InputError(
        f"holds {len(keys)} images ({shown}) and {len(matches)} of them fit the file name "
        f"{stem!r}: expected exactly one image number in the name, or a file with one camera"
    )


def _depth_scale_mm(content: dict[str, Any]) -> float | None:
    # BOP uses the key depth_scale, also in its flat camera.json.
    for key in ("depth_scale_mm", "depth_scale"):
        if key in content:
            scale = number_from_json(content[key], key)
            if scale <= 0:
                raise InputError(f"{key} must be > 0 mm per unit, got {scale:g}")
            return scale
    return None


def _world_pose(content: dict[str, Any]) -> RigidTransform | None:
    # cam_R_w2c of BOP is ignored: BOP does not define which axis of its world is up.
    value = content.get("T_world_camera")
    return None if value is None else pose_from_json(value, "T_world_camera")


def _colour_name(content: dict[str, Any]) -> str | None:
    keys = [key for key in ("colour", "color") if key in content]
    if not keys:
        return None
    name = content[keys[0]]
    if name is None:
        return ""
    if not isinstance(name, str) or Path(name).name != name:
        raise InputError(f"{keys[0]} must be a file name in the same folder or null, got {name!r}")
    return name
