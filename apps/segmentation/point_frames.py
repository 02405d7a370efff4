"""Frames annotated by points, and the score of a segmentation on them.

People can annotate a cluttered frame with points in a minute, but not with exact masks. An object
has points on each visible part. Points on the background and boxes to ignore complete the frame.
"""

from __future__ import annotations

import io
import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.perception import DepthFrame, read_frame
from eyehand.perception.io import read_bytes

POINTS_FILE, DEPTH_FILE, COLOUR_FILE = "points.json", "depth.png", "colour.jpg"
"""Names of the files in the folder of each frame. The colour image is optional."""

Verdict = Literal["right", "missed", "split", "merged", "on_background"]
"""What became of an object.

- right: all its points carry one label, and no other point carries it.
- missed: no point carries a label.
- merged: a point of another object carries one of its labels.
- on_background: a point of the background carries one of its labels.
- split: its points carry several labels, or some carry none.
"""


@dataclass(frozen=True)
class PointFrame:
    """A depth frame annotated by points; all points are (N, 2) [column, row]."""

    name: str
    """Name of its folder."""
    frame: DepthFrame
    """The depth frame, without colour."""
    colour: NDArray[np.uint8] | None
    """(H, W, 3) RGB, or None."""
    objects: dict[str, NDArray[np.intp]]
    """Points by the name of the object; names get a number if they repeat."""
    background: NDArray[np.intp]
    """Points on the support, walls, and all else that is no object."""
    ignored: NDArray[np.bool_]
    """(H, W) mask: segments that touch it are never surplus."""


@dataclass(frozen=True)
class PointScore:
    """The score of one frame."""

    verdicts: dict[str, Verdict]
    """Verdict by the name of the object."""
    background: int
    """Number of background points."""
    background_inside: int
    """Number of background points inside a segment."""
    surplus: int
    """Number of segments without any object point that do not touch an ignored region."""
    unsaid: int
    """Number of objects that are not right and without a warning that names one of their segments.
    Missed objects are among them."""
    false_alarms: int
    """Number of right objects whose segment a warning names."""

    def count(self, verdict: Verdict) -> int:
        """Return the number of objects with a verdict."""
        return sum(found == verdict for found in self.verdicts.values())


def read_point_frames(folder: Path) -> list[PointFrame]:
    """Read all annotated frames in the folders of a folder, sorted by name.

    Raises
    ------
    InputError
        If there is none, or if a file is damaged.
    """
    paths = sorted(folder.glob(f"*/{POINTS_FILE}"))
    if not paths:
        raise InputError(f"{folder} holds no */{POINTS_FILE}")
    return [_read(path) for path in paths]


def frames_by_camera(frames: Sequence[PointFrame]) -> dict[str, list[PointFrame]]:
    """Group annotated frames by camera; a group has the common start of its frames' names."""
    groups: dict[object, list[PointFrame]] = {}
    for frame in frames:
        groups.setdefault(frame.frame.intrinsics, []).append(frame)
    return {_common_name([f.name for f in members]): members for members in groups.values()}


def score_points(
    labels: NDArray[np.int32], truth: PointFrame, named: Collection[int] = ()
) -> PointScore:
    """Compare labels (H, W), 0 = no object, with the points of a frame.

    `named` are the labels that warnings name.
    """
    carried = {name: labels[at[:, 1], at[:, 0]] for name, at in truth.objects.items()}
    behind = labels[truth.background[:, 1], truth.background[:, 0]]
    verdicts: dict[str, Verdict] = {}
    for name, own in carried.items():
        others = [found for other, found in carried.items() if other != name]
        verdicts[name] = _verdict(own, np.concatenate([*others, [0]]), behind)
    used = np.unique(np.concatenate([*carried.values(), labels[truth.ignored], [0]]))
    surplus = np.setdiff1d(np.unique(labels), used)
    right = {name: verdict == "right" for name, verdict in verdicts.items()}
    warned = {name: not set(own.tolist()).isdisjoint(named) for name, own in carried.items()}
    return PointScore(
        verdicts,
        len(behind),
        int(np.count_nonzero(behind)),
        len(surplus),
        unsaid=sum(not right[name] and not warned[name] for name in carried),
        false_alarms=sum(right[name] and warned[name] for name in carried),
    )


def _common_name(names: Sequence[str]) -> str:
    first, last = min(names), max(names)
    length = next((k for k, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), None)
    return first[:length].rstrip("_-0123456789") or first


def _verdict(
    own: NDArray[np.int32], others: NDArray[np.int32], behind: NDArray[np.int32]
) -> Verdict:
    found = np.unique(own[own > 0])
    if not len(found):
        return "missed"
    if np.isin(found, others).any():
        return "merged"
    if np.isin(found, behind).any():
        return "on_background"
    return "right" if len(found) == 1 and (own > 0).all() else "split"


def _read(path: Path) -> PointFrame:
    frame = replace(read_frame(path.parent / DEPTH_FILE), colour=None)
    data = read_bytes(path)
    try:
        content = json.loads(data)
        objects: dict[str, NDArray[np.intp]] = {}
        for item in content["objects"]:
            name = str(item["name"])
            number = sum(name == known.split(" #")[0] for known in objects)
            key = f"{name} #{number + 1}" if number else name
            objects[key] = _points(item["points"], frame)
        background = [p for item in content.get("background", []) for p in item["points"]]
        boxes = [item["ignore_box"] for item in content.get("ignore", [])]
        ignored = np.zeros(frame.depth.shape, bool)
        for left, top, right, bottom in boxes:
            ignored[int(top) : int(bottom), int(left) : int(right)] = True
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path} is no file of annotated points: {error!r}") from error
    colour = _read_colour(path.parent / COLOUR_FILE, frame)
    return PointFrame(path.parent.name, frame, colour, objects, _points(background, frame), ignored)


def _read_colour(path: Path, frame: DepthFrame) -> NDArray[np.uint8] | None:
    if not path.is_file():
        return None
    # Pillow comes with the extra `view`. The modules of all commands load without extras.
    from PIL import Image

    data = read_bytes(path)
    try:
        # Only the header is read here: an image of any size is refused before it is unpacked.
        with Image.open(io.BytesIO(data)) as header:
            size = header.size
    except (OSError, ValueError, Image.DecompressionBombError):
        size = None
    image = None
    if size == frame.depth.shape[::-1]:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR_RGB)
    if image is None or image.shape[:2] != frame.depth.shape:
        raise InputError(f"{path} is no colour image of {frame.depth.shape[::-1]} px")
    return image.astype(np.uint8)


def _points(points: Any, frame: DepthFrame) -> NDArray[np.intp]:
    """Convert points [column, row] to an array, moved into the image where they are outside."""
    rows, columns = frame.depth.shape
    array = np.asarray(points, np.float64).reshape(-1, 2).astype(np.intp)
    return np.clip(array, 0, [columns - 1, rows - 1])
