"""A depth frame as a described scene: support plane, objects, a solid for each."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import cv2
import numpy as np
from scipy.spatial.transform import RigidTransform

from .segmentation import Segmentation, SegmentationOptions, SupportPlane, segment
from .stacking import rests_on, surface_below
from .superquadric import FitOptions, SuperquadricFit, fit_superquadric
from .thread_pool import in_threads
from .visibility import hidden_rays, visible_share

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .frame import DepthFrame

SUPPORT = 0
"""Value of ``rests_on`` for the support plane itself."""


@dataclass(frozen=True)
class PerceiveOptions:
    """Options of :func:`perceive`."""

    segmentation: SegmentationOptions = field(default_factory=SegmentationOptions)
    """Options of the segmentation stage."""
    fit: FitOptions = field(default_factory=FitOptions)
    """Options of every superquadric fit."""
    max_distance: float = 2.5
    """Objects farther than this are segmented but not fitted, m: a far object's few noisy pixels
    do not earn a model."""
    cloud_points: int = 2000
    """Points kept per object: more for a denser cloud downstream, fewer for speed."""
    border: int = 1
    """Pixels peeled off every segment before its fit: more drops flying pixels, fewer keeps thin
    objects."""
    max_objects: int = 30
    """Objects fitted, largest first: bounds the time on a cluttered frame."""
    seed: int = 0
    """Seed of the choice of points."""
    threads: int = 2
    """Objects fitted at a time: more shortens a look on free cores, and gives the same solids."""


@dataclass(frozen=True)
class SceneObject:
    """One object as seen."""

    label: int
    """Its number in the segmentation, 1..n, largest first."""
    points: NDArray[np.float64]
    """Visible surface points, (N, 3), m, in the scene's frame."""
    pixels: int
    """Size of its segment, px."""
    fit: SuperquadricFit
    """The fitted solid in the scene's frame; falsy with a reason where there is none."""
    visible_share: float
    """Share of the solid's outline in the image that is this object's own pixels, 0-1."""
    rests_on: int | None
    """Label of the object below, 0 for the support plane, None when nothing below was seen."""


@dataclass(frozen=True)
class Scene:
    """What one look tells."""

    frame: Literal["world", "camera"]
    """Frame of all geometry: world when the camera's place was known."""
    support: SupportPlane | None
    """Support plane, or None when the frame shows none."""
    objects: tuple[SceneObject, ...]
    """Objects, largest first."""
    view_origin: NDArray[np.float64]
    """Place of the camera, (3,), m."""
    segmentation: Segmentation
    """The labels behind the objects."""
    timings: dict[str, float]
    """Seconds per stage: segmentation, clouds, fit, relations."""

    @property
    def seconds(self) -> float:
        """Total time of all stages."""
        return sum(self.timings.values())


def perceive(frame: DepthFrame, options: PerceiveOptions | None = None) -> Scene:
    """Describe a depth frame as a support plane and objects, each with its simplest solid.

    Parameters
    ----------
    frame
        Depth frame; with ``T_world_camera`` the scene is in the world frame, z up, otherwise in
        the camera's.
    options
        Options of all stages.

    Returns
    -------
    Scene
        Every value finite. An object whose fit failed is kept with the reason.
    """
    options = options or PerceiveOptions()
    began = time.perf_counter()
    segmentation = segment(frame, options.segmentation)
    segmented = time.perf_counter()
    to_scene = frame.T_world_camera
    if to_scene is None:
        to_scene = RigidTransform.identity()
    support = segmentation.support.moved(to_scene) if segmentation.support else None
    rng = np.random.default_rng(options.seed)
    boxes = segmentation.boxes()
    sizes = np.bincount(segmentation.labels.ravel(), minlength=segmentation.count + 1)
    clouds = {
        label: to_scene.apply(_cloud(frame, segmentation, label, box, options, rng))
        for label, box in boxes.items()
    }
    origin = np.asarray(to_scene.translation)
    collected = time.perf_counter()
    below = {
        label: surface_below(label, clouds, support, segmentation, boxes[label]) for label in clouds
    }

    def fitted_to(label: int) -> SuperquadricFit:
        return _fit(
            label,
            clouds[label],
            to_scene,
            support,
            below[label].height,
            frame,
            segmentation,
            options,
        )

    fits = dict(zip(clouds, in_threads(fitted_to, clouds, options.threads), strict=True))
    fitted = time.perf_counter()
    objects = tuple(
        SceneObject(
            label=label,
            points=cloud,
            pixels=int(sizes[label]),
            fit=fits[label],
            visible_share=visible_share(int(sizes[label]), fits[label], frame, to_scene),
            rests_on=rests_on(cloud, fits[label], below[label], support),
        )
        for label, cloud in clouds.items()
    )
    timings = {
        "segmentation": segmented - began,
        "clouds": collected - segmented,
        "fit": fitted - collected,
        "relations": time.perf_counter() - fitted,
    }
    return Scene(
        frame="camera" if frame.T_world_camera is None else "world",
        support=support,
        objects=objects,
        view_origin=origin,
        segmentation=segmentation,
        timings=timings,
    )


def _cloud(
    frame: DepthFrame,
    segmentation: Segmentation,
    label: int,
    box: tuple[slice, slice],
    options: PerceiveOptions,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Draw at most ``cloud_points`` camera-frame points of a segment without its border."""
    mask = segmentation.labels[box] == label
    if options.border > 0:
        side = 2 * options.border + 1
        inner = (
            cv2.erode(
                mask.astype(np.uint8),
                np.ones((side, side), np.uint8),
                borderType=cv2.BORDER_CONSTANT,
                borderValue=0,
            )
            > 0
        )
        if np.count_nonzero(inner) >= options.fit.min_points:
            mask = inner
    rows, columns = np.nonzero(mask & (frame.depth[box] > 0))
    if rows.size > options.cloud_points:
        chosen = np.sort(rng.choice(rows.size, options.cloud_points, replace=False))
        rows, columns = rows[chosen], columns[chosen]
    rows, columns = rows + box[0].start, columns + box[1].start
    k = frame.intrinsics
    z = frame.depth[rows, columns].astype(np.float64)
    return np.column_stack([(columns - k.cx) / k.fx * z, (rows - k.cy) / k.fy * z, z])


def _fit(
    label: int,
    cloud: NDArray[np.float64],
    T_scene_camera: RigidTransform,
    support: SupportPlane | None,
    floor: float,
    frame: DepthFrame,
    segmentation: Segmentation,
    options: PerceiveOptions,
) -> SuperquadricFit:
    origin = np.asarray(T_scene_camera.translation)
    distance = float(np.linalg.norm(np.median(cloud, axis=0) - origin)) if len(cloud) else 0.0
    if distance > options.max_distance:
        return SuperquadricFit.none(
            f"{distance:.2f} m away: objects beyond {options.max_distance} m are not fitted"
        )
    if label > options.max_objects:
        return SuperquadricFit.none(f"only the {options.max_objects} largest objects are fitted")
    plane = None
    if support is not None:
        plane = np.append(support.normal, support.offset - floor)
    # The cloud's outline lies inside the object's by what was peeled off and half a pixel more.
    margin = (options.border + 0.5) * distance / frame.intrinsics.fx
    fit_options = replace(
        options.fit,
        seed=options.fit.seed + label,
        silhouette_margin=options.fit.silhouette_margin + margin,
    )
    return fit_superquadric(
        cloud,
        view_origin=origin,
        support_plane=plane,
        hidden=lambda rays: hidden_rays(
            rays, cloud, frame, T_scene_camera, segmentation.mask(label)
        ),
        options=fit_options,
    )
