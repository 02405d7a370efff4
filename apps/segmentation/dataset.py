"""Read folders of labelled depth frames: `.npz` archives and output of `eyehand synth`."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth import read_labels
from eyehand.data_synth.scenes import DEPTH_FILE, LABELS_FILE, MIN_VISIBLE_SHARE, read_background
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, read_frame
from eyehand.perception.io import (
    MM_PER_M,
    CameraFile,
    find_camera_file,
    intrinsics_from_matrix,
    metres_from_units,
    naming,
    read_arrays,
    read_camera_file,
)

from .osd import looks_like_osd, osd_group, osd_objects

Coding = Literal["plain", "osd"]
"""Coding of a label image, see :class:`DatasetOptions`."""

KINECT = CameraIntrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)
"""Intrinsics of the first Kinect in OpenNI: the camera of most published 640x480 frames."""
PLAUSIBLE_M = (0.2, 5.0)
"""Range of the median depth of a tabletop frame, m. Outside it the depth unit is wrong."""
COMMON_UNITS_MM = (1.0, 0.25, 0.2, 0.1)
"""Units of integer depth in cameras and data sets, mm."""

_ARRAYS = ("depth", "label", "rgb", "colour", "intrinsics", "K", "depth_scale_m")


@dataclass(frozen=True)
class DatasetOptions:
    """Options for reading the files of a data set.

    Raises
    ------
    InputError
        If the depth unit is not positive.
    """

    camera: Path | None = None
    """Camera file of all .npz frames. Default: the camera in the archive or in a camera file beside
    it, else the first Kinect at 640x480."""
    depth_scale_mm: float | None = None
    """Millimetres per unit of integer depth in .npz files. Default: the unit in the archive or in
    the camera file."""
    labels: Coding = "plain"
    """``plain``: 0 is no object, every other label is one object. ``osd``: labels 0 to 19 are no
    object, else the object is label // 10 and the last digit is its part."""

    def __post_init__(self) -> None:
        scale = self.depth_scale_mm
        if scale is not None and not 0 < scale < np.inf:
            raise InputError(f"--depth-scale-mm must be > 0 mm per unit, got {scale}")


@dataclass(frozen=True)
class LabelledFrame:
    """A depth frame with its true objects."""

    frame: DepthFrame
    """The depth frame."""
    truth: NDArray[np.int32]
    """(H, W) int32: 0 = no object."""
    background: NDArray[np.uint8] | None = None
    """(H, W): number in `BACKGROUND_LEGEND` of what pixels without object show; None if unknown."""
    ignored: NDArray[np.bool_] | None = None
    """(H, W): pixels that are not scored, such as slivers of hidden objects; None = all are."""
    assumed: tuple[str, ...] = ()
    """Assumptions made when reading the frame, in words."""

    def unscored(self, *, ignore_invalid: bool = True) -> NDArray[np.bool_]:
        """Return a mask (H, W) of the pixels to leave out of truth and prediction.

        Parameters
        ----------
        ignore_invalid
            Leave out the pixels without a reading too.
        """
        left_out = np.zeros(self.truth.shape, bool) if self.ignored is None else self.ignored
        return left_out | ~self.frame.valid if ignore_invalid else left_out


@dataclass(frozen=True)
class FrameSource:
    """A labelled frame that is loaded on demand."""

    name: str
    """Name, unique in the data set."""
    group: str
    """Group of the frame; ``/`` separates the parts of its name."""
    load: Callable[[], LabelledFrame]
    """Read or render the frame. Every call returns the same frame."""


def open_dataset(folder: Path, options: DatasetOptions | None = None) -> list[FrameSource]:
    """List the labelled frames of a folder and its subfolders, sorted by name.

    A frame is an `.npz` archive or a folder from `eyehand synth`. An archive holds `depth`
    (integers, or floats in metres) and `label`. Optional arrays are `rgb` or `colour`, `intrinsics`
    or `K`, and `depth_scale_m`. The group of a frame is its folder. With `labels` ``osd``, file
    names give the groups of the Object Segmentation Database.

    Raises
    ------
    InputError
        If the folder does not exist or holds no frame. An invalid frame raises when it is loaded.
    """
    options = options or DatasetOptions()
    if not folder.is_dir():
        raise InputError(
            f"--dataset {folder}: no such folder, expected one with .npz files or "
            "folders of eyehand synth, or the word synthetic"
        )
    archives = sorted(folder.rglob("*.npz"), key=_by_number)
    rendered = sorted((path.parent for path in folder.rglob(LABELS_FILE)), key=_by_number)
    if not archives and not rendered:
        raise InputError(
            f"--dataset {folder}: holds neither .npz files nor folders with {LABELS_FILE}"
        )
    if rendered and options.depth_scale_mm is not None:
        raise InputError(
            f"--depth-scale-mm is for .npz files, but {rendered[0]} states its own unit"
        )
    sources = []
    for path in archives:
        group = _folder_name(path.parent, folder)
        kind = osd_group(path.stem) if options.labels == "osd" else None
        if kind is not None:
            group = kind if path.parent == folder else f"{group}/{kind}"
        name = path.relative_to(folder).with_suffix("").as_posix()
        sources.append(FrameSource(name, group, partial(read_labelled_npz, path, options)))
    for path in rendered:
        group = _folder_name(path if path == folder else path.parent, folder)
        name = path.name if path == folder else path.relative_to(folder).as_posix()
        sources.append(FrameSource(name, group, partial(_read_rendered, path, options)))
    return sources


def read_labelled_npz(path: Path, options: DatasetOptions) -> LabelledFrame:
    """Read one archive with `depth` and `label`.

    Raises
    ------
    InputError
        If the file is damaged or lacks an array, the camera or the depth unit is unknown, or the
        median depth is implausible for a tabletop scene.
    """
    arrays = read_arrays(path, _ARRAYS)
    with naming(path):
        for name in ("depth", "label"):
            if name not in arrays:
                raise InputError(f"holds {', '.join(arrays)}, expected an array `{name}`")
        depth, label = arrays["depth"], arrays["label"]
        if depth.ndim != 2 or not depth.size or depth.dtype.kind not in "fiu":
            raise InputError(f"depth is {depth.shape} {depth.dtype}, expected (H, W) numbers")
        camera, assumed = _camera(arrays, path, options)
        metres = _metres(arrays, camera, options)
        colour = arrays.get("colour", arrays.get("rgb"))
        frame = DepthFrame(metres, camera.intrinsics, camera.T_world_camera, colour)
        _check_plausible(frame, arrays["depth"])
        truth = decode_labels(label, depth.shape, options.labels)
    if options.labels == "plain" and looks_like_osd(label):
        assumed += ("labels are read as plain numbers but look like osd labels: try --labels osd",)
    return LabelledFrame(frame, truth, assumed=assumed)


def decode_labels(
    label: NDArray[np.integer], shape: tuple[int, ...], coding: Coding
) -> NDArray[np.int32]:
    """Decode a label image of `shape` into objects, (H, W) int32, 0 = none.

    Raises
    ------
    InputError
        If the labels have another shape, or are not integers >= 0.
    """
    if label.shape != shape or label.dtype.kind not in "iub":
        raise InputError(f"label is {label.shape} {label.dtype}, expected {shape} integers")
    numbers = label.astype(np.int64)
    if numbers.min() < 0 or numbers.max() > np.iinfo(np.int32).max:
        raise InputError(f"labels lie in {numbers.min()}..{numbers.max()}, expected 0 .. 2^31 - 1")
    if coding == "osd":
        numbers = osd_objects(numbers)
    return numbers.astype(np.int32)


def slivers(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return a mask (H, W) of the objects that others hide but for a few pixels."""
    counts = np.bincount(labels.ravel())
    hidden = counts < MIN_VISIBLE_SHARE * labels.size
    hidden[0] = False
    return hidden[labels]


def _read_rendered(folder: Path, options: DatasetOptions) -> LabelledFrame:
    frame = read_frame(folder / DEPTH_FILE, options.camera)
    with naming(folder / LABELS_FILE):
        truth = decode_labels(read_labels(folder), frame.depth.shape, "plain")
    background = read_background(folder)
    if background is None:
        return LabelledFrame(frame, truth)
    return LabelledFrame(frame, truth, background, slivers(truth))


def _camera(
    arrays: dict[str, NDArray], path: Path, options: DatasetOptions
) -> tuple[CameraFile, tuple[str, ...]]:
    """Return the camera of an archive and the assumptions about it."""
    height, width = arrays["depth"].shape
    file = options.camera
    if file is None and not arrays.keys() & {"intrinsics", "K"}:
        file = find_camera_file(path)
        if file is None and (width, height) == (KINECT.width, KINECT.height):
            return CameraFile(KINECT), (
                f"no camera file: assuming the first Kinect, fx = fy = {KINECT.fx:g} px, "
                "for frames of 640x480 px (else pass --camera FILE)",
            )
        if file is None:
            raise InputError(
                f"no camera known for {width}x{height} px: pass --camera FILE, or put a "
                "camera.json beside it, or `intrinsics` (fx, fy, cx, cy) into it"
            )
    if file is not None:
        return read_camera_file(file, width, height, path.stem), ()
    if "intrinsics" not in arrays:
        return CameraFile(intrinsics_from_matrix(arrays["K"], width, height, "K (row-major)")), ()
    values = arrays["intrinsics"]
    if values.shape != (4,) or values.dtype.kind not in "fiu":
        raise InputError(f"intrinsics is {values.shape} {values.dtype}, expected fx, fy, cx, cy")
    fx, fy, cx, cy = (float(value) for value in values)
    return CameraFile(CameraIntrinsics(fx, fy, cx, cy, width, height)), ()


def _metres(
    arrays: dict[str, NDArray], camera: CameraFile, options: DatasetOptions
) -> NDArray[np.float32]:
    depth = arrays["depth"]
    if depth.dtype.kind == "f":
        if options.depth_scale_mm is not None:
            raise InputError(
                f"depth is {depth.dtype} and so in metres: --depth-scale-mm is for integer depth"
            )
        # A number out of the float32 range becomes infinite, and DepthFrame rejects it.
        with np.errstate(over="ignore"):
            return np.where(np.isnan(depth), 0.0, depth).astype(np.float32)
    own = arrays.get("depth_scale_m")
    if own is not None and (own.size != 1 or own.dtype.kind not in "fiu"):
        raise InputError(f"depth_scale_m is {own.shape} {own.dtype}, expected one number")
    stated = (
        options.depth_scale_mm,
        None if own is None else float(own.reshape(-1)[0]) * MM_PER_M,
        camera.depth_scale_mm,
    )
    unit = next((scale for scale in stated if scale is not None), None)
    if unit is None:
        raise InputError(
            f"depth is {depth.dtype} and its unit is unknown: pass --depth-scale-mm, "
            f"{_plausible_units(depth)}"
        )
    if not 0 < unit < np.inf:
        raise InputError(f"the depth unit is {unit:g} mm, expected more than 0")
    return metres_from_units(depth, unit)


def _check_plausible(frame: DepthFrame, raw: NDArray) -> None:
    median = float(np.median(frame.depth[frame.valid]))
    low, high = PLAUSIBLE_M
    if low <= median <= high:
        return
    whole = raw.dtype.kind in "iu"
    right = f"pass --depth-scale-mm, {_plausible_units(raw)}" if whole else "write it in metres"
    raise InputError(
        f"the median reading would be {median:.3g} m, expected {low:g} to {high:g} m for a "
        f"tabletop scene; the depth unit is wrong: {right}"
    )


def _plausible_units(raw: NDArray) -> str:
    """List the common depth units that make integer readings plausible."""
    readings = raw[raw > 0]
    if readings.size == 0:
        return "in mm per unit"
    median = float(np.median(readings)) / MM_PER_M
    low, high = PLAUSIBLE_M
    plausible = [
        f"{unit:g} (median reading {median * unit:.2f} m)"
        for unit in COMMON_UNITS_MM
        if low <= median * unit <= high
    ]
    if not plausible:
        return f"in mm per unit (the median reading is {median * MM_PER_M:g} units)"
    return "for example " + " or ".join(plausible)


def _folder_name(path: Path, root: Path) -> str:
    return path.resolve().name if path == root else path.relative_to(root).as_posix()


def _by_number(path: Path) -> list[int | str]:
    """Return a sort key that puts frame 9 before frame 10."""
    # The split alternates text and digits, so that equal types are compared.
    parts = re.split(r"(\d+)", path.as_posix())
    return [int(part) if part.isdigit() else part for part in parts]
