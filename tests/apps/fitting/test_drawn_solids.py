"""Vessels in pictures, on pages and in mesh files."""

import numpy as np

from eyehand.apps.drawn_solids import drawn_solids, solid_curves, solid_mesh
from eyehand.apps.fitting.picture_scene import picture_scene
from eyehand.apps.fitting.solid_files import solid_files
from eyehand.perception.superquadric import Vessel


def enclosed(vertices, faces):
    """Return the volume inside a closed mesh, m³."""
    first, second, third = np.moveaxis(vertices[faces], 1, 0)
    return float(np.sum(first * np.cross(second, third)) / 6.0)


def test_vessel_is_drawn_in_place_of_its_outer_solid(mug, can):
    vessel, handle = drawn_solids(mug.fit)
    assert isinstance(vessel, Vessel)
    assert handle is mug.fit.parts[1]
    assert drawn_solids(can.fit) == can.fit.parts


def test_mesh_has_the_cavity(mug):
    vessel, handle = drawn_solids(mug.fit)
    assert isinstance(vessel, Vessel)
    assert enclosed(*solid_mesh(vessel, 48)) < 0.4 * enclosed(*solid_mesh(vessel.outer, 48))
    assert enclosed(*solid_mesh(handle, 48)) > 0.0


def test_no_line_crosses_the_opening(mug):
    vessel = drawn_solids(mug.fit)[0]
    assert isinstance(vessel, Vessel)
    rim, *others = solid_curves(vessel)
    assert np.allclose(rim[0], rim[-1])
    assert np.allclose(vessel.heights(rim), 0.0)
    assert others
    assert all(vessel.heights(curve).max() < -0.001 for curve in others)


def test_picture_and_files_contain_the_vessel(mug):
    scene = picture_scene(mug)
    assert len(scene.surfaces) == 2
    assert scene.limit_mm < 10.0
    files = solid_files(mug, form="stl", density=1000.0)
    # Rim and inside take more triangles than the closed bodies of the robot files.
    assert len(files["mug_solid.stl"]) > len(files["mug_body_1.stl"])
