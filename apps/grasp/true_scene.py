"""What a perfect eye would see: a scene of the objects' own solids at their true places."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception import Scene, SceneObject, Segmentation, SupportPlane
from eyehand.perception.superquadric import SuperquadricFit, sample_surface

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.data_synth.scenes import TabletopObject

POINTS = 400
"""Points over each solid's whole surface: they stand for its cloud."""
TOUCHING = 0.004
"""An object over another rests on it where they are no farther apart than this, m."""


def known_scene(
    objects: Sequence[TabletopObject],
    view_origin: NDArray[np.float64],
    *,
    table_height: float = 0.0,
    seed: int = 0,
) -> Scene:
    """Make the scene that a perfect eye would see.

    Parameters
    ----------
    objects
        Objects where they are now.
    view_origin
        Place of the eye, (3,), world, m.
    table_height
        Height of the table, m.
    seed
        Of the points on the solids.
    """
    rng = np.random.default_rng(seed)
    clouds = [sample_surface(item.shape, POINTS, rng) for item in objects]
    seen = tuple(
        SceneObject(
            label=number,
            points=cloud,
            pixels=POINTS,
            fit=SuperquadricFit(item.shape, True, "known", np.zeros(POINTS), (), 0.0),
            visible_share=1.0,
            rests_on=_below(number - 1, objects, clouds),
        )
        for number, (item, cloud) in enumerate(zip(objects, clouds, strict=True), start=1)
    )
    support = SupportPlane(np.array([0.0, 0.0, 1.0]), -table_height)
    segmentation = Segmentation(np.zeros((1, 1), np.int32), None, 0.0, {})
    return Scene("world", support, seen, view_origin, segmentation, {})


def _below(
    number: int, objects: Sequence[TabletopObject], clouds: Sequence[NDArray[np.float64]]
) -> int:
    """Label of the object that carries this one; 0 for the table."""
    item = objects[number]
    low = float(clouds[number][:, 2].min())
    for other, cloud in enumerate(clouds):
        if other == number or objects[other].shape.centre[2] >= item.shape.centre[2]:
            continue
        near = np.abs(objects[other].shape.distance(clouds[number])).min()
        if near < TOUCHING and low > cloud[:, 2].min() + TOUCHING:
            return other + 1
    return 0
