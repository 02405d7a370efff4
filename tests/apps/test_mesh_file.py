"""Meshes are equal after writing and reading in every format."""

import io

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import RigidTransform

from eyehand.apps.mesh_file import mesh_bytes
from eyehand.perception import Superquadric, read_cloud
from eyehand.perception.superquadric import mesh

SOLID = Superquadric(
    np.array([0.05, 0.03, 0.02]), (0.5, 0.6), RigidTransform.from_translation([1.0, 2.0, 3.0])
)


@pytest.mark.parametrize("form", ["ply", "stl", "obj"])
def test_written_mesh_is_closed_and_has_the_volume(form, tmp_path):
    encoded = mesh_bytes(*mesh(SOLID, 64), form)
    surface = trimesh.load_mesh(io.BytesIO(encoded), file_type=form)
    assert surface.is_watertight
    assert surface.volume == pytest.approx(SOLID.volume, rel=0.01)
    assert surface.center_mass == pytest.approx(SOLID.centre, abs=1e-4)
    path = tmp_path / f"solid.{form}"
    path.write_bytes(encoded)
    points = read_cloud(path, samples=500)
    assert np.abs(SOLID.distance(points)).max() < 5e-4
