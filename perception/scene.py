"""Perceive a depth frame: find the support plane and the objects, and fit a solid to each one."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from .background_points import background_points
from .frame import DepthFrame
from .object_evidence import RegionEvidence, collect_evidence, median_distance, sample_points
from .overlap import overlapping_objects
from .segmentation import (
    Container,
    SceneWarning,
    Segmentation,
    SegmentationOptions,
    SupportPlane,
    UnknownRegion,
    segment,
)
from .segmentation.label_pixels import count_labels
from .stacking import SurfaceBelow, find_surface_below, rests_on
from .superquadric import FitOptions, SuperquadricFit
from .thread_pool import map_in_threads, one_blas_thread
from .visibility import visible_share

SUPPORT = 0
"""Value of ``rests_on`` for the support plane."""


@dataclass(frozen=True)
class PerceiveOptions:
    """Options of :func:`perceive`."""

    segmentation: SegmentationOptions = field(default_factory=SegmentationOptions)
    """Options of the segmentation stage."""
    fit: FitOptions = field(default_factory=FitOptions)
    """Options of every superquadric fit."""
    max_distance: float = 2.5
    """Maximum distance of a fitted object from the camera, m. Farther objects are only segmented:
    their pixels are too few and too noisy for a fit."""
    cloud_points: int = 2000
    """Maximum number of points per object that are fitted. More points take longer."""
    max_objects: int = 30
    """Maximum number of fitted objects, largest first. It bounds the time on a cluttered frame."""
    seed: int = 0
    """Seed of the random choice of points."""
    threads: int = 2
    """Number of objects fitted at the same time. More threads save time on idle cores. The solids
    do not change."""


@dataclass(frozen=True)
class SceneObject:
    """One object of a scene."""

    label: int
    """Number of the object in the segmentation, 1..n, largest first."""
    points: NDArray[np.float64]
    """Visible surface points, (N, 3), m, in the scene's frame. Of large objects there are more than
    `PerceiveOptions.cloud_points`, which the solid is fitted to."""
    pixel_count: int
    """Size of the object's segment, px."""
    fit: SuperquadricFit
    """The result of the fit, in the scene's frame. ``bool(fit)`` is false if the fit failed.
    ``fit.reason`` then holds the reason."""
    visible_share: float
    """Number of the object's pixels divided by the area of the solid's projection in the image,
    0-1. It is 0 if the fit failed."""
    rests_on: int | None
    """Label of the object below, 0 for the support plane, None if it is unknown."""
    overlaps: tuple[int, ...] = ()
    """Labels of larger objects whose solids overlap with this one's by more than 3 mm. Then this
    solid is probably wrong."""

    @property
    def doubtful(self) -> bool:
        """Whether the object may have another shape than its solid.

        Another solid explains it as well, its outline differs, or the solid overlaps a larger one.
        """
        return self.fit.ambiguous or self.fit.outline_differs or bool(self.overlaps)


@dataclass(frozen=True)
class Scene:
    """The support plane and the objects in one depth frame."""

    reference_frame: Literal["world", "camera"]
    """Coordinate frame of all geometry: the world if the camera's pose is known, else the
    camera."""
    support: SupportPlane | None
    """The support plane, or None if the image shows none."""
    objects: tuple[SceneObject, ...]
    """The objects, largest first."""
    view_origin: NDArray[np.float64]
    """Position of the camera in the scene's frame, (3,), m."""
    segmentation: Segmentation
    """The segmentation of the depth image. Its geometry is in the camera frame."""
    timings: dict[str, float]
    """Time of each stage, s: ``segmentation``, ``clouds``, ``fit`` (with the search for the
    surface below each object, and its `visible_share`) and ``relations`` (`rests_on`,
    `overlaps`)."""
    containers: tuple[Container, ...] = ()
    """Bins, totes, boxes and trays, largest first."""
    unknown: tuple[UnknownRegion, ...] = ()
    """Regions of the support without readings, where something may stand, largest first."""
    background: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    """Readings above the support, near the objects, that belong to no object, (K, 3), m."""
    scale_error: float = math.inf
    """Standard deviation of the scale of the depth image: `DepthFrame.scale_error`."""

    @property
    def warnings(self) -> tuple[SceneWarning, ...]:
        """Warnings of the segmentation: what it could not decide, or the image does not show."""
        return self.segmentation.warnings

    @property
    def seconds(self) -> float:
        """Total time of all stages, s."""
        return sum(self.timings.values())


@one_blas_thread()
def perceive(frame: DepthFrame, options: PerceiveOptions | None = None) -> Scene:
    """Find the support plane and the objects of a depth frame, and fit a solid to each object.

    Parameters
    ----------
    frame
        The depth frame. With ``T_world_camera`` the scene is in the world frame, z up. Without it,
        the scene is in the camera's optical frame.
    options
        Options of all stages.

    Returns
    -------
    Scene
        The scene. All numbers and arrays in it are finite. An object whose fit failed is kept,
        with the reason. Only the properties `spread` and `margin` of a fit can be infinite.

    Raises
    ------
    InputError
        If `frame` is something else.
    """
    if not isinstance(frame, DepthFrame):
        raise InputError(f"perceive needs a DepthFrame, as from read_frame; got {type(frame)}")
    options = options or PerceiveOptions()
    started = time.perf_counter()
    segmentation = segment(frame, options.segmentation)
    segmented = time.perf_counter()
    pose = frame.T_world_camera
    T_scene_camera = RigidTransform.identity() if pose is None else pose
    support = segmentation.support.moved(T_scene_camera) if segmentation.support else None
    boxes = segmentation.boxes()
    sizes = count_labels(segmentation.labels, segmentation.count)
    readings = _sample_readings(frame, segmentation, T_scene_camera, boxes, options)
    clouds = {label: one[: options.cloud_points] for label, one in readings.items()}
    collected = time.perf_counter()
    below = {
        label: find_surface_below(label, clouds, support, segmentation, boxes[label])
        for label in clouds
    }

    def fit_label(label: int) -> tuple[SuperquadricFit, float]:
        plane = _plane_below(support, below[label])
        fit = _fit(label, clouds[label], plane, frame, T_scene_camera, segmentation, options)
        return fit, visible_share(int(sizes[label]), fit, frame, T_scene_camera)

    fits = dict(zip(clouds, map_in_threads(fit_label, clouds, options.threads), strict=True))
    fitted = time.perf_counter()
    overlaps = overlapping_objects({label: fit for label, (fit, _) in fits.items()})
    objects = tuple(
        SceneObject(
            label=label,
            points=readings[label],
            pixel_count=int(sizes[label]),
            fit=fit,
            visible_share=share,
            rests_on=rests_on(clouds[label], fit, below[label], support),
            overlaps=overlaps[label],
        )
        for label, (fit, share) in fits.items()
    )
    timings = {
        "segmentation": segmented - started,
        "clouds": collected - segmented,
        "fit": fitted - collected,
        "relations": time.perf_counter() - fitted,
    }
    return Scene(
        reference_frame="camera" if frame.T_world_camera is None else "world",
        support=support,
        objects=objects,
        view_origin=np.asarray(T_scene_camera.translation),
        segmentation=segmentation,
        timings=timings,
        containers=tuple(one.moved(T_scene_camera) for one in segmentation.containers),
        unknown=tuple(one.moved(T_scene_camera) for one in segmentation.unknown),
        background=background_points(frame, segmentation, T_scene_camera, list(clouds.values())),
        scale_error=frame.scale_error,
    )


def fit_region(
    frame: DepthFrame,
    labels: NDArray[np.int32],
    label: int,
    support: SupportPlane | None,
    options: PerceiveOptions | None = None,
) -> tuple[SuperquadricFit, NDArray[np.float64]]:
    """Fit a solid to one region of a frame whose objects and support plane are known.

    The points and the evidence are those that :func:`perceive` uses.

    Parameters
    ----------
    frame
        The depth frame. With ``T_world_camera`` the result is in the world frame, else in the
        camera's.
    labels
        (H, W) int32: 0 = not an object, 1..n = objects.
    label
        The region to fit.
    support
        The plane on which the object rests, in the camera frame; None if it is unknown.
    options
        Options of the fit and of its points.

    Returns
    -------
    fit, points
        The fit, and the points (N, 3) that it used, m.

    Raises
    ------
    InputError
        If no pixel has the label.
    """
    options = options or PerceiveOptions()
    evidence = region_evidence(frame, labels, label, support, options)
    fit_options = replace(options.fit, seed=options.fit.seed + label)
    return evidence.fit(fit_options), evidence.points


def region_evidence(
    frame: DepthFrame,
    labels: NDArray[np.int32],
    label: int,
    support: SupportPlane | None,
    options: PerceiveOptions | None = None,
) -> RegionEvidence:
    """Return what :func:`fit_region` fits. The parameters and errors are the same."""
    options = options or PerceiveOptions()
    segmentation = Segmentation(labels, support, 0.0, {})
    box = segmentation.boxes().get(label)
    if box is None:
        raise InputError(f"label must be that of a region with pixels, got {label}")
    T_scene_camera = frame.T_world_camera
    if T_scene_camera is None:
        T_scene_camera = RigidTransform.identity()
    rng = np.random.default_rng(options.seed)
    sampled = sample_points(frame, segmentation, label, box, options.cloud_points, rng)
    cloud = T_scene_camera.apply(sampled[: options.cloud_points])
    moved = support.moved(T_scene_camera) if support else None
    plane = _plane_below(moved, SurfaceBelow(0.0, SUPPORT))
    return collect_evidence(cloud, plane, frame, T_scene_camera, segmentation.mask(label))


def _sample_readings(
    frame: DepthFrame,
    segmentation: Segmentation,
    T_scene_camera: RigidTransform,
    boxes: dict[int, tuple[slice, slice]],
    options: PerceiveOptions,
) -> dict[int, NDArray[np.float64]]:
    """Return points (N, 3) of each object, scene frame. The first ones are those of its fit."""
    rng = np.random.default_rng(options.seed)
    return {
        label: T_scene_camera.apply(
            sample_points(frame, segmentation, label, box, options.cloud_points, rng)
        )
        for label, box in boxes.items()
    }


def _plane_below(support: SupportPlane | None, surface: SurfaceBelow) -> NDArray[np.float64] | None:
    """Return the plane that an object stands on, unit normal and offset (4,), scene frame."""
    if support is None:
        return None
    return np.append(support.normal, support.offset - surface.height)


def _fit(
    label: int,
    cloud: NDArray[np.float64],
    plane: NDArray[np.float64] | None,
    frame: DepthFrame,
    T_scene_camera: RigidTransform,
    segmentation: Segmentation,
    options: PerceiveOptions,
) -> SuperquadricFit:
    """Fit a solid to an object's points, unless it is too far or not among the largest ones."""
    origin = np.asarray(T_scene_camera.translation)
    distance = median_distance(cloud, origin)
    if distance > options.max_distance:
        return SuperquadricFit.rejected(
            f"the object is {distance:.2f} m away: objects beyond {options.max_distance} m are "
            "not fitted"
        )
    if label > options.max_objects:
        return SuperquadricFit.rejected(
            f"only the {options.max_objects} largest objects are fitted"
        )
    fit_options = replace(options.fit, seed=options.fit.seed + label)
    mask = segmentation.mask(label)
    return collect_evidence(cloud, plane, frame, T_scene_camera, mask).fit(fit_options)
