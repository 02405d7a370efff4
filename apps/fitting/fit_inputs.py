"""Inputs of `eyehand fit`: files of points or surfaces, and objects of depth frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.perception import (
    DepthFrame,
    FitOptions,
    PerceiveOptions,
    SuperquadricFit,
    fit_superquadric,
    perceive,
    read_frame,
    segment,
)
from eyehand.perception.io import (
    CLOUD_SUFFIXES,
    FRAME_SUFFIXES,
    MESH_SUFFIXES,
    is_closed,
    is_organised_cloud,
    read_arrays,
    read_cloud,
    read_mesh,
)

from ..frame_masks import FrameMasks
from ..perceived_frame import check_usable
from ..scene_json import fit_parts

WHOLE = 0
"""Label for all readings of a frame as one cloud."""
NO_DISTANCE_LIMIT = float("inf")
"""Distance limit of the fit, m: an object that the user names is fitted at any distance."""
MAX_LISTED_LABELS = 12
"""Maximum number of objects listed in the message about a missing label."""


@dataclass(frozen=True)
class Cloud:
    """The points of one object, with the camera position and support plane if known."""

    name: str
    """Name for messages: its file, and its label if it has one."""
    stem: str
    """Prefix of the names of its output files."""
    points: NDArray[np.float64]
    """(N, 3), m."""
    view_origin: NDArray[np.float64] | None = None
    """Camera position in the frame of the points, (3,), m."""
    support_plane: NDArray[np.float64] | None = None
    """Unit normal and offset of the support plane, (4,)."""
    mesh: bool = False
    """Whether the points are samples of a mesh."""
    whole: bool = False
    """Whether they show the object from all sides."""


@dataclass(frozen=True)
class FittedCloud:
    """A cloud and its fit."""

    cloud: Cloud
    """The fitted cloud."""
    fit: SuperquadricFit
    """The fit. Its truth value is False when it must not be used; `reason` says why."""

    @property
    def beyond_mesh(self) -> float | None:
        """The largest distance by which the solids reach beyond the mesh along their axes, m.

        It is negative where they end before the mesh, and None for other inputs.
        """
        solid = self.fit.superquadric
        if solid is None or not self.cloud.mesh:
            return None
        axes = np.vstack([solid.rotation.T, -solid.rotation.T])
        reach = np.max([part.support(axes) for part in fit_parts(self.fit)], axis=0)
        beyond = reach - (self.cloud.points @ axes.T).max(axis=0)
        return float(beyond[np.argmax(np.abs(beyond))])


@dataclass(frozen=True)
class CloudInput:
    """A file that holds one object."""

    cloud: Cloud
    """The cloud of the object."""

    @property
    def stems(self) -> tuple[str, ...]:
        """Prefixes of the names of its output files."""
        return (self.cloud.stem,)

    def fitted(self, options: FitOptions) -> list[FittedCloud]:
        """Fit the cloud."""
        fit = fit_superquadric(
            self.cloud.points,
            view_origin=self.cloud.view_origin,
            support_plane=self.cloud.support_plane,
            whole=self.cloud.whole,
            options=options,
        )
        return [FittedCloud(self.cloud, fit)]


@dataclass(frozen=True)
class FrameInput:
    """A depth frame and the selected objects in it."""

    path: Path
    """File of the frame."""
    frame: DepthFrame
    """The depth frame."""
    labels: tuple[int, ...]
    """Labels of the selected objects, 1..n as in the segmentation."""

    @property
    def stems(self) -> tuple[str, ...]:
        """Prefixes of the names of its output files."""
        return tuple(f"{self.path.stem}_{label}" for label in self.labels)

    def fitted(self, options: FitOptions) -> list[FittedCloud]:
        """Fit the selected objects like `eyehand perceive`, with occlusion and support plane."""
        scene = perceive(
            self.frame,
            PerceiveOptions(
                fit=options,
                max_distance=NO_DISTANCE_LIMIT,
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
    masks: FrameMasks | None = None,
    view_origin: Sequence[float] | None = None,
    support_plane: NDArray[np.float64] | None = None,
) -> list[CloudInput | FrameInput]:
    """Read all files before the first fit, so that an invalid file fails early.

    Parameters
    ----------
    paths
        Clouds and surfaces (see :func:`eyehand.perception.read_cloud`) and depth frames.
        Frames are PNG files, NPZ files with `depth` and without `points`, and PCD or PLY files
        whose points form an image.
    labels
        Objects of the frames, 1..n. 0 takes all readings of a frame as one cloud.
    camera
        Camera file of the frames.
    masks
        Readings of the frames that are left out.
    view_origin, support_plane
        Camera position (3,) and support plane (4,) of the clouds. Frames have their own.

    Raises
    ------
    InputError
        If a file cannot be read, a frame has no label or no such object, or an option does not
        apply to a file.
    """
    origin = None if view_origin is None else np.asarray(view_origin, dtype=np.float64)
    return [
        _frame_input(path, labels, _read_frame(path, camera, masks), origin, support_plane)
        if _is_frame(path, labelled=bool(labels))
        else _cloud_input(path, labels, (camera, masks), origin, support_plane)
        for path in paths
    ]


def _is_frame(path: Path, *, labelled: bool) -> bool:
    """Return whether a file is a depth frame; `labelled` decides for archives with both."""
    suffix = path.suffix.lower()
    if suffix not in FRAME_SUFFIXES and suffix not in CLOUD_SUFFIXES:
        known = ", ".join(dict.fromkeys((*CLOUD_SUFFIXES, *FRAME_SUFFIXES)))
        raise InputError(
            f"{path}: suffix {path.suffix!r} is not supported, expected {known} (.npz with "
            "`points` (N, 3), m, or with `depth` and `K`)"
        )
    if suffix == ".png":
        return True
    if suffix == ".npz":
        arrays = read_arrays(path, ("points", "depth"))
        return "depth" in arrays and (labelled or "points" not in arrays)
    return is_organised_cloud(path)


def _read_frame(path: Path, camera: Path | None, masks: FrameMasks | None) -> DepthFrame:
    frame = read_frame(path, camera)
    return frame if masks is None else masks.applied(frame)


def _cloud_input(
    path: Path,
    labels: Sequence[int],
    of_frames: tuple[Path | None, FrameMasks | None],
    origin: NDArray[np.float64] | None,
    plane: NDArray[np.float64] | None,
) -> CloudInput:
    camera, masks = of_frames
    for option, value in (("--label", labels), ("--camera", camera), ("a mask", masks)):
        if value:
            raise InputError(f"{option} is for depth frames, but {path} is one cloud")
    points, mesh, whole = read_cloud(path), False, False
    if path.suffix.lower() in MESH_SUFFIXES:
        vertices, triangles = read_mesh(path)
        mesh, whole = len(triangles) > 0, is_closed(vertices, triangles)
    return CloudInput(Cloud(str(path), path.stem, points, origin, plane, mesh, whole))


def _frame_input(
    path: Path,
    labels: Sequence[int],
    frame: DepthFrame,
    origin: NDArray[np.float64] | None,
    plane: NDArray[np.float64] | None,
) -> CloudInput | FrameInput:
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
            raise InputError(f"{option} is for clouds: the depth frame {path} has its own")
    segmentation = segment(frame)
    check_usable(segmentation.warnings, str(path))
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
    """List labels with their sizes; of many, the first ones and the last."""
    labels = [f"{label} ({size} px)" for label, size in enumerate(sizes, start=1)]
    if len(labels) > MAX_LISTED_LABELS:
        labels[MAX_LISTED_LABELS:] = [f"... {labels[-1]}"]
    return ", ".join(labels)
