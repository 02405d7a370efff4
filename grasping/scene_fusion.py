"""Fuse what a second camera pose shows of one object into a scene."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import KDTree

from eyehand.perception import fit_superquadric

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject

SAME_SURFACE = 0.008
"""Distance below which points of two views belong to the same surface, m."""
MATCH_POINTS = 200
"""Number of points of each object that are compared."""
MIN_SHARED = 0.3
"""Minimum share of the points of one view of an object that lie on the other view's object."""


def fuse_scenes(first: Scene, second: Scene, label: int) -> Scene:
    """Fuse two scenes of the same static objects, seen from two camera poses.

    The second view shows one object and its surroundings. An object that both views show alone is
    fitted to the points of both, with the empty space of the second view. Where the views divide
    the objects otherwise, the second view counts for the viewed object, and the first one for the
    others, which it shows completely. Objects that only one view shows are kept.

    Parameters
    ----------
    first, second
        The scenes, in the world frame. The labels, warnings and camera of the result are those of
        the second scene. Further objects have higher labels.
    label
        Label of the viewed object in the first scene.
    """
    pairs = {
        item.label: [one.label for one in first.objects if _are_same(one, item)]
        for item in second.objects
    }
    partners = [one for labels in pairs.values() for one in labels]
    seen: set[int] = set()
    objects: list[SceneObject] = []
    for item in second.objects:
        labels = pairs[item.label]
        alone = len(labels) == 1 and partners.count(labels[0]) == 1
        if alone:
            (other,) = (one for one in first.objects if one.label == labels[0])
            objects.append(_fused(item, other))
        elif not labels or label in labels:
            objects.append(item)
        if alone or label in labels:
            seen.update(labels)
    kept = [item for item in first.objects if item.label not in seen]
    last = max((item.label for item in second.objects), default=0)
    objects += [
        replace(item, label=number, rests_on=None, overlaps=())
        for number, item in enumerate(kept, start=last + 1)
    ]
    return replace(second, objects=tuple(objects), support=first.support)


def _are_same(one: SceneObject, other: SceneObject) -> bool:
    """Return whether two views may show the same object."""
    return max(_share(one, other.points), _share(other, one.points)) > MIN_SHARED


def _share(item: SceneObject, points: NDArray[np.float64]) -> float:
    """Return the share of points (N, 3), m, on the surface or in the solids of an object."""
    if not len(points) or not len(item.points):
        return 0.0
    points = points[:: max(len(points) // MATCH_POINTS, 1)]
    near = KDTree(item.points).query(points, distance_upper_bound=SAME_SURFACE)[0] < np.inf
    for solid in item.fit.parts:
        near |= solid.distance(points) < SAME_SURFACE
    return float(near.mean())


def _fused(item: SceneObject, other: SceneObject) -> SceneObject:
    """Return an object of the second view, fitted to the points of both views if that converges."""
    evidence = item.fit.evidence
    if evidence is None:
        return item
    points = np.concatenate([item.points, other.points])
    fit = fit_superquadric(
        points,
        view_origin=evidence.view_origin,
        support_plane=evidence.plane,
        free_space=evidence.free_space,
    )
    return replace(item, points=points, fit=fit if fit or not item.fit else item.fit)
