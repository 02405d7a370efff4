"""Scenes of given solids on a table, as if perceived without error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Scene, SceneObject, Segmentation, Superquadric, SupportPlane
from eyehand.perception.superquadric import Rim, SuperquadricFit, Vessel

EYE = np.array([0.0, -0.5, 0.4])


def box(size, at=(0.0, 0.0), turn=0.0, label=1):
    """Return a box (x, y, z size in m) standing on the table."""
    return _standing("box", 0.5 * np.asarray(size), (0.1, 0.1), at, turn, label)


def can(radius, height, at=(0.0, 0.0), label=1):
    """Return an upright cylinder."""
    return _standing("cylinder", np.array([radius, radius, 0.5 * height]), (0.1, 1.0), at, 0, label)


def bowl(radius, height, wall, at=(0.0, 0.0), label=1, lip=0.0):
    """Return an upright vessel with straight walls, open `lip` above the top of its outer solid."""
    outer = can(radius, height, at, label)
    rim = Rim(np.array([*at, height + lip]), np.full(2, radius), np.eye(3)[:2])
    solid = outer.fit.superquadric
    assert solid is not None
    vessel = Vessel(solid, rim, wall)
    below = outer.points[outer.points[:, 2] < height - 0.003]
    return replace(outer, points=below, fit=replace(outer.fit, vessel=vessel))


def scene_of(*items: SceneObject) -> Scene:
    """Return a scene in the world frame with the table at z = 0."""
    support = SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)
    seg = Segmentation(np.zeros((4, 4), np.int32), support, 0.001, {})
    return Scene("world", support, items, EYE, seg, {})


def moved(scene: Scene, T: RigidTransform) -> Scene:
    """Return the scene in another frame."""
    assert scene.support is not None
    items = []
    for item in scene.objects:
        solid = item.fit.superquadric
        assert solid is not None
        fit = replace(item.fit, superquadric=replace(solid, pose=T * solid.pose))
        items.append(replace(item, points=T.apply(item.points), fit=fit))
    return replace(
        scene,
        objects=tuple(items),
        support=scene.support.moved(T),
        view_origin=T.apply(scene.view_origin),
    )


def _standing(kind, axes, exponents, at, turn, label) -> SceneObject:
    pose = RigidTransform.from_components([*at, axes[2]], Rotation.from_rotvec([0.0, 0.0, turn]))
    solid = Superquadric(axes, exponents, pose, kind)
    rng = np.random.default_rng(label)
    surface = solid.project_radially(solid.to_parent(rng.uniform(-1, 1, (3000, 3)) * axes))
    seen = np.einsum("ij,ij->i", solid.normals(surface), EYE - surface) > 0
    fit = SuperquadricFit(solid, True, "", np.zeros(10), (), 0.0)
    return SceneObject(label, surface[seen], 1000, fit, 1.0, 0)
