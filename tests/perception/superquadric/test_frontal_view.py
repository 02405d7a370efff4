"""Tests of the doubt about the depth of a frontal view."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Superquadric, fit_superquadric
from eyehand.perception.superquadric import sample_surface
from eyehand.perception.superquadric.frontal_view import is_depth_unseen
from eyehand.perception.superquadric.view_evidence import ViewEvidence

TABLE = np.array([0.0, 0.0, 1.0, 0.0])
HALF = np.array([0.04, 0.06, 0.09])


def box(depth=HALF[0], turn=0.0):
    pose = RigidTransform.from_components([0, 0, HALF[2]], Rotation.from_euler("z", turn))
    return Superquadric(np.array([depth, *HALF[1:]]), (0.1, 0.1), pose, "box")


def view_of(solid, elevation, plane: np.ndarray | None = TABLE):
    """Return what a camera in the xz-plane sees of a solid from 0.7 m."""
    angle = np.radians(elevation)
    origin = solid.centre + 0.7 * np.array([-np.cos(angle), 0.0, np.sin(angle)])
    rng = np.random.default_rng(0)
    points = sample_surface(solid, 3000, rng)
    seen = np.einsum("ij,ij->i", origin - points, solid.normals(points)) > 0
    points = points[seen] + 0.0005 * rng.normal(size=(int(seen.sum()), 3))
    return ViewEvidence(points, 0.0005, origin, plane)


def test_front_of_a_box_does_not_show_its_depth():
    evidence = view_of(box(), 0.0)
    assert is_depth_unseen([box()], evidence)
    # A plate behind the front is no better.
    assert is_depth_unseen([box(0.002)], evidence)


@pytest.mark.parametrize("elevation", [15.0, 35.0, 60.0])
def test_higher_view_shows_the_depth(elevation):
    assert not is_depth_unseen([box()], view_of(box(), elevation))


def test_side_faces_show_the_depth():
    assert not is_depth_unseen([box(turn=0.8)], view_of(box(turn=0.8), 5.0))


def test_round_front_shows_the_depth():
    can = Superquadric(
        np.array([0.04, 0.04, 0.06]), (0.1, 1.0), RigidTransform.from_translation([0, 0, 0.06])
    )
    assert not is_depth_unseen([can], view_of(can, 5.0))


def test_nothing_is_said_without_a_camera_or_solid():
    evidence = view_of(box(), 0.0)
    assert not is_depth_unseen([], evidence)
    assert not is_depth_unseen([box()], ViewEvidence(evidence.points, 0.0005))
    assert is_depth_unseen([box()], view_of(box(), 0.0, plane=None))


def test_fit_of_a_front_states_the_doubt():
    evidence = view_of(box(), 3.0)
    fit = fit_superquadric(evidence.points, view_origin=evidence.view_origin, support_plane=TABLE)
    assert fit.superquadric is not None
    assert fit.depth_unseen
    oblique = view_of(box(turn=0.6), 40.0)
    assert not fit_superquadric(
        oblique.points, view_origin=oblique.view_origin, support_plane=TABLE
    ).depth_unseen
