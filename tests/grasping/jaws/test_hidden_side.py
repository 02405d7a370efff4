"""Objects that continue behind their visible side: their solids would topple."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from jaw_scenes import EYE, box, can, scene_of
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.grasping import JawOptions, load_hand, plan_grasps
from eyehand.grasping.jaws.scoring import ContactTable, overhang_term
from eyehand.grasping.jaws.surface_model import object_surface

PANDA = load_hand("panda")
UP = np.array([0.0, 0.0, 1.0])


def slab(lean: float, height: float = 0.0):
    """Return a slab of 20 mm whose face is turned to the camera and leans back, on its edge."""
    upright = box((0.08, 0.02, 0.1))
    turn = RigidTransform.from_rotation(Rotation.from_rotvec([-np.radians(lean), 0.0, 0.0]))
    points, solid = turn.apply(upright.points), upright.fit.superquadric
    assert solid is not None
    pose = turn * solid.pose
    low = replace(solid, pose=pose).support(-UP[None])[0]
    lift = RigidTransform.from_translation([0.0, 0.0, low + height])
    points, leaning = lift.apply(points), replace(solid, pose=lift * pose)
    facing = np.einsum("ij,ij->i", leaning.normals(points), EYE - points) > 0.0
    fit = replace(upright.fit, superquadric=leaning)
    return replace(upright, points=points[facing], fit=fit)


@pytest.mark.parametrize(
    ("item", "stands"),
    [
        (slab(0.0), True),
        (slab(30.0), False),
        (replace(slab(30.0), rests_on=2), False),
        (slab(0.0, height=0.05), False),
        (replace(slab(0.0, height=0.05), rests_on=2), True),
        (can(0.03, 0.1), True),
    ],
)
def test_solid_that_would_topple_or_floats_does_not_stand(item, stands):
    surface = object_surface(item, scene_of(item))
    assert surface is not None
    assert surface.stands == stands


def test_no_safe_grasp_puts_a_finger_behind_an_object_that_must_be_thicker():
    grasps = plan_grasps(scene_of(slab(35.0)), PANDA, JawOptions(per_object=40, depth_error=0.005))
    # With at most half of both fingertips in hidden space, the term is at least (1 - 0.8 / 2)².
    entering = [grasp for grasp in grasps if grasp.terms["behind"] < 0.36]
    assert entering
    assert not any(grasp.safe for grasp in entering)
    assert all(any("hides" in text for text in grasp.forbidden_by) for grasp in entering)


def test_hidden_overhang_holds_less_than_an_upright_or_a_seen_side():
    angles = np.radians([0.0, 20.0, 50.0])
    closing = np.stack([np.cos(angles), np.zeros(3), -np.sin(angles)], axis=1)
    nothing = np.zeros(3)

    def term(seen: list[float]):
        contact = ContactTable(
            nothing, np.ones((3, 2)), np.tile(seen, (3, 1)), nothing, np.zeros((3, 3))
        )
        return overhang_term(contact, closing, UP, JawOptions())

    hidden = term([0.0, 1.0])
    assert hidden[0] == 1.0
    assert hidden[0] > hidden[1] > hidden[2]
    assert hidden[2] < 0.2
    np.testing.assert_array_equal(term([1.0, 0.0]), 1.0)


def test_reading_on_a_side_that_the_camera_cannot_see_has_no_normal():
    item = box((0.06, 0.06, 0.06))
    behind = np.array([[x, 0.03, z] for x in (-0.01, 0.0, 0.01) for z in (0.02, 0.03)])
    item = replace(item, points=np.concatenate([item.points, behind]))
    surface = object_surface(item, scene_of(item))
    assert surface is not None
    measured = surface.normals[: surface.measured]
    assert np.count_nonzero(~measured.any(axis=1)) >= len(behind) / 2
    assert measured[:, 1].max() < 0.9
