"""Inputs of the fit command: files of points or surfaces, and objects of depth frames."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError
from eyehand.perception import PerceiveOptions, fit_superquadric, perceive, read_frame, segment
from eyehand.perception.io import (
    CLOUD_SUFFIXES,
    FRAME_SUFFIXES,
    is_organised_cloud,
    read_arrays,
    read_cloud,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame, FitOptions, SuperquadricFit

WHOLE = 0
"""Label that takes all readings of a frame as one cloud."""
ANY_DISTANCE = float("inf")
"""An object selected by its label is fitted at any distance."""
NAMED_LABELS = 12
"""Maximum number of objects that the message about a missing label lists."""


@dataclass(frozen=True)
class Cloud:
    """The points of one object, with camera position and support plane where known."""

    name: str
    """Name for messages: the file, and the label of the object if there is one."""
    stem: str
    """Start of the names of the output files."""
    points: NDArray[np.float64]
    """(N, 3), m."""
    view_origin: NDArray[np.float64] | None = None
    """Position of the camera in the frame of the points, (3,), m."""
    support_plane: NDArray[np.float64] | None = None
    """Unit normal and offset of the support plane, (4,)."""


@dataclass(frozen=True)
class FittedCloud:
    """A cloud and its fit."""

    cloud: Cloud
    """The input."""
    fit: SuperquadricFit
    """The result. It is false if it cannot be used."""


@dataclass(frozen=True)
class CloudInput:
    """A file that holds one object."""

    cloud: Cloud
    """Its points."""

    @property
    def stems(self) -> tuple[str, ...]:
        """Starts of the names of the output files."""
        return (self.cloud.stem,)

    def fitted(self, options: FitOptions) -> list[FittedCloud]:
        """Fit it."""
        fit = fit_superquadric(
            self.cloud.points,
            view_origin=self.cloud.view_origin,
            support_plane=self.cloud.support_plane,
            options=options,
        )
        return [FittedCloud(self.cloud, fit)]


@dataclass(frozen=True)
class FrameInput:
    """A depth frame and the labels of the objects to fit."""

    path: Path
    """The frame's file."""
    frame: DepthFrame
    """The frame."""
    labels: tuple[int, ...]
    """Labels of the objects to fit, 1..n as in the segmentation of the frame."""

    @property
    def stems(self) -> tuple[str, ...]:
        """Starts of the names of the output files."""
        return tuple(f"{self.path.stem}_{label}" for label in self.labels)

    def fitted(self, options: FitOptions) -> list[FittedCloud]:
        """Fit the selected objects as `eyehand perceive` does, with hidden rays and support."""
        scene = perceive(
            self.frame,
            PerceiveOptions(
                fit=options,
                max_distance=ANY_DISTANCE,
                max_objects=max(self.labels),
                cloud_points=max(PerceiveOptions().cloud_points, options.points),
            ),
        )
        plane = None
        if scene.support is not None:
            plane = np.append(scene.support.normal, scene.support.offset)
        objects = {item.label: item for item in scene.objects}
        return [
            FittedCloud(
                Cloud(
                    f"{self.path}, object {label}",
                    stem,
                    objects[label].points,
                    np.asarray(scene.view_origin),
                    plane,
                ),
                objects[label].fit,
            )
            for label, stem in zip(self.labels, self.stems, strict=True)
        ]


def read_inputs(
    paths: Sequence[Path],
    *,
    labels: Sequence[int] = (),
    camera: Path | None = None,
    view_origin: Sequence[float] | None = None,
    support_plane: NDArray[np.float64] | None = None,
) -> list[CloudInput | FrameInput]:
    """Read every file before the first fit, so that a bad one costs nothing.

    Parameters
    ----------
    paths
        Clouds and surfaces (see :func:`eyehand.perception.read_cloud`) and depth frames.
        Frames are PNG, NPZ with `depth` and no `points`, and organised PCD and PLY files.
    labels
        Objects of the frames, 1..n; 0 takes a frame's readings as one cloud.
    camera
        Camera file of the frames.
    view_origin, support_plane
        Of the clouds, (3,) and (4,) with a unit normal; frames bring their own.

    Raises
    ------
    InputError
        If a file cannot be read, a frame comes without a label or has no such object, or an
        option does not go with a file.
    """
    origin = None if view_origin is None else np.asarray(view_origin, dtype=np.float64)
    return [
        _frame_input(path, labels, camera, origin, support_plane)
        if _is_frame(path, wanted=bool(labels))
        else _cloud_input(path, labels, camera, origin, support_plane)
        for path in paths
    ]


def _is_frame(path: Path, *, wanted: bool) -> bool:
    """Decide between depth image and cloud; `wanted` decides for archives that hold both."""
    suffix = path.suffix.lower()
    if suffix not in FRAME_SUFFIXES and suffix not in CLOUD_SUFFIXES:
        known = ", ".join(dict.fromkeys((*CLOUD_SUFFIXES, *FRAME_SUFFIXES)))
        raise InputError(f"{path}: suffix {path.suffix!r} is no known format, expected {known}")
    if suffix == ".png":
        return True
    if suffix == ".npz":
        held = read_arrays(path, ("points", "depth"))
        return "depth" in held and (wanted or "points" not in held)
    return is_organised_cloud(path)


def _cloud_input(
    path: Path,
    labels: Sequence[int],
    camera: Path | None,
    origin: NDArray[np.float64] | None,
    plane: NDArray[np.float64] | None,
) -> CloudInput:
    if labels:
        raise InputError(f"--label goes with depth frames, but {path} is one cloud")
    if camera is not None:
        raise InputError(f"--camera goes with depth frames, but {path} is one cloud")
    return CloudInput(Cloud(str(path), path.stem, read_cloud(path), origin, plane))


def _frame_input(
    path: Path,
    labels: Sequence[int],
    camera: Path | None,
    origin: NDArray[np.float64] | None,
    plane: NDArray[np.float64] | None,
) -> CloudInput | FrameInput:
    frame = read_frame(path, camera)
    if list(labels) == [WHOLE]:
        points = frame.points()[frame.valid].astype(np.float64)
        camera_origin = np.zeros(3)
        if frame.T_world_camera is not None:
            points = frame.T_world_camera.apply(points)
            camera_origin = np.asarray(frame.T_world_camera.translation)
        if origin is None:
            origin = camera_origin
        return CloudInput(Cloud(str(path), path.stem, points, origin, plane))
    for option, value in (("--view-origin", origin), ("--plane", plane)):
        if value is not None:
            raise InputError(f"{option} goes with clouds: the depth frame {path} brings its own")
    segmentation = segment(frame)
    sizes = np.bincount(segmentation.labels.ravel(), minlength=segmentation.count + 1)[1:]
    if not len(sizes):
        raise InputError(
            f"{path}: the depth frame shows no object on a support; --label {WHOLE} takes all its "
            "readings as one cloud"
        )
    if not labels:
        raise InputError(
            f"{path} is a depth frame: choose with --label from {_listed(sizes)}; "
            f"{WHOLE} takes all its readings as one cloud"
        )
    for label in labels:
        if not 1 <= label <= len(sizes):
            raise InputError(f"{path} has no object {label}: there are {_listed(sizes)}")
    return FrameInput(path, frame, tuple(dict.fromkeys(labels)))


def _listed(sizes: NDArray[np.intp]) -> str:
    shown = [f"{label} ({size} px)" for label, size in enumerate(sizes[:NAMED_LABELS], start=1)]
    if len(sizes) > NAMED_LABELS:
        shown.append(f"... {len(sizes)} ({sizes[-1]} px)")
    return ", ".join(shown)
