"""The ideal perception result: a scene of the true solids at their true poses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.scenes import TabletopObject
from eyehand.perception import Scene, SceneObject, Segmentation, SupportPlane
from eyehand.perception.superquadric import SuperquadricFit, sample_surface

CLOUD_POINTS = 400
"""Number of points on the surface of each solid."""
MAX_REST_GAP = 0.004
"""Maximum gap between an object and the object that carries it, m."""


def ground_truth_scene(
    objects: Sequence[TabletopObject],
    view_origin: NDArray[np.float64],
    *,
    table_height: float = 0.0,
    seed: int = 0,
) -> Scene:
    """Return the scene that perfect perception would produce.

    Parameters
    ----------
    objects
        Objects at their current poses.
    view_origin
        Position of the camera, (3,), world, m.
    table_height
        Height of the table, m.
    seed
        Seed of the points on the solids.
    """
    rng = np.random.default_rng(seed)
    clouds = [sample_surface(item.shape, CLOUD_POINTS, rng) for item in objects]
    scene_objects = tuple(
        SceneObject(
            label=number,
            points=cloud,
            pixel_count=CLOUD_POINTS,
            fit=SuperquadricFit(item.shape, True, "known", np.zeros(CLOUD_POINTS), (), 0.0),
            visible_share=1.0,
            rests_on=_supporting_label(number - 1, objects, clouds),
        )
        for number, (item, cloud) in enumerate(zip(objects, clouds, strict=True), start=1)
    )
    support = SupportPlane(np.array([0.0, 0.0, 1.0]), -table_height)
    segmentation = Segmentation(np.zeros((1, 1), np.int32), None, 0.0, {})
    return Scene("world", support, scene_objects, view_origin, segmentation, {})


def _supporting_label(
    number: int, objects: Sequence[TabletopObject], clouds: Sequence[NDArray[np.float64]]
) -> int:
    """Return the label of the object that carries this one; 0 for the table."""
    item = objects[number]
    low = float(clouds[number][:, 2].min())
    for other, cloud in enumerate(clouds):
        if other == number or objects[other].shape.centre[2] >= item.shape.centre[2]:
            continue
        near = np.abs(objects[other].shape.distance(clouds[number])).min()
        if near < MAX_REST_GAP and low > cloud[:, 2].min() + MAX_REST_GAP:
            return other + 1
    return 0
